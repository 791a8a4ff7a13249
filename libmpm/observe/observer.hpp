#pragma once
/// Each measured quantity is an observer: one file with its columns, its entries of results.json, its sums and its saved state. They are
/// listed in driver/observers.cpp; run, replay, checkpoint and files are loops over that list (observer_list.hpp).

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/impact/steady.hpp"
#include "libmpm/io/snapshot.hpp"
#include "libmpm/observe/results.hpp"
#include "libmpm/observe/time_series.hpp"

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

/// Progress of a run.
struct RunProgress {
  std::uint64_t samples = 0;            ///< rows of series.csv
  std::uint64_t particle_steps = 0;     ///< sum over steps of the particles moved
  std::uint64_t initial_particles = 0;  ///< at t = 0
  double wall_time = 0.0;               ///< s, including the time before a resume
  double step_time = 0.0;               ///< s, part of wall_time in the solver

  /// Million particle-steps per second of wall time; 0 at the start.
  [[nodiscard]] double speed() const { return wall_time > 0.0 ? 1e-6 * static_cast<double>(particle_steps) / wall_time : 0.0; }
};

/// A state at a sample.
struct LiveState {
  const State& state;  ///< positions in grid coordinates: x + Scene::offset
  const Scene& scene;  ///< of the run of that state
  Totals totals;       ///< of the computed part, without the images of mirror planes
};

/// One sample.
struct Instant {
  double time = 0.0;                ///< s
  double interval = 0.0;            ///< s since the previous sample; 0 at the first
  const LiveState* live = nullptr;  ///< null for a stored frame, which observers of MeasuredFrom::run do not measure
};

/// A quantity over height.
struct HeightProfile {
  Column column;                  ///< of profile.csv
  std::vector<double> mean;       ///< over the steady interval, one value a bin: a column of profile.csv
  std::vector<double> over_time;  ///< one value a bin for each sample, sample by sample: a dataset of profiles.h5; empty: none
};

/// Input of the entries of results.json, at the end of a run or of the frames.
struct Summary {
  const TimeSeries& series;                  ///< all samples
  Steady span = {};                          ///< the steady interval; none: steady is false
  const State* state = nullptr;              ///< at the end; null for frames, which observers of MeasuredFrom::run do not measure
  const RunProgress* progress = nullptr;     ///< at the end; null for frames
  std::vector<HeightProfile> profiles = {};  ///< of all observers, in their order
  std::string profile = {};                  ///< content of profile.csv; empty: there is none

  /// The values in the steady interval; empty without one. @param values  one for each sample
  [[nodiscard]] std::span<const double> steady_part(std::span<const double> values) const;
  /// Mean of a column over the steady interval; all members are NaN without one.
  [[nodiscard]] MeanEstimate mean(std::string_view column) const;
  /// The same for a quantity without a column. @param values  one for each sample
  [[nodiscard]] MeanEstimate mean(std::span<const double> values) const;
  /// Largest finite value of a column; NaN without one.
  [[nodiscard]] double peak(std::string_view column) const;
  /// Mean over the steady interval of `width` values a sample, sample by sample; empty without a steady interval.
  [[nodiscard]] std::vector<double> mean_rows(std::span<const double> values, std::size_t width) const;
};

/// A component that measures. Its functions are called in the order in which they are declared here: begin at the start and after a resume,
/// after_step after every step, then at each sample visit for all particles, sample, check, may_end; at the end summary and profiles.
class Observer {
 public:
  virtual ~Observer() = default;

  /// Short, unique, "contact_force": heading of tables, and prefix of its arrays in a checkpoint.
  [[nodiscard]] virtual std::string name() const = 0;
  /// Whether stored frames suffice to compute its columns and results. Otherwise a replay copies them from the run.
  [[nodiscard]] virtual MeasuredFrom measured_from() const { return MeasuredFrom::frames; }
  /// Its columns of series.csv.
  [[nodiscard]] virtual std::vector<Column> columns() const { return {}; }

  /// A run starts, or continues after load().
  virtual void begin(const State& /*state*/, const Scene& /*scene*/) {}
  /// Called after every step, for sums over all steps.
  virtual void after_step(const StepReport& /*report*/, const State& /*state*/) {}
  /// Whether visit() has to see the particles of a box. The answer must not depend on the state; an observer with a visit() overrides this.
  /// The arguments are the lowest and the highest corner of the box, m.
  [[nodiscard]] virtual bool visits(const Vec3& /*low*/, const Vec3& /*high*/) const { return false; }
  /// All particles of the boxes that it visits, batch by batch.
  virtual void visit(const ParticleBatch& /*batch*/) {}
  /// Fills its row, one number for each of columns(), NaN where a value is unknown, and resets its sums.
  virtual void sample(const Instant& /*now*/, std::span<double> /*row*/) {}
  /// Called after the row and the frame are written. @return warnings for the log. @throws UnstableError
  virtual std::vector<std::string> check(const Instant& /*now*/) { return {}; }
  /// Whether the run may end after the last row of the series, before its duration. Depends on the series alone.
  [[nodiscard]] virtual bool may_end(const TimeSeries& /*series*/) const { return false; }

  /// The steady interval, over which all means are taken; one observer of a list may determine it.
  [[nodiscard]] virtual std::optional<Steady> steady_interval(const TimeSeries& /*series*/) const { return std::nullopt; }
  /// Its entries of results.json: always the same, unknown ones as NaN, so that they can be listed without a run.
  [[nodiscard]] virtual std::vector<Result> summary(const Summary& /*end*/) const { return {}; }
  /// Its quantities over height; always the same columns.
  [[nodiscard]] virtual std::vector<HeightProfile> profiles(const Summary& /*end*/) const { return {}; }

  /// Its state from sample to sample, besides its columns. Called at a sample, when all sums are reset.
  [[nodiscard]] virtual Arrays save() const { return {}; }
  /// Restores the state that save() returned after that many samples. @throws IoError for arrays that cannot come from save()
  virtual void load(const Arrays& /*arrays*/, std::size_t /*samples*/) {}
};

}  // namespace mpm
