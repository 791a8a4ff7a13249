#include "validation/harness/manufactured_motion.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "validation/harness/norms.hpp"

namespace mpm::validation {

std::vector<MotionPoint> points_of_ring(double inner, double outer, double period) {
  std::vector<MotionPoint> points;
  for (int n = 0; n < 200; ++n) {
    const double radius = inner + 0.01 + (outer - inner - 0.02) * (0.3711 * n - std::floor(0.3711 * n)), angle = 2.399 * n;
    points.push_back({Vec3(radius * std::cos(angle), radius * std::sin(angle), 0.0), period * (0.2719 * n - std::floor(0.2719 * n))});
  }
  return points;
}

double momentum_residual(const ManufacturedMotion& motion, const HenckyElastic::Parameters& law, const std::vector<MotionPoint>& points,
                         double h) {
  const double shear = law.young_modulus / (2.0 * (1.0 + law.poisson_ratio));
  const double lame = law.young_modulus * law.poisson_ratio / ((1.0 + law.poisson_ratio) * (1.0 - 2.0 * law.poisson_ratio));
  const auto piola = [&](const Vec3& x, double t) {
    Mat3 f;
    for (int j = 0; j < 3; ++j)
      f.col(j) = (motion.position(x + h * Vec3::Unit(j), t) - motion.position(x - h * Vec3::Unit(j), t)) / (2.0 * h);
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(f * f.transpose());
    const Vec3 strain = 0.5 * eigen.eigenvalues().array().log();
    const Vec3 tau = Vec3::Constant(lame * strain.sum()) + 2.0 * shear * strain;
    return Mat3(eigen.eigenvectors() * tau.asDiagonal() * eigen.eigenvectors().transpose() * f.inverse().transpose());
  };
  double worst = 0.0, scale = 0.0;
  for (const auto& [x, t] : points) {
    const Vec3 acceleration = (motion.position(x, t + h) - 2.0 * motion.position(x, t) + motion.position(x, t - h)) / (h * h);
    Vec3 divergence = Vec3::Zero();
    for (int j = 0; j < 2; ++j) divergence += (piola(x + h * Vec3::Unit(j), t) - piola(x - h * Vec3::Unit(j), t)).col(j) / (2.0 * h);
    const Vec3 b = motion.body_force(x, t);
    scale = larger(scale, law.density * b.norm());
    worst = larger(worst, (law.density * (acceleration - b) - divergence).norm());
  }
  return worst / scale;
}

MotionErrors follow(State& state, const Scene& scene, const ManufacturedMotion& motion, const std::vector<Vec3>& reference,
                    const FollowSetting& setting) {
  const double dt = setting.period / setting.steps;
  state.grid.change_particles([&](Particle& p) {
    const Vec3 v = motion.velocity(reference[p.id], -0.5 * dt);
    const Mat3 l = motion.gradient(reference[p.id], -0.5 * dt);
    for (int i = 0; i < 3; ++i) p.velocity[i] = v[i];
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) p.affine[3 * j + i] = l(i, j);
  });
  const auto judged = static_cast<double>(setting.judged);
  MotionErrors e;
  for (int n = 0; n < setting.steps; ++n) {
    const double t = n * dt, next = (n + 1) * dt;
    state.grid.change_particles([&](Particle& p) {
      const Vec3 b = motion.body_force(reference[p.id], t);
      for (int i = 0; i < 3; ++i) p.velocity[i] += dt * b[i];
    });
    step(state, scene, dt);
    e.particle_steps += static_cast<double>(state.grid.particle_count());
    const bool half = 2 * (n + 1) == setting.steps;
    if (!half && (n + 1) % std::max(1, setting.steps / 40) != 0) continue;
    double squares = 0.0, stress = 0.0, largest = 0.0;
    state.grid.for_each_particle([&](const Particle& p) {
      const Vec3& x = reference[p.id];
      squares += (Vec3(p.position[0], p.position[1], p.position[2]) - motion.position(x, next)).squaredNorm();
      if (!half) return;
      const Mat3 tau = motion.stress(x, next);
      Mat3 ours;
      ours << p.stress[0], p.stress[3], p.stress[4], p.stress[3], p.stress[1], p.stress[5], p.stress[4], p.stress[5], p.stress[2];
      stress += (ours - tau).squaredNorm();
      largest = larger(largest, tau.norm());
      if (setting.half) setting.half(p, x);
    });
    e.time.push_back(next / setting.period);
    e.history.push_back(std::sqrt(squares / judged));
    if (!(e.history.back() <= e.displacement)) e.displacement = e.history.back();
    if (half) e.stress = std::sqrt(stress / judged) / largest;
  }
  return e;
}

}  // namespace mpm::validation
