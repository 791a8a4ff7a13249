#pragma once
/// Small cases, random particles and comparisons of states for the tests of the solver.

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

#include "libmpm/base/bspline.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/driver/case.hpp"
#include "libmpm/driver/scene.hpp"

namespace mpm::testing {

/// Tests use one thread by default: their states are small, and while other tests use all cores, a barrier takes longer than the whole
/// step.
inline const bool on_one_thread = (omp_set_num_threads(1), true);

using mpm::position_of;
using mpm::velocity_of;
/// C, [i][j] = dv_i/dx_j
inline Mat3 affine_of(const Particle& p) { return Eigen::Map<const Mat3>(p.affine); }
inline Mat3 stress_of(const Particle& p) {
  Mat3 t;
  t << p.stress[0], p.stress[3], p.stress[4], p.stress[3], p.stress[1], p.stress[5], p.stress[4], p.stress[5], p.stress[2];
  return t;
}
inline void set_affine(Particle& p, const Mat3& c) { Eigen::Map<Mat3>(p.affine) = c; }

inline Particle particle_at(const Vec3& x, std::uint64_t id = 0, double volume = 1e-3) {
  Particle p{};
  std::copy_n(x.data(), 3, p.position);
  p.volume = volume;
  p.id = id;
  return p;
}

/// Every field but the position filled with random numbers of the sizes that snow has.
inline void randomise(Particle& p, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  p.volume = 1e-3 * (1.5 + unit(random));
  for (double& v : p.velocity) v = 5.0 * unit(random);
  for (double& c : p.affine) c = 20.0 * unit(random);
  for (double& s : p.stress) s = 1e4 * unit(random);
  p.internal = 0.01 * unit(random);
}

/// All particles in storage order (blocks by coordinate, slots ascending).
inline std::vector<Particle> stored_particles(const Grid& grid) {
  std::vector<Particle> all;
  grid.for_each_particle([&](const Particle& p) { all.push_back(p); });
  return all;
}
inline std::vector<Particle> particles_by_id(const Grid& grid) {
  auto all = stored_particles(grid);
  std::sort(all.begin(), all.end(), [](const Particle& a, const Particle& b) { return a.id < b.id; });
  return all;
}

inline bool same_bytes(std::span<const Particle> a, std::span<const Particle> b) {
  return std::ranges::equal(std::as_bytes(a), std::as_bytes(b));
}
inline bool same_bytes(const Particle& a, const Particle& b) { return same_bytes(std::span(&a, 1), std::span(&b, 1)); }

/// The particle with this identity number. @throws std::out_of_range
inline Particle particle_of(const Grid& grid, std::uint64_t id) {
  std::optional<Particle> found;
  grid.for_each_particle([&](const Particle& p) {
    if (p.id == id) found = p;
  });
  if (!found) throw std::out_of_range("no particle has this number");
  return *found;
}
/// Changes one particle within its cell: calls f(Particle&). @throws std::out_of_range
template <class F>
void change_particle(Grid& grid, std::uint64_t id, F&& f) {
  (void)particle_of(grid, id);
  grid.change_particles([&](Particle& p) {
    if (p.id == id) f(p);
  });
}

namespace detail {
template <class... P>
std::vector<MaterialParameters> defaults_of(std::type_identity<std::variant<P...>>) {
  return {MaterialParameters(P{})...};
}
}  // namespace detail
/// Every law with its default parameters.
inline std::vector<MaterialParameters> every_law() { return detail::defaults_of(std::type_identity<decltype(MaterialParameters::law)>{}); }

inline MaterialParameters elastic_snow() { return HenckyElastic::Parameters{}; }
inline MaterialParameters cam_clay_snow(double slope, double beta, double xi = 5.0) {
  CamClay::Parameters m;
  m.critical_state_slope = slope;
  m.cohesion_beta = beta;
  m.hardening_xi = xi;
  return m;
}

/// An empty scene: elastic, dx = 0.25 m.
inline Case empty_case() {
  Case c;
  c.material = elastic_snow();
  c.domain.min = Vec3::Constant(-20.0);
  c.domain.max = Vec3::Constant(20.0);
  return c;
}

inline BodySpec box_body(const Vec3& min, const Vec3& max, const Vec3& velocity = Vec3::Zero()) {
  BodySpec b;
  b.min = min;
  b.max = max;
  b.velocity = velocity;
  b.lattice = Lattice::aligned;  // particles where a test expects them
  return b;
}
inline WallSpec wall(const Vec3& point, const Vec3& normal, Contact contact, double friction = 0.0) {
  WallSpec w;
  w.point = point;
  w.normal = normal.normalized();
  w.contact = contact;
  w.friction = friction;
  return w;
}

/// A conveyor of a few thousand particles: H = 1 m, W = 3 m, mast 0.5 m x 0.5 m, window from -2 m to 1.5 m.
inline Case small_avalanche(double velocity = 4.0) {
  Case c;
  c.title = "small avalanche";
  c.material = cam_clay_snow(0.4, 0.0);
  ConveyorSpec conveyor;
  conveyor.velocity = velocity;
  conveyor.flow_height = 1.0;
  conveyor.width = 3.0;
  conveyor.upstream_length = 2.0;
  conveyor.downstream_length = 1.5;
  c.conveyor = conveyor;
  ObstacleSpec mast;
  mast.shape = BoxShape{.width = 0.5, .depth = 0.5};
  c.obstacle = mast;
  return c;
}

}  // namespace mpm::testing
