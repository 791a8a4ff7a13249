#pragma once
/// Sums over all particles, written from the definitions and not taken from the library: the cases check the library with them.

#include <Eigen/Geometry>
#include <variant>

#include "mpm/solver.hpp"

namespace mpm::validation {

struct Totals {
  std::size_t count = 0;
  double mass = 0.0;                     ///< kg
  Vec3 centre = Vec3::Zero();            ///< centre of mass, m
  Vec3 momentum = Vec3::Zero();          ///< N s
  double momentum_scale = 0.0;           ///< sum m |v|, N s: what round-off of the momentum is measured against
  Vec3 angular_momentum = Vec3::Zero();  ///< about the origin, with the affine part of APIC, N m s
  double angular_momentum_scale = 0.0;   ///< sum m |x||v|
  double kinetic_energy = 0.0;           ///< with the affine part, J
  double elastic_energy = 0.0;           ///< J
};

/// Angular momentum of a particle in APIC: m x cross v + m (dx^2/4) eps : C (Jiang et al. 2015, for quadratic B-splines D = dx^2/4 I);
/// kinetic energy likewise m/2 (|v|^2 + dx^2/4 |C|^2).
inline Totals sum_particles(const State& state, const Scene& scene) {
  Totals t;
  const double density = std::visit([](const auto& law) { return law.density(); }, scene.material);
  const bool affine = scene.transfer == Transfer::apic;
  const double d = affine ? 0.25 * state.grid.cell_size() * state.grid.cell_size() : 0.0;
  Vec3 first_moment = Vec3::Zero();
  state.grid.for_each_particle([&](const Particle& p) {
    const double m = density * p.volume;
    const Vec3 x(p.position[0], p.position[1], p.position[2]), v(p.velocity[0], p.velocity[1], p.velocity[2]);
    const Mat3 c = Eigen::Map<const Mat3>(p.affine);  // columns, as Eigen stores them
    ++t.count;
    t.mass += m;
    first_moment += m * x;
    t.momentum += m * v;
    t.momentum_scale += m * v.norm();
    t.angular_momentum += m * (x.cross(v) + d * Vec3(c(2, 1) - c(1, 2), c(0, 2) - c(2, 0), c(1, 0) - c(0, 1)));
    t.angular_momentum_scale += m * x.norm() * v.norm();
    t.kinetic_energy += 0.5 * m * (v.squaredNorm() + d * c.squaredNorm());
    const MaterialState<double> s{{p.stress[0], p.stress[1], p.stress[2], p.stress[3], p.stress[4], p.stress[5]}, p.internal};
    t.elastic_energy += p.volume * std::visit([&](const auto& law) { return law.stored_energy(s); }, scene.material);
  });
  t.centre = first_moment / t.mass;
  return t;
}

}  // namespace mpm::validation
