#include "validation/harness/shallow_flow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "libmpm/base/error.hpp"
#include "validation/harness/root.hpp"

namespace mpm::validation {

CompressionCurve hencky_curve(double bulk_modulus) { return snow_curve(bulk_modulus, 1.0, std::numeric_limits<double>::infinity()); }

CompressionCurve snow_curve(double bulk_modulus, double xi, double preconsolidation_pressure) {
  const auto strain = [=](double p) {
    if (p <= preconsolidation_pressure) return p / bulk_modulus;
    return p / bulk_modulus + (std::asinh(p / bulk_modulus) - std::asinh(preconsolidation_pressure / bulk_modulus)) / xi;
  };
  return [=](double cauchy) {
    const double p = root_between([&](double kirchhoff) { return kirchhoff * std::exp(strain(kirchhoff)) - cauchy; }, 0.0, cauchy);
    return std::exp(-strain(p));
  };
}

CompressionCurve tait_curve(double bulk_modulus, int exponent) {
  return [=](double p) { return std::pow(1.0 + exponent * p / bulk_modulus, -1.0 / exponent); };
}

HydrostaticColumn::HydrostaticColumn(double density, double gravity, CompressionCurve curve)
    : density_(density), gravity_(gravity), curve_(std::move(curve)) {}

double HydrostaticColumn::integral(double mass_per_area, bool with_pressure) const {
  constexpr int n = 400;  // Simpson; the only kink of the integrand is at the onset of yielding, and errs by 1/n^2
  double sum = 0.0;
  for (int i = 0; i <= n; ++i) {
    const double m = mass_per_area * i / n;
    sum += (i == 0 || i == n ? 1.0 : i % 2 ? 4.0 : 2.0) * curve_(gravity_ * m) * (with_pressure ? gravity_ * m : 1.0);
  }
  return sum * mass_per_area / (3.0 * n * density_);
}

double HydrostaticColumn::height(double mass_per_area) const { return integral(mass_per_area, false); }
double HydrostaticColumn::thrust(double mass_per_area) const { return integral(mass_per_area, true); }

double HydrostaticColumn::mass(double height_wanted) const {
  double high = 2.0 * density_ * height_wanted;
  while (height(high) < height_wanted) high *= 2.0;
  return root_between([&](double mass_per_area) { return height(mass_per_area) - height_wanted; }, 0.0, high);
}

Bore reflected_bore(const HydrostaticColumn& column, double mass_per_area, double speed) {
  const double f1 = column.thrust(mass_per_area);
  const auto excess = [&](double m2) {  // F_2 - F_1 - mu_1 v (v + S), with v + S = v mu_2/(mu_2 - mu_1)
    return column.thrust(m2) - f1 - mass_per_area * speed * speed * m2 / (m2 - mass_per_area);
  };
  double high = 2.0 * mass_per_area;
  while (excess(high) < 0.0) high *= 2.0;
  const double m2 = root_between(excess, mass_per_area * (1.0 + 1e-9), high);
  return {m2, column.height(m2), speed * mass_per_area / (m2 - mass_per_area), column.thrust(m2)};
}

State staggered_state(const Case& c, const Scene& scene, int along, int across) {
  if (c.bodies.size() != 1) throw ConfigError("staggered_state: one body");
  const BodySpec& body = c.bodies[0];
  const double spacing = c.numerics.particle_spacing(), length = body.max[along] - body.min[along];
  const State lattice = make_state(c, scene);
  State state(c.numerics.cell_size, c.numerics.precision);
  state.next_id = lattice.next_id;
  state.max_speed = lattice.max_speed;
  lattice.grid.for_each_particle([&](const Particle& p) {
    Particle q = p;
    const double plane = std::floor((p.position[across] - body.min[across]) / spacing);
    const double shift = spacing * std::fmod(plane * std::numbers::phi, 1.0);
    q.position[along] = body.min[along] + std::fmod(p.position[along] - body.min[along] + shift, length);
    state.grid.insert(q);
  });
  state.grid.refresh();
  return state;
}

State hydrostatic_state(const Case& c, const Scene& scene, int along, int across) {
  const double density = density_of(scene.material);
  struct Point {
    MaterialState<double> state;
    double volume_ratio;
  };
  const auto compressed = [&](double strain) {
    return std::visit(
        [&](const auto& law) {
          MaterialState<double> s{{}, law.initial_internal()};
          Matrix3<double> dl{};
          for (int i = 0; i < 3; ++i) dl.m[i][i] = std::expm1(-strain / 3.0);
          law.update_stress(s, dl, 1.0);
          return Point{s, law.volume_ratio(s)};
        },
        scene.material);
  };
  const double height = c.bodies[0].max.z();
  const auto at = [&](double reference_height) {
    const double pressure = -density * scene.gravity.z() * (height - reference_height);
    const auto cauchy = [&](double strain) {
      const Point m = compressed(strain);
      return -trace(m.state.stress) / (3.0 * m.volume_ratio);
    };
    double high = 1e-3;
    while (cauchy(high) < pressure) high *= 2.0;
    return compressed(root_between([&](double strain) { return cauchy(strain) - pressure; }, 0.0, high));
  };
  constexpr std::size_t levels = 200;  // of the table z(Z): trapezia, which err by 1/levels^2 of the compression
  std::vector<double> z{0.0};
  double below = at(0.0).volume_ratio;
  for (std::size_t k = 1; k <= levels; ++k) {
    const double here = at(height * static_cast<double>(k) / levels).volume_ratio;
    z.push_back(z.back() + 0.5 * (below + here) * height / levels);
    below = here;
  }
  const State loose = staggered_state(c, scene, along, across);
  State state(c.numerics.cell_size, c.numerics.precision);
  state.next_id = loose.next_id;
  state.max_speed = loose.max_speed;
  loose.grid.for_each_particle([&](const Particle& p) {
    Particle q = p;
    const MaterialState<double> m = at(p.position[2]).state;
    const double stress[6] = {m.stress.xx, m.stress.yy, m.stress.zz, m.stress.xy, m.stress.xz, m.stress.yz};
    std::copy(std::begin(stress), std::end(stress), std::begin(q.stress));
    q.internal = m.internal;
    const double s = p.position[2] / height * levels;
    const auto k = std::min(levels - 1, static_cast<std::size_t>(s));
    q.position[2] = z[k] + (s - static_cast<double>(k)) * (z[k + 1] - z[k]);
    state.grid.insert(q);
  });
  state.grid.refresh();
  return state;
}

DepthProfile depth_profile(const State& state, double density, double x_min, double x_max, double spacing, double width) {
  std::vector<ParticleRecord> particles;
  state.grid.for_each_particle([&](const Particle& p) {
    particles.push_back({.position = Vec3(p.position[0], p.position[1], p.position[2]), .mass = density * p.volume});
  });
  return depth_profile(particles, x_min, x_max, spacing, width);
}

DepthProfile depth_profile(const std::vector<ParticleRecord>& particles, double x_min, double x_max, double spacing, double width) {
  const auto count = static_cast<std::size_t>(std::lround((x_max - x_min) / spacing)) + 1;
  DepthProfile profile{x_min, spacing, width, std::vector<double>(count, 0.0)};
  for (const ParticleRecord& p : particles) {
    const double s = (p.position.x() - x_min) / spacing;
    const double cell = std::floor(s);
    const double mass = p.mass / (spacing * width);
    for (const int side : {0, 1}) {
      const double node = cell + side;
      if (!(node >= 0.0 && node < static_cast<double>(count))) continue;
      profile.mass[static_cast<std::size_t>(node)] += mass * (side ? s - cell : 1.0 - (s - cell));
    }
  }
  profile.mass.front() *= 2.0;  // the ends have half a hat
  profile.mass.back() *= 2.0;
  return profile;
}

std::optional<double> last_crossing(const DepthProfile& profile, double level) {
  for (std::size_t i = profile.mass.size() - 1; i > 0; --i) {
    const double near = profile.mass[i - 1], far = profile.mass[i];
    if (far < level && near >= level) return profile.x(i - 1) + profile.spacing * (near - level) / (near - far);
  }
  return {};
}

BatchMean batch_mean(const std::vector<double>& values, std::size_t batches) {
  if (batches < 2 || values.size() < batches) throw ConfigError("batch_mean: needs two batches or more, and a value in each");
  std::vector<double> mean(batches, 0.0);
  double total = 0.0;
  for (std::size_t b = 0; b < batches; ++b) {
    const std::size_t begin = b * values.size() / batches, end = (b + 1) * values.size() / batches;
    for (std::size_t i = begin; i < end; ++i) mean[b] += values[i] / static_cast<double>(end - begin);
    total += mean[b] / static_cast<double>(batches);
  }
  double square = 0.0;
  for (const double m : mean) square += (m - total) * (m - total);
  return {total, std::sqrt(square / static_cast<double>(batches * (batches - 1)))};
}

}  // namespace mpm::validation
