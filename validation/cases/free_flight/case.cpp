#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/setup.hpp"

namespace mpm::validation::free_flight {
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
  c.bodies.push_back({BodySpec::Shape::box, Vec3::Constant(-0.5 * edge), Vec3::Constant(0.5 * edge), throw_velocity, Lattice::aligned});
  c.numerics.transfer = Transfer::apic;  // keeps the rotation exactly
  return c;
}

/// Rigid rotation: v += omega cross x and the matching affine part.
void set_spinning(State& state) {
  const Vec3 omega = spin * axis;
  Mat3 cross;
  cross << 0, -omega.z(), omega.y(), omega.z(), 0, -omega.x(), -omega.y(), omega.x(), 0;
  state.grid.change_particles([&](Particle& p) {
    Eigen::Map<Vec3> v(p.velocity);
    v += omega.cross(Eigen::Map<const Vec3>(p.position));
    Eigen::Map<Mat3> c(p.affine);
    c = cross;
  });
}

std::vector<Vec3> positions_by_id(const std::vector<ParticleRecord>& particles) {
  std::vector<Vec3> x(particles.size());
  for (const ParticleRecord& p : particles) x.at(p.id) = p.position;
  return x;
}

/// The particles at the start.
std::vector<ParticleRecord> start_of(const Setup& setup) {
  const CaseScene scene = make_scene(setup.spec);
  return particle_records(setup.start(setup.spec, scene), scene);
}

/// A flight in n equal steps, seen at `samples` instants.
Setup flight(const Case& c, const std::string& id, const std::string& title, double end, int n, std::size_t samples) {
  return {.id = id,
          .title = title,
          .spec = c,
          .times = even_times(0.0, end, samples),
          .fields = {.identity = true},
          .time_step = end / n,
          .procedure = "Nothing touches the body. The order in the time step is judged: use time_step_s as it is, from t = 0 on."};
}

/// Stable steps in a time, rounded up to a multiple of the samples.
int steps_for(const Case& c, const std::function<State(const Case&, const Scene&)>& start, double end, std::size_t samples) {
  const CaseScene scene = make_scene(c);
  const double least = end / stable_time_step(start(c, scene), scene), each = static_cast<double>(samples);
  return static_cast<int>(each * std::ceil(least / each));
}

constexpr std::size_t rise_samples = 200;  ///< an even number: one of them is at the top
constexpr std::size_t turn_samples = 20;

double flight_time(const Case& c) { return 2.0 * c.bodies[0].velocity.z() / c.numerics.gravity; }

/// The block of snow with three time steps, coarse first.
std::vector<Setup> rises(const CaseContext& context) {
  const Case c = context.read_case();
  const int coarse = steps_for(c, Setup{}.start, flight_time(c), rise_samples);
  std::vector<Setup> all;
  for (const int times : {1, 2, context.choose(4, 4, 8)})
    all.push_back(flight(c, fmt::format("snow-steps{}", times), fmt::format("block of snow thrown upwards, {} steps", times * coarse),
                         flight_time(c), times * coarse, rise_samples));
  return all;
}

State spinning_state(const Case& c, const Scene& scene) {
  State state = make_state(c, scene);
  set_spinning(state);
  return state;
}

/// The cube with three time steps, coarse first.
std::vector<Setup> turns(const CaseContext& context) {
  const Case c = thrown_cube();
  const int coarse = steps_for(c, spinning_state, duration, turn_samples);
  std::vector<Setup> all;
  for (const int times : {1, 2, context.choose(3, 4, 8)}) {
    all.push_back(flight(c, fmt::format("cube-steps{}", times), fmt::format("thrown and spinning cube, {} steps", times * coarse), duration,
                         times * coarse, turn_samples));
    all.back().start = spinning_state;
  }
  return all;
}

std::vector<Setup> setups(const CaseContext& context) {
  std::vector<Setup> all = turns(context);
  std::ranges::copy(rises(context), std::back_inserter(all));
  return all;
}

/// Best-fit rotation about the means of the points: the rotation of the polar decomposition.
Mat3 best_rotation(const std::vector<Vec3>& from, const std::vector<Vec3>& to, const Vec3& from_mean, const Vec3& to_mean) {
  Mat3 h = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) h += (to[i] - to_mean) * (from[i] - from_mean).transpose();
  return h * Eigen::SelfAdjointEigenSolver<Mat3>(h.transpose() * h).operatorInverseSqrt();
}

