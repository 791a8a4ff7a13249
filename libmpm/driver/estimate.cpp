#include "libmpm/driver/estimate.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/impact/conveyor.hpp"
#include "libmpm/impact/inflow.hpp"
#include "libmpm/impact/semi_empirical.hpp"

namespace mpm {

namespace {

/// Fraction of [low, high] on the computed side of a mirror plane through 0.
double kept_fraction(bool mirror, double low, double high) { return mirror ? std::clamp(high / (high - low), 0.0, 1.0) : 1.0; }

double particle_volume(const Numerics& n) { return std::pow(n.cell_size, 3) / n.particles_per_cell; }

double greatest_flow_height(const ConveyorSpec& belt) { return std::max(belt.flow_height, Inflow(belt).highest()); }

double snow_volume(const Case& spec) {
  if (spec.conveyor) {
    const ConveyorSpec& belt = *spec.conveyor;
    const double length = belt.feed == ConveyorSpec::Feed::strip ? conveyor_length(belt.velocity, spec.output.duration)
                                                                 : window_length(belt, spec.numerics.cell_size);
    return length * greatest_flow_height(belt) * belt.width * (belt.mirror_y ? 0.5 : 1.0);
  }
  double sum = 0.0;
  for (const BodySpec& body : spec.bodies) {
    sum += volume_of(body) * kept_fraction(spec.domain.mirror_x, body.min.x(), body.max.x()) *
           kept_fraction(spec.domain.mirror_y, body.min.y(), body.max.y());
  }
  return sum;
}

/// Largest initial speed, and the fall from the top of the snow: v^2 = v_0^2 + 2 g h.
double largest_speed(const Case& spec) {
  double speed = 0.0, fall = 0.0;
  if (spec.conveyor) {
    const Inflow inflow(*spec.conveyor);
    speed = std::max(spec.conveyor->velocity, inflow.fastest()) * inflow.shear(1.0);
    fall = greatest_flow_height(*spec.conveyor);
  }
  for (const BodySpec& body : spec.bodies) {
    speed = std::max(speed, body.velocity.norm());
    const double floor = std::max(spec.domain.min.z(), std::min(0.0, body.min.z()));
    fall = std::max(fall, body.max.z() - floor);
  }
  for (const WallSpec& wall : spec.walls) speed = std::max(speed, wall.velocity.norm());
  if (spec.terrain) speed = std::max(speed, std::abs(spec.terrain->speed));
  return std::sqrt(speed * speed + 2.0 * spec.numerics.gravity * fall);
}

/// Memory of one row of the series, bytes: some twenty columns and the bins of the pressure profile, twice if forces are recorded by
/// height.
double series_row_bytes(const Case& spec) {
  if (!spec.conveyor || !spec.obstacle) return 0.0;
  constexpr double columns = 20.0, profile_heights = 5.0;  // the profile reaches up to five flow heights
  const double bin = spec.measurement.bin_height.value_or(0.5 * spec.numerics.cell_size);
  return sizeof(double) * (columns + 2.0 * profile_heights * spec.conveyor->flow_height / bin);
}

constexpr double seconds_per_year = 365.25 * 86400.0;

}  // namespace

Estimate estimate(const Case& spec) {
  Estimate e{};
  e.particles = snow_volume(spec) / particle_volume(spec.numerics);
  e.cells = e.particles / spec.numerics.particles_per_cell;
  const AnyMaterial material = make_material(spec.material);
  e.wave_speed = wave_speed_of(material);
  e.time_step = stable_time_step(material, spec.numerics.cfl, spec.numerics.cell_size, largest_speed(spec),
                                 spec.obstacle && spec.numerics.contact == ContactRule::surface);
  const Sampling sampling(spec);
  const auto intervals = static_cast<double>(sampling.last());
  e.steps = intervals * std::ceil(1.0 / (spec.output.series_per_second * e.time_step));  // steps are cut to meet the samples
  e.samples = intervals + 1.0;
  e.frames = static_cast<double>(sampling.frames(sampling.last() + 1));
  e.particle_steps = e.particles * e.steps;
  e.memory_bytes = e.particles * assumed_bytes_per_particle + e.samples * series_row_bytes(spec);
  constexpr double frame_bytes = 128.0, final_bytes = 200.0, checkpoints = 2.0;  // the one before is kept
  const auto checkpoint_bytes = static_cast<double>(record_bytes(spec.numerics.precision));
  e.disk_bytes = e.particles * (e.frames * frame_bytes + final_bytes + checkpoints * checkpoint_bytes) +
                 e.samples * std::max(200.0, 2.0 * series_row_bytes(spec));
  e.wall_time_s = e.particle_steps / assumed_particle_steps_per_s;
  return e;
}

double physical_memory_bytes() { return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE)); }

void require_feasible(const Estimate& need, double limit_bytes) {
  std::vector<std::string> problems;
  const auto check = [&](const char* what, double value, double most, const char* remedy) {
    if (!(value <= most))
      problems.push_back(fmt::format("the case needs {:.4g} {}, at most {:.4g} are possible; {}", value, what, most, remedy));
  };
  check("samples", need.samples, most_samples, "take a shorter output.duration_s or a lower output.series_per_second");
  check("frames", need.frames, most_frames, "take a shorter output.duration_s or a lower output.frames_per_second");
  check("steps", need.steps, most_steps,
        "take a shorter output.duration_s, a larger numerics.cell_size_m or numerics.cfl, or a lower output.series_per_second");
  check("years of computing", need.wall_time_s / seconds_per_year, most_years,
        "take a larger numerics.cell_size_m, less snow or a shorter output.duration_s");
  if (!(need.memory_bytes <= limit_bytes)) {
    problems.push_back(fmt::format(
        "the case needs about {:.3g} GB of memory for {:.3g} particles and {:.3g} samples, this machine has {:.3g} GB; take a larger "
        "numerics.cell_size_m, less snow or a lower output.series_per_second",
        need.memory_bytes / 1e9, need.particles, need.samples, limit_bytes / 1e9));
  }
  if (!problems.empty()) throw ConfigError(fmt::format("{}", fmt::join(problems, "\n")));
}

}  // namespace mpm
