#include "libmpm/core/diagnostics.hpp"

#include <Eigen/Geometry>

#include "libmpm/core/block_sums.hpp"
#include "libmpm/core/stress_update.hpp"

namespace mpm {

namespace {

/// D of APIC, sum w (x_i - x_p)^2 = dx^2/4 for quadratic B-splines: moment of inertia per mass of the affine velocities. 0 with other
/// transfers.
double affine_inertia_of(const Scene& scene, double cell_size) {
  return scene.numerics.transfer == Transfer::apic ? 0.25 * cell_size * cell_size : 0.0;
}

}  // namespace

double kinetic_and_elastic_energy(const Particle& p, const Scene& scene, double cell_size) {
  const double specific = Eigen::Map<const Vec3>(p.velocity).squaredNorm() +
                          affine_inertia_of(scene, cell_size) * Eigen::Map<const Mat3>(p.affine).squaredNorm();
  return 0.5 * density_of(scene.material) * p.volume * specific + stored_energy(scene.material, p);
}

Totals totals(const State& state, const Scene& scene) {
  Ranks& ranks = state.grid.ranks();
  ranks.instruct(CoreTask::totals, state);
  const auto blocks = state.grid.occupied_blocks();
  std::vector<Totals> partial(blocks.size());
  const double density = density_of(scene.material);
  const double affine_inertia = affine_inertia_of(scene, state.grid.cell_size());
#pragma omp parallel for schedule(dynamic, 8)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const ParticleBin& bin = state.grid.block(blocks[i]).particles;
    Totals& sum = partial[i];
    for (int s = 0; s < bin.count(); ++s) {
      const Particle p = bin[s];
      const double m = density * p.volume;
      const Vec3 x = position_of(p) - scene.offset, v = velocity_of(p);
      const Vec3 spin(p.affine[5] - p.affine[7], p.affine[6] - p.affine[2],
                      p.affine[1] - p.affine[3]);  // C_zy - C_yz, C_xz - C_zx, C_yx - C_xy
      ++sum.particles;
      sum.mass += m;
      sum.centre += m * x;
      sum.momentum += m * v;
      sum.momentum_scale += m * v.norm();
      sum.angular_momentum += m * (x.cross(v) + affine_inertia * spin);
      sum.angular_momentum_scale += m * x.norm() * v.norm();
      sum.kinetic_energy += 0.5 * m * v.squaredNorm();
      sum.affine_energy += 0.5 * m * affine_inertia * Eigen::Map<const Mat3>(p.affine).squaredNorm();
      sum.elastic_energy += stored_energy(scene.material, p);
      sum.potential_energy -= m * scene.gravity.dot(x);
    }
  }
  constexpr std::size_t counts = 1;  // its first member
  BlockSums sums(sizeof(Totals) / sizeof(double));
  for (const Totals& part : partial) sums.add_members<counts>(0, part);
  sums.add_ranks(ranks);
  ranks.done();
  Totals sum = sums.members<Totals, counts>(0);
  if (sum.mass > 0.0) sum.centre /= sum.mass;
  return sum;
}

Vec3 whole_force(const Vec3& part, const MirrorPlanes& mirror) {
  Vec3 whole = part;
  if (mirror.x) whole = Vec3(0.0, 2.0 * whole.y(), 2.0 * whole.z());
  if (mirror.y) whole = Vec3(2.0 * whole.x(), 0.0, 2.0 * whole.z());
  return whole;
}

Vec3 whole_moment(const Vec3& part, const MirrorPlanes& mirror) {
  Vec3 whole = part;
  if (mirror.x) whole = Vec3(2.0 * whole.x(), 0.0, 0.0);
  if (mirror.y) whole = Vec3(0.0, 2.0 * whole.y(), 0.0);
  return whole;
}

Totals whole_of_mirrored(Totals t, const MirrorPlanes& mirror) {
  const double factor = mirror.parts();
  t.particles *= static_cast<std::uint64_t>(factor);
  t.mass *= factor;
  t.momentum_scale *= factor;
  t.angular_momentum_scale *= factor;
  t.kinetic_energy *= factor;
  t.affine_energy *= factor;
  t.elastic_energy *= factor;
  t.potential_energy *= factor;
  if (mirror.x) t.centre.x() = 0.0;
  if (mirror.y) t.centre.y() = 0.0;
  t.momentum = whole_force(t.momentum, mirror);
  t.angular_momentum = whole_moment(t.angular_momentum, mirror);
  return t;
}

}  // namespace mpm
