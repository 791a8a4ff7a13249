#pragma once
/// Particles as passed to observers: of one block of a running computation, or of a stored frame.

#include <array>
#include <limits>

#include "libmpm/base/types.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/io/snapshot.hpp"

namespace mpm {

/// One particle, in the coordinates of the case and in SI units.
struct ParticleView {
  Vec3 position;                 ///< m
  std::array<double, 6> stress;  ///< Kirchhoff tau, Pa, tension positive: xx yy zz xy xz yz
  double internal;               ///< the law's internal variable
  double mass;                   ///< kg, as computed: not doubled for a mirror plane
  const AnyMaterial* material;   ///< null in a frame
  double stored_volume_ratio;    ///< of a frame

  /// J = det F: volume over reference volume. For a particle of a running computation the law computes it, which takes more time than the
  /// other values.
  [[nodiscard]] double volume_ratio() const {
    if (material == nullptr) return stored_volume_ratio;
    return mpm::volume_ratio(*material, {{stress[0], stress[1], stress[2], stress[3], stress[4], stress[5]}, internal});
  }
};

/// Particles that lie in one box. Observers add them up in the order of the batches and of the particles in each: the same bits on any
/// number of threads.
class ParticleBatch {
 public:
  /// The particles of one block of a state. @param cell_size dx, m
  ParticleBatch(const Block& block, const Scene& scene, double cell_size)
      : density_(density_of(scene.material)), bin_(&block.particles), scene_(&scene) {
    const Eigen::AlignedBox3d box = block_box(block.coordinate, cell_size);
    low = box.min() - scene.offset;
    high = box.max() - scene.offset;
  }
  /// All particles of a frame, in the order of their identity numbers.
  explicit ParticleBatch(const Snapshot& frame) : density_(frame.info.reference_density), frame_(&frame.particles) {}

  /// m: corners of a box that holds the particles, for an observer that can skip it; infinite for a frame.
  /// @{
  Vec3 low = Vec3::Constant(-std::numeric_limits<double>::infinity()), high = Vec3::Constant(std::numeric_limits<double>::infinity());
  /// @}

  [[nodiscard]] std::size_t size() const {
    return bin_ != nullptr ? static_cast<std::size_t>(bin_->count()) : frame_->size();
  }  ///< number of particles

  /// @param i  below size()
  [[nodiscard]] ParticleView operator[](std::size_t i) const {
    if (bin_ != nullptr) {
      const Particle p = (*bin_)[static_cast<int>(i)];
      return {position_of(p) - scene_->offset, std::to_array(p.stress), p.internal, density_ * p.volume, &scene_->material, 1.0};
    }
    const ParticleTable& t = *frame_;
    ParticleView v{Vec3(t.position[3 * i], t.position[3 * i + 1], t.position[3 * i + 2]),
                   {},
                   t.internal[i],
                   density_ * t.volume[i],
                   nullptr,
                   t.volume_ratio[i]};
    std::copy_n(&t.stress[6 * i], 6, v.stress.begin());
    return v;
  }

 private:
  double density_;
  const ParticleBin* bin_ = nullptr;
  const Scene* scene_ = nullptr;
  const ParticleTable* frame_ = nullptr;
};

}  // namespace mpm