/// Angle between the rotation of the spinning cube after `duration` and the exact one, rad.
double rotation_error(const CaseContext& context, const Setup& setup) {
  const std::vector<ParticleRecord> start = start_of(setup);
  std::vector<ParticleRecord> end;
  play(context, setup, [&](const Instant& now) {
    end = now.particles;
    return true;
  });
  const Mat3 rotation = best_rotation(positions_by_id(start), positions_by_id(end), mass_centre(start).position, mass_centre(end).position);
  return Eigen::AngleAxisd(rotation * Eigen::AngleAxisd(spin * duration, axis).toRotationMatrix().transpose()).angle();
}

/// A block of loose snow thrown straight up: how high it rises, which is what a run-up measures.
void ballistic_rise(const CaseContext& context, CaseResult& result) {
  const std::vector<Setup> all = rises(context);
  const Case& c = all.front().spec;
  const double speed = c.bodies[0].velocity.z(), rise = 0.5 * speed * speed / c.numerics.gravity, flight_time = all.front().times.back();
  const std::vector<Vec3> start = positions_by_id(start_of(all.front()));
  std::vector<double> steps, errors;
  Series flight{"simulation, highest particle", {}, {}, Series::Style::points};
  for (const Setup& setup : all) {
    const double dt = setup.time_step, n = flight_time / dt;
    const bool finest = steps.size() == 2;
    double top = 0.0, apart = 0.0;
    play(context, setup, [&](const Instant& now) {
      double highest = -1e9, lowest = 1e9;  // rise of the particle that rose most and least
      for (const ParticleRecord& p : now.particles) {
        const double risen = p.position.z() - start.at(p.id).z();
        highest = larger(highest, risen);
        lowest = smaller(lowest, risen);
      }
      top = larger(top, highest);
      apart = larger(apart, highest - lowest);
      if (finest && (now.index + 1) % (rise_samples / 20) == 0) {
        flight.x.push_back(now.time);
        flight.y.push_back(highest);
      }
      return true;
    });
    steps.push_back(dt);
    errors.push_back(std::abs(top - rise));
    if (!finest) continue;
    result
        .check_relative(Label::verification, "rise of the highest particle of a thrown block of snow against v²/2g", top, rise, "m",
                        1.05 * 0.5 * speed * dt / rise,
                        "symplectic Euler rises v dt/2 less; 5 % for where the step that meets the top falls")
        .in_summary(Quantity::run_up);
    result.check_absolute(Label::verification, "difference in rise between any two particles of the block", apart, 0.0, "m",
                          n * std::numeric_limits<double>::epsilon() * 10.0,
                          "stress-free snow in one motion: round-off of n steps, one unit in the last place of 10 m each");
  }
  result.check_order(Label::verification, "order in dt of the rise against v²/2g", fitted_order(steps, errors), 0.95, 1.05,
                     "symplectic Euler errs by v dt/2, and by g dt²/8 at most for where the step that meets the top falls");
  const Series exact =
      reference_curve("v t - g t²/2", 0.0, flight_time, 50, [&](double t) { return (speed - 0.5 * c.numerics.gravity * t) * t; });
  result.plots.push_back({"rise",
                          "Rise of a block of snow thrown straight up",
                          "time [s]",
                          "rise [m]",
                          {exact, {"v²/2g", {0.0, flight_time}, {rise, rise}, Series::Style::bound}, flight}});
}

