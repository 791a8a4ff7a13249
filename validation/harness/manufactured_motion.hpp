#pragma once
/// A prescribed motion that a body force enforces on an elastic material: the computed motion is compared with it, particle by particle.

#include <cstddef>
#include <functional>
#include <vector>

#include "libmpm/core/step.hpp"
#include "libmpm/material/hencky_elastic.hpp"
#include "validation/harness/in_parallel.hpp"

namespace mpm::validation {

/// The exact motion, and what follows from it. Every function takes the position X of a point at t = 0, m, and the time, s.
class ManufacturedMotion {
 public:
  ManufacturedMotion() = default;
  ManufacturedMotion(const ManufacturedMotion&) = delete;
  ManufacturedMotion& operator=(const ManufacturedMotion&) = delete;
  virtual ~ManufacturedMotion() = default;
  [[nodiscard]] virtual Vec3 position(const Vec3& reference, double t) const = 0;    ///< x, m
  [[nodiscard]] virtual Vec3 velocity(const Vec3& reference, double t) const = 0;    ///< m/s
  [[nodiscard]] virtual Mat3 gradient(const Vec3& reference, double t) const = 0;    ///< L = dv/dx, 1/s
  [[nodiscard]] virtual Mat3 stress(const Vec3& reference, double t) const = 0;      ///< Kirchhoff stress tau, Pa
  [[nodiscard]] virtual Vec3 body_force(const Vec3& reference, double t) const = 0;  ///< b, m/s^2
};

/// A point of the material at a time.
struct MotionPoint {
  Vec3 reference = Vec3::Zero();  ///< X, m
  double time = 0.0;              ///< s
};

/// Points of the ring between two radii, m, spread over the ring and over the period, s.
std::vector<MotionPoint> points_of_ring(double inner, double outer, double period);

/// Largest residual of rho_0 x'' = Div P + rho_0 b in the plane z = constant over the largest rho_0 |b| of the points, by central
/// differences of position() alone: F, Hencky's stress from the eigenvalues of F F^T, P = tau F^-T, and Div P.
/// @param step  of the differences, m and s
double momentum_residual(const ManufacturedMotion& motion, const HenckyElastic::Parameters& law, const std::vector<MotionPoint>& points,
                         double step = 1e-4);

/// How a motion is followed.
struct FollowSetting {
  double period = 1.0;                                                    ///< s; the motion has its largest amplitude at half of it
  int steps = 2;                                                          ///< in the period; even
  std::size_t judged = 1;                                                 ///< number of particles over which squared errors are averaged
  std::function<void(const Particle&, const Vec3& reference)> half = {};  ///< called for every particle at half the period, if any
};

/// Errors over one period.
struct MotionErrors {
  double displacement = 0.0;          ///< largest of `history`
  double stress = 0.0;                ///< L2 error of tau at half the period over the largest |tau|
  std::vector<double> time, history;  ///< periods; L2 error of the displacement, m
  double particle_steps = 0.0;
};

/// Gives the particles the exact velocities and gradients at -dt/2 (velocities live at half steps), and in every step the exact body force.
/// @param reference  X by identity number (reference_positions)
MotionErrors follow(State& state, const Scene& scene, const ManufacturedMotion& motion, const std::vector<Vec3>& reference,
                    const FollowSetting& setting);

/// Computes some variants on some grids, several at a time and the finest grids first, because they take longest.
/// @param errors  (number of the variant, cells): an Errors. @returns them by variant and grid
template <class Errors, class F>
std::vector<std::vector<Errors>> on_grids(std::size_t variants, const std::vector<int>& grids, F&& errors) {
  std::vector<std::vector<Errors>> all(variants, std::vector<Errors>(grids.size()));
  in_parallel(variants * grids.size(), [&](std::size_t i) {
    const std::size_t v = i % variants, g = grids.size() - 1 - i / variants;
    all[v][g] = errors(v, grids[g]);
  });
  return all;
}

}  // namespace mpm::validation
