#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/norms.hpp"

namespace mpm::validation::block_on_cylinder {
namespace {

constexpr double gravity = 9.81;  ///< m/s^2, towards the axis
constexpr double place = 0.4;     ///< rad, of the middle of the block at the start; 0 is downstream

/// A direction in which the block is thrown.
struct Throw {
  std::string name;
  double angle = 0.0;  ///< to the horizontal, rad
};

/// The block as a rigid body: a part of the ring R < r < R + h, as thick in height and along the circle.
struct Block {
  double radius, thickness;  ///< R, h, m
  double half_angle;         ///< phi_0, rad
  double friction;           ///< mu

  [[nodiscard]] double outer() const { return radius + thickness; }
  /// Mean of r over the mass, m.
  [[nodiscard]] double mean_radius() const {
    return 2.0 / 3.0 * (std::pow(outer(), 3) - std::pow(radius, 3)) / (std::pow(outer(), 2) - std::pow(radius, 2));
  }
  /// Moment of inertia about the axis over the mass, m^2.
  [[nodiscard]] double inertia() const { return 0.5 * (std::pow(outer(), 2) + std::pow(radius, 2)); }
  /// Sum of the normal forces over the mass, m/s^2. @param around  angular velocity, rad/s. @param share  mu times the share of the
  /// friction that acts round the cylinder. Derived in the README.
  [[nodiscard]] double normal_force(double around, double share) const {
    const double spread = std::sin(half_angle) / half_angle, lever = radius * mean_radius() / inertia();
    const double towards_axis = spread * (gravity - around * around * mean_radius());
    return towards_axis / (spread * std::sqrt(1.0 + share * share * (1.0 - lever * lever)));
  }
  /// Path of the contact surface to rest, m, and its duration, s. @param speed, angle  of the throw
  struct Rest {
    double path = 0.0, time = 0.0;
  };
  [[nodiscard]] Rest rest(double speed, double angle) const {
    constexpr double dt = 1e-5;  // midpoint rule
    double around = speed * std::cos(angle) / radius, up = speed * std::sin(angle);
    Rest r;
    const auto slowed = [&](double w, double v) {
      const double contact = std::hypot(radius * w, v), along = radius * w / contact, push = normal_force(w, friction * along);
      return std::pair{-friction * push * along * radius / inertia(), -friction * push * v / contact};
    };
    const auto contact_speed = [&](double w, double v) { return std::hypot(radius * w, v); };
    while (contact_speed(around, up) > 1e-9) {
      const auto [dw, dv] = slowed(around, up);
      const double left = contact_speed(around, up) / contact_speed(dw, dv), step = std::min(dt, left);
      const auto [mw, mv] = slowed(around + 0.49 * step * dw, up + 0.49 * step * dv);
      r.path += step * (contact_speed(around, up) - 0.5 * step * contact_speed(mw, mv));
      around += step * mw, up += step * mv;
      r.time += step;
      if (left <= dt) break;
    }
    return r;
  }
};

struct Slide {
  double path = 0.0, rise = 0.0;  ///< m; of the contact surface, until rest; away from the cylinder while it slides
  double speed = 0.0;             ///< m/s, at the end
  double friction_error = 0.0;    ///< largest |T/(mu N) - 1| of a step while all of the block slides
  double mean_friction = 0.0;     ///< sum of T over mu times the sum of N, in the same time
  double largest_step = 0.0;      ///< s
};

Slide slide(const Case& c, const Throw& thrown, const Block& block, double speed, double rest_time) {
  const double spacing = 0.5 * c.numerics.cell_size, height = c.bodies[0].max.z() - c.bodies[0].min.z();
  const CaseScene scene = make_scene(c);
  State state(c.numerics.cell_size, c.numerics.precision);
  const Vec3 axis(block.radius, 0.0, 0.0);
  const auto rows = static_cast<int>(std::lround(block.thickness / spacing)), layers = static_cast<int>(std::lround(height / spacing)),
             columns = static_cast<int>(std::lround(2.0 * block.half_angle * block.radius / spacing));
  for (int k = 0; k < layers; ++k) {
    for (int j = 0; j < columns; ++j) {
      for (int i = 0; i < rows; ++i) {
        const double r = block.radius + (i + 0.5) * spacing, angle = place + ((j + 0.5) / columns * 2.0 - 1.0) * block.half_angle;
        const Vec3 out(std::cos(angle), std::sin(angle), 0.0), around(-std::sin(angle), std::cos(angle), 0.0);
        const Vec3 x = axis + r * out + (c.bodies[0].min.z() + (k + 0.5) * spacing) * Vec3::UnitZ();
        const double turning = speed * std::cos(thrown.angle) / block.radius;
        const Vec3 v = turning * r * around + speed * std::sin(thrown.angle) * Vec3::UnitZ();
        Particle p{};
        for (int n = 0; n < 3; ++n) p.position[n] = x[n], p.velocity[n] = v[n];
        p.affine[1] = turning, p.affine[3] = -turning;  // column by column: dv_y/dx, dv_x/dy
        p.volume = r * 2.0 * block.half_angle / columns * spacing * height / layers;
        p.id = state.next_id++;
        state.grid.insert(p);
      }
    }
  }
  state.grid.refresh();
  state.max_speed = speed * block.outer() / block.radius;

  const Vec3 arm = std::visit([](const auto& b) { return b.reference_point(); }, scene.boundaries[*scene.obstacle]) - axis;
  Slide s;
  double pushed = 0.0, dragged = 0.0;
  while (state.time < c.output.duration) {
    const double dt = stable_time_step(state, scene);
    double mass = 0.0, away = 0.0, turning = 0.0, up = 0.0;
    state.grid.change_particles([&](Particle& p) {
      const double x = p.position[0] - axis.x(), y = p.position[1], r = std::hypot(x, y);
      p.velocity[0] -= dt * gravity * x / r;
      p.velocity[1] -= dt * gravity * y / r;
    });
    const StepReport report = step(state, scene, dt);
    state.grid.for_each_particle([&](const Particle& p) {
      const double x = p.position[0] - axis.x(), y = p.position[1], r = std::hypot(x, y);
      mass += p.volume;
      away += p.volume * (x * p.velocity[0] + y * p.velocity[1]) / r;
      turning += p.volume * (x * p.velocity[1] - y * p.velocity[0]);
      up += p.volume * p.velocity[2];
    });
    s.speed = std::hypot(block.radius * turning / (mass * block.inertia()), up / mass);
    s.path += dt * s.speed;
    s.largest_step = larger(s.largest_step, dt);
    if (state.time <= rest_time) s.rise += dt * away / mass;
    const Impulse& given = report.impulses[*scene.obstacle];
    const double around = (given.angular + arm.cross(given.linear)).z() / block.radius;
    const double all = given.linear.head<2>().squaredNorm() - around * around, drag = std::hypot(around, given.linear.z());
    if (state.time >= 0.9 * rest_time || all <= 0.0) continue;
    const double push = std::sqrt(all);
    s.friction_error = larger(s.friction_error, std::abs(drag / (block.friction * push) - 1.0));
    pushed += push, dragged += drag;
  }
  s.mean_friction = dragged / (block.friction * pushed);
  return s;
}

void run(const CaseContext& context, CaseResult& result) {
  const Case c = context.read_case();
  const auto& law = c.material.as<HenckyElastic>();
  const BodySpec& body = c.bodies[0];
  const Vec3 size = body.max - body.min;
  const double radius = 0.5 * c.obstacle->width(), speed = body.velocity.norm(), mu = c.obstacle->friction;
  const Block block{radius, size.x(), 0.5 * size.y() / radius, mu};
  const double quarter = 0.25 * std::numbers::pi;
  const auto throws = context.level() == Level::quick
                          ? std::vector<Throw>{{"at 45° to its axis", quarter}}
                          : std::vector<Throw>{{"at 45° to its axis", quarter}, {"round it", 0.0}, {"along its axis", 2.0 * quarter}};
  std::vector<Slide> all(throws.size());
  in_parallel(throws.size(), [&](std::size_t i) { all[i] = slide(c, throws[i], block, speed, block.rest(speed, throws[i].angle).time); });
  // what is left open by where along the block the cylinder presses: all at the middle, or all at both ends
  const double reach = block.half_angle + c.numerics.cell_size / radius, open = 0.5 * (1.0 + mu * mu) * reach * reach;
  const double vibration = std::pow(0.5 * size.x() * gravity * std::sqrt(law.density / law.young_modulus) / (0.1 * speed), 2) + 1e-9;
  for (std::size_t i = 0; i < throws.size(); ++i) {
    const Slide& s = all[i];
    const Block::Rest exact = block.rest(speed, throws[i].angle);
    const std::string& name = throws[i].name;
    result
        .check_relative(Label::verification, name + ": path to rest, + μ times the rise", s.path + mu * s.rise, exact.path, "m",
                        speed * s.largest_step / exact.path + 2.0 / 3.0 * open,
                        "one step of motion (symplectic Euler); where along the block the cylinder presses: (1 + μ²) φ²/3 about uniform "
                        "pressure")
        .in_summary(Quantity::run_out);
    result.check_at_most(Label::verification, name + ": friction over μ times normal force in a step, largest deviation from 1",
                         s.friction_error, vibration + open, "", 0.0,
                         "the sum of the normal forces is open by (1 + μ²) φ²/2; second order in the angle by which vibration turns the "
                         "sliding direction");
    result.notes.push_back(
        fmt::format("{}: path {:.4f} m, exact {:.4f} m ({:.4f}); rise {:.2f} mm; friction over μ times normal force: mean {:.5f}, largest "
                    "deviation of a step {:.1e}; speed at the end {:.1e} m/s.",
                    name, s.path, exact.path, s.path / exact.path, 1e3 * s.rise, s.mean_friction, s.friction_error, s.speed));
    context.log(result.notes.back());
  }
}

const Registration registered{{.title = "Block that slides round a cylinder", .run = run}};

}  // namespace
}  // namespace mpm::validation::block_on_cylinder
