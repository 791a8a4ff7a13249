#include "mpm/estimate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mpm/error.hpp"
#include "mpm/impact/semi_empirical.hpp"
#include "mpm/solver.hpp"

namespace mpm {

namespace {

double volume(const BodySpec& body) {
  const double box = (body.max - body.min).prod();
  switch (body.shape) {
    case BodySpec::Shape::box: return box;
    case BodySpec::Shape::cylinder: return box * std::numbers::pi / 4.0;
    case BodySpec::Shape::sphere: return box * std::numbers::pi / 6.0;
  }
  return box;
}

/// Share of [low, high] on the computed side of a mirror plane through 0.
double kept_share(bool mirror, double low, double high) { return mirror ? std::clamp(high / (high - low), 0.0, 1.0) : 1.0; }

double particle_volume(const NumericsSpec& n) { return std::pow(n.cell_size, 3) / n.particles_per_cell; }

double snow_volume(const Case& spec) {
  if (spec.conveyor) {
    const ConveyorSpec& belt = *spec.conveyor;
    const double length = belt.feed == ConveyorSpec::Feed::strip ? conveyor_length(belt.velocity, spec.output.duration)
                                                                 : belt.upstream_length + belt.downstream_length;
    return length * belt.flow_height * belt.width * (belt.mirror_y ? 0.5 : 1.0);
  }
  double sum = 0.0;
  for (const BodySpec& body : spec.bodies) {
    sum += volume(body) * kept_share(spec.domain.mirror_x, body.min.x(), body.max.x()) *
           kept_share(spec.domain.mirror_y, body.min.y(), body.max.y());
  }
  return sum;
}

/// Largest initial speed, and the fall from the top of the snow: v^2 = v_0^2 + 2 g h.
double largest_speed(const Case& spec) {
  double speed = spec.conveyor ? spec.conveyor->velocity : 0.0;
  double fall = spec.conveyor ? spec.conveyor->flow_height : 0.0;
  for (const BodySpec& body : spec.bodies) {
    speed = std::max(speed, body.velocity.norm());
    const double floor = std::max(spec.domain.min.z(), std::min(0.0, body.min.z()));
    fall = std::max(fall, body.max.z() - floor);
  }
  for (const WallSpec& wall : spec.walls) speed = std::max(speed, wall.velocity.norm());
  return std::sqrt(speed * speed + 2.0 * spec.numerics.gravity * fall);
}

}  // namespace

Estimate estimate(const Case& spec) {
  Estimate e{};
  e.particles = snow_volume(spec) / particle_volume(spec.numerics);
  e.cells = e.particles / spec.numerics.particles_per_cell;
  const AnyMaterial material = make_material(spec.material);
  e.wave_speed = wave_speed_of(material);
  e.time_step = stable_time_step(material, spec.numerics.cfl, spec.numerics.cell_size, largest_speed(spec));
  e.steps = std::ceil(spec.output.duration / e.time_step);
  e.particle_steps = e.particles * e.steps;
  e.memory_bytes = e.particles * assumed_bytes_per_particle;
  e.wall_time_s = e.particle_steps / assumed_particle_steps_per_s;
  return e;
}

double physical_memory_bytes() { return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE)); }

void require_memory(const Estimate& need, double limit_bytes) {
  if (need.memory_bytes <= limit_bytes) return;
  throw ConfigError(fmt::format(
      "the case needs about {:.3g} GB for {:.3g} particles, this machine has {:.3g} GB; take a larger numerics.cell_size_m or less snow",
      need.memory_bytes / 1e9, need.particles, limit_bytes / 1e9));
}

}  // namespace mpm
