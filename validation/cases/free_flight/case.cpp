#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <limits>
#include <numbers>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"

namespace mpm::validation {
namespace {

constexpr double edge = 1.0, duration = 1.0, gravity = 9.81;
const Vec3 throw_velocity(3.0, 1.0, 6.0);
const Vec3 axis = Vec3(1.0, 2.0, 3.0).normalized();
constexpr double spin = 2.0 * std::numbers::pi;  // rad/s: one turn in the duration

Case thrown_cube() {
  Case c;
  c.title = "thrown cube";
  c.material = HenckyElastic::Parameters{};
  c.material.set_density(300.0);
  c.material.as<HenckyElastic>().young_modulus = 1e8;
  c.material.as<HenckyElastic>().poisson_ratio = 0.1;
  c.numerics.cell_size = 0.25;
  c.numerics.gravity = gravity;
  c.bodies.push_back({BodySpec::Shape::box, Vec3::Constant(-0.5 * edge), Vec3::Constant(0.5 * edge), throw_velocity});
  return c;
}

/// Rigid rotation: v += omega cross x and the matching affine part.
void set_spinning(State& state) {
  const Vec3 omega = spin * axis;
  Mat3 cross;
  cross << 0, -omega.z(), omega.y(), omega.z(), 0, -omega.x(), -omega.y(), omega.x(), 0;
  for (const auto b : state.grid.occupied_blocks()) {
    auto& particles = state.grid.block(b).particles;
    for (int s = 0; s < particles.count(); ++s) {
      Particle& p = particles[s];
      Eigen::Map<Vec3> v(p.velocity);
      v += omega.cross(Eigen::Map<const Vec3>(p.position));
      Eigen::Map<Mat3> c(p.affine);
      c = cross;
    }
  }
}

std::vector<Vec3> positions_by_id(const State& state) {
  std::vector<Vec3> x(state.grid.particle_count());
  state.grid.for_each_particle([&](const Particle& p) { x[p.id] = Vec3(p.position[0], p.position[1], p.position[2]); });
  return x;
}

/// Best-fit rotation of b onto a about their means (Kabsch).
Mat3 best_rotation(const std::vector<Vec3>& from, const std::vector<Vec3>& to, const Vec3& from_mean, const Vec3& to_mean) {
  Mat3 h = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) h += (to[i] - to_mean) * (from[i] - from_mean).transpose();
  const Eigen::JacobiSVD<Mat3> svd(h, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0.0) u.col(2) *= -1.0;
  return u * svd.matrixV().transpose();
}

/// A block of loose snow thrown straight up: how high it rises, which is what a run-up measures.
void ballistic_rise(const CaseContext& context, CaseResult& result) {
  Case c = read_case(context.case_directory() / "case.toml");
  const Scene scene = make_scene(c);
  const double speed = c.bodies[0].velocity.z(), rise = 0.5 * speed * speed / c.numerics.gravity,
               flight_time = 2.0 * speed / c.numerics.gravity;
  const State first = make_state(c, scene);
  const int coarse_steps = static_cast<int>(std::ceil(flight_time / stable_time_step(first, scene)));
  const std::vector<Vec3> start = positions_by_id(first);
  std::vector<double> steps, errors;
  Series flight{"simulation, highest particle", {}, {}, Series::Style::points};
  for (const int n : {coarse_steps, 2 * coarse_steps, context.choose(4, 4, 8) * coarse_steps}) {
    State state = make_state(c, scene);
    const double dt = flight_time / n;
    const bool finest = steps.size() == 2;
    double top = 0.0, apart = 0.0;
    for (int i = 1; i <= n; ++i) {
      step(state, scene, dt);
      double highest = -1e9, lowest = 1e9;  // rise of the particle that rose most and least
      state.grid.for_each_particle([&](const Particle& p) {
        const double risen = p.position[2] - start[p.id].z();
        highest = std::max(highest, risen);
        lowest = std::min(lowest, risen);
      });
      top = std::max(top, highest);
      apart = std::max(apart, highest - lowest);
      if (finest && i % std::max(1, n / 20) == 0) {
        flight.x.push_back(i * dt);
        flight.y.push_back(highest);
      }
    }
    steps.push_back(dt);
    errors.push_back(std::abs(top - rise));
    if (!finest) continue;
    result.check_relative(Label::verification, "rise of the highest particle of a thrown block of snow against v²/2g", top, rise, "m",
                          1.05 * 0.5 * speed * dt / rise,
                          "symplectic Euler rises v dt/2 less; 5 % for where the step that meets the top falls");
    result.check_absolute(Label::verification, "difference in rise between any two particles of the block", apart, 0.0, "m",
                          n * std::numeric_limits<double>::epsilon() * 10.0,
                          "stress-free snow in one motion: round-off of n steps, one unit in the last place of 10 m each");
  }
  result.check_order(Label::verification, "order in dt of the rise against v²/2g", fitted_order(steps, errors), 0.95, 1.05,
                     "symplectic Euler errs by v dt/2, and by g dt²/8 at most for where the step that meets the top falls");
  Series exact{"v t - g t²/2", {}, {}, Series::Style::reference};
  for (int i = 0; i <= 50; ++i) {
    exact.x.push_back(flight_time * i / 50.0);
    exact.y.push_back((speed - 0.5 * c.numerics.gravity * exact.x.back()) * exact.x.back());
  }
  result.plots.push_back({"rise",
                          "Rise of a block of snow thrown straight up",
                          "time [s]",
                          "rise [m]",
                          {exact, {"v²/2g", {0.0, flight_time}, {rise, rise}, Series::Style::bound}, flight},
                          "",
                          false,
                          false});
}

void run(const CaseContext& context, CaseResult& result) {
  const Case c = thrown_cube();
  const Vec3 g(0.0, 0.0, -gravity);
  const double radius = 0.5 * std::sqrt(3.0) * edge;
  const double strain = c.material.density() * spin * spin * radius * radius / c.material.as<HenckyElastic>().young_modulus;
  const auto parabola = [&](double t) { return Vec3(throw_velocity * t + 0.5 * t * t * g); };

  const Scene scene = make_scene(c);
  State reference_state = make_state(c, scene);
  set_spinning(reference_state);
  const int coarse_steps = static_cast<int>(std::ceil(duration / stable_time_step(reference_state, scene)));
  std::vector<double> steps, errors;
  Series path_x{"simulation", {}, {}, Series::Style::points}, angle_series{"simulation", {}, {}, Series::Style::points};
  for (const int n : {coarse_steps, 2 * coarse_steps, context.choose(3, 4, 8) * coarse_steps}) {
    State state = make_state(c, scene);
    set_spinning(state);
    const std::vector<Vec3> start = positions_by_id(state);
    const Vec3 start_centre = totals(state, scene).centre;
    const double dt = duration / n;
    const bool finest = steps.size() == 2;
    for (int i = 1; i <= n; ++i) {
      step(state, scene, dt);
      if (finest && i % std::max(1, n / 20) == 0) {
        const Vec3 x = totals(state, scene).centre;
        path_x.x.push_back(x.x());
        path_x.y.push_back(x.z());
        const Mat3 r = best_rotation(start, positions_by_id(state), start_centre, x);
        double turned = axis.dot(Vec3(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1))) * 0.5;
        turned = std::atan2(turned, 0.5 * (r.trace() - 1.0));
        const double expected = spin * i * dt;
        turned += 2.0 * std::numbers::pi * std::round((expected - turned) / (2.0 * std::numbers::pi));
        angle_series.x.push_back(i * dt);
        angle_series.y.push_back(turned - expected);
      }
    }
    const std::vector<Vec3> end = positions_by_id(state);
    const Totals now = totals(state, scene);
    const Vec3 discrete = parabola(duration) + 0.5 * duration * dt * g;
    steps.push_back(dt);
    errors.push_back((now.centre - start_centre - parabola(duration)).norm());
    if (!finest) continue;
    result.check_absolute(Label::verification, "centre of mass after 1 s against the discrete parabola",
                          (now.centre - start_centre - discrete).norm(), 0.0, "m", n * std::numeric_limits<double>::epsilon() * 10.0,
                          "round-off: one unit in the last place of 10 m in every step, all in one direction");
    const Mat3 rotation = best_rotation(start, end, start_centre, now.centre);
    const Mat3 wanted = Eigen::AngleAxisd(spin * duration, axis).toRotationMatrix();
    result.check_absolute(Label::verification, "rotation after one turn, distance from the exact rotation",
                          Eigen::AngleAxisd(rotation * wanted.transpose()).angle(), 0.0, "rad", 2.0 * strain * spin * duration,
                          "centrifugal strain e = rho omega^2 R^2/E slows the spin by at most 2 e");
    double departure = 0.0;
    for (std::size_t i = 0; i < end.size(); ++i)
      departure = std::max(departure, (end[i] - now.centre - rotation * (start[i] - start_centre)).norm());
    result.check_absolute(Label::verification, "largest departure of a particle from the rigid motion", departure, 0.0, "m",
                          2.0 * strain * radius, "centrifugal displacement e R, doubled by the ringing about it");
  }
  const double order = fitted_order(steps, errors);
  result.check_order(Label::verification, "order in dt of the centre of mass against the parabola", order, 0.99, 1.01,
                     "symplectic Euler errs by exactly |g| t dt/2");
  result.notes.push_back(fmt::format("512 particles, dx = 0.25 m, {} to {} steps; centrifugal strain e = {:.2g}.", coarse_steps,
                                     std::lround(duration / steps.back()), strain));