void run(const CaseContext& context, CaseResult& result) {
  const Case c = thrown_cube();
  const Vec3 g(0.0, 0.0, -gravity);
  const double radius = 0.5 * std::sqrt(3.0) * edge;
  const double strain = c.material.density() * spin * spin * radius * radius / c.material.as<HenckyElastic>().young_modulus;
  const auto parabola = [&](double t) { return Vec3(throw_velocity * t + 0.5 * t * t * g); };

  const std::vector<Setup> all = turns(context);
  std::vector<double> steps, errors;
  Series path_x{"simulation", {}, {}, Series::Style::points}, angle_series{"simulation", {}, {}, Series::Style::points};
  for (const Setup& setup : all) {
    const double dt = setup.time_step;
    const int n = static_cast<int>(std::lround(duration / dt));
    const std::vector<ParticleRecord> at_start = start_of(setup);
    const std::vector<Vec3> start = positions_by_id(at_start);
    const Vec3 start_centre = mass_centre(at_start).position;
    const bool finest = steps.size() == 2;
    std::vector<Vec3> end;
    Vec3 centre = start_centre;
    play(context, setup, [&](const Instant& now) {
      end = positions_by_id(now.particles);
      centre = mass_centre(now.particles).position;
      if (!finest) return true;
      path_x.x.push_back(centre.x());
      path_x.y.push_back(centre.z());
      const Mat3 r = best_rotation(start, end, start_centre, centre);
      double turned = axis.dot(Vec3(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1))) * 0.5;
      turned = std::atan2(turned, 0.5 * (r.trace() - 1.0));
      const double expected = spin * now.time;
      turned += 2.0 * std::numbers::pi * std::round((expected - turned) / (2.0 * std::numbers::pi));
      angle_series.x.push_back(now.time);
      angle_series.y.push_back(turned - expected);
      return true;
    });
    const Vec3 discrete = parabola(duration) + 0.5 * duration * dt * g;
    steps.push_back(dt);
    errors.push_back((centre - start_centre - parabola(duration)).norm());
    if (!finest) continue;
    result.check_absolute(Label::verification, "centre of mass after 1 s against the discrete parabola",
                          (centre - start_centre - discrete).norm(), 0.0, "m", n * std::numeric_limits<double>::epsilon() * 10.0,
                          "round-off: one unit in the last place of 10 m in every step, all in one direction");
    const Mat3 rotation = best_rotation(start, end, start_centre, centre);
    const Mat3 wanted = Eigen::AngleAxisd(spin * duration, axis).toRotationMatrix();
    result.check_absolute(Label::verification, "rotation after one turn, distance from the exact rotation",
                          Eigen::AngleAxisd(rotation * wanted.transpose()).angle(), 0.0, "rad", 2.0 * strain * spin * duration,
                          "centrifugal strain e = rho omega^2 R^2/E slows the spin by at most 2 e");
    double departure = 0.0;
    for (std::size_t i = 0; i < end.size(); ++i)
      departure = larger(departure, (end[i] - centre - rotation * (start[i] - start_centre)).norm());
    result.check_absolute(Label::verification, "largest departure of a particle from the rigid motion", departure, 0.0, "m",
                          2.0 * strain * radius, "centrifugal displacement e R, doubled by the ringing about it");
  }
  if (own_run(context)) {
    Setup aflip = all.back();
    aflip.spec.numerics.transfer = Transfer::aflip;
    result
        .check_absolute(Label::verification, "rotation after one turn with AFLIP, distance from the exact rotation",
                        rotation_error(context, aflip), 0.0, "rad", 2.0 * strain * spin * duration, "as above")
        .known_miss(2.3e-3, "particles move with the grid's velocity and keep more than it: angular momentum is not conserved exactly");
  }
  const double order = fitted_order(steps, errors);
  result.check_order(Label::verification, "order in dt of the centre of mass against the parabola", order, 0.99, 1.01,
                     "symplectic Euler errs by exactly |g| t dt/2");
  result.notes.push_back(fmt::format("512 particles, dx = 0.25 m, {} to {} steps; centrifugal strain e = {:.2g}.",
                                     std::lround(duration / steps.front()), std::lround(duration / steps.back()), strain));

  Series exact_path{"x0 + v0 t + g t²/2", {}, {}, Series::Style::reference};
  for (int i = 0; i <= 50; ++i) {
    const Vec3 x = parabola(duration * i / 50.0);
    exact_path.x.push_back(x.x());
    exact_path.y.push_back(x.z());
  }
  result.plots.push_back({"trajectory", "Trajectory of the centre of mass", "x [m]", "z [m]", {exact_path, path_x}});
  const double band = 2.0 * strain * spin;
  result.plots.push_back({"rotation",
                          "Angle turned minus ω t",
                          "time [s]",
                          "angle [rad]",
                          {{"tolerance", {0.0, duration}, {0.0, -band * duration}, Series::Style::bound}, angle_series},
                          "The spin slows by the centrifugal stretching of the cube, and rings about it."});
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

const Registration registered{{.title = "Free flight: a rotating block, and the ballistic rise", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::free_flight