  Series exact_path{"x0 + v0 t + g t²/2", {}, {}, Series::Style::reference};
  for (int i = 0; i <= 50; ++i) {
    const Vec3 x = parabola(duration * i / 50.0);
    exact_path.x.push_back(x.x());
    exact_path.y.push_back(x.z());
  }
  result.plots.push_back({"trajectory", "Trajectory of the centre of mass", "x [m]", "z [m]", {exact_path, path_x}, "", false, false});
  const double band = 2.0 * strain * spin;
  result.plots.push_back({"rotation",
                          "Angle turned minus ω t",
                          "time [s]",
                          "angle [rad]",
                          {{"tolerance", {0.0, duration}, {0.0, -band * duration}, Series::Style::bound}, angle_series},
                          "The spin slows by the centrifugal stretching of the cube, and rings about it.",
                          false,
                          false});
  Series slope{"order 1", {steps.front(), steps.back()}, {}, Series::Style::bound};
  for (const double dt : slope.x) slope.y.push_back(0.5 * gravity * duration * dt);
  result.plots.push_back({"order",
                          "Distance from the parabola after 1 s",
                          "dt [s]",
                          "error [m]",
                          {slope, {"simulation", steps, errors, Series::Style::points}},
                          "Dashed: |g| t dt/2, the exact error of symplectic Euler.",
                          true,
                          true});
  ballistic_rise(context, result);
}

const Registration registered{{MPM_CASE_NAME, "Free flight: a rotating block, and the ballistic rise", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
