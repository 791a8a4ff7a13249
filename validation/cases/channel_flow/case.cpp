#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "libmpm/core/stress_update.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/particle_access.hpp"
#include "validation/harness/periodic.hpp"
#include "validation/harness/slender.hpp"

namespace mpm::validation::channel_flow {
namespace {

/// Which flow.
enum class Flow {
  channel,  ///< viscous fluid between two walls, driven along them (Poiseuille)
  film,     ///< viscous fluid on a slope (Nusselt)
  grains,   ///< mu(I) on a slope (Bagnold)
};

struct Settings {
  Flow flow = Flow::film;
  int cells = 16;       ///< across the layer
  double offset = 0.0;  ///< of the scene against the grid along z, cells
  ContactRule contact = ContactRule::surface;
  Transfer transfer = Transfer::aflip;
};

/// The steady flow, in the reference coordinate Z of the particles (0 at the floor, H at the top of the uncompressed layer).
struct Steady {
  double pressure;      ///< mean, Cauchy, Pa
  double volume_ratio;  ///< J
  double shear_rate;    ///< dv/dz, 1/s
  double shear_stress;  ///< sigma_xz, Pa
  double tilt = 0.0;    ///< s_xx = -s_zz, Pa: elastic strains that turn with the flow
};

class Exact {
 public:
  explicit Exact(const Case& c, Flow flow) : height_(c.bodies[0].max.z()), flow_(flow), material_(c.material) {
    along_ = c.numerics.gravity * std::sin(c.numerics.slope);
    across_ = c.numerics.gravity * std::cos(c.numerics.slope);
    if (flow == Flow::channel) across_ = 0.0;  // the slope is 90 degrees
    density_ = c.material.density();
    // v(Z) = int J dv/dz dZ and z(Z) = int J dZ by Simpson's rule; finer at the top, where the slope of v is not smooth
    constexpr int parts = 2000;
    double z = 0.0, v = 0.0;
    for (int i = 0; i <= parts; ++i) {
      const double s = static_cast<double>(i) / parts, level = height_ * (1.0 - (1.0 - s) * (1.0 - s));
      if (i > 0) {
        const double a = level_.back(), m = 0.5 * (a + level), h = level - a;
        const Steady low = at(a), mid = at(m), high = at(level);
        z += h / 6.0 * (low.volume_ratio + 4.0 * mid.volume_ratio + high.volume_ratio);
        v += h / 6.0 * (low.volume_ratio * low.shear_rate + 4.0 * mid.volume_ratio * mid.shear_rate + high.volume_ratio * high.shear_rate);
      }
      level_.push_back(level), place_.push_back(z), speed_.push_back(v);
    }
    double flux = 0.0;
    for (std::size_t i = 1; i < level_.size(); ++i) flux += 0.5 * (speed_[i] + speed_[i - 1]) * (level_[i] - level_[i - 1]);
    flux_ = flux;
  }
  [[nodiscard]] Steady at(double level) const {
    const double above = density_ * (height_ - level);  // mass per area
    const double p = across_ * above;
    if (flow_ == Flow::grains) {
      const auto& m = material_.as<DruckerPrager>();
      const double bulk = m.young_modulus / (3.0 * (1.0 - 2.0 * m.poisson_ratio));
      const double elastic_shear = m.young_modulus / (2.0 * (1.0 + m.poisson_ratio)), shear = along_ * above;
      const double tilt = shear * shear / elastic_shear, mean = p - tilt;  // derived in the README
      const double mu = mean > 0.0 ? shear / mean : along_ / across_;
      const double low = std::tan(m.friction_angle), high = std::tan(*m.limit_friction_angle);
      const double number = *m.reference_inertial_number * (mu - low) / (high - mu);
      return {mean, std::exp(-mean / bulk), number * std::sqrt(std::max(mean, 0.0) / *m.grain_density) / *m.grain_diameter, shear, tilt};
    }
    const auto& m = material_.as<WeaklyCompressibleFluid>();
    const double shear = flow_ == Flow::channel ? along_ * density_ * (0.5 * height_ - level) : along_ * above;
    return {p, std::pow(1.0 + m.tait_exponent * p / m.bulk_modulus, -1.0 / m.tait_exponent), shear / m.viscosity, shear};
  }
  [[nodiscard]] double place(double level) const { return interpolated(place_, level); }  ///< z, m
  [[nodiscard]] double speed(double level) const { return interpolated(speed_, level); }  ///< m/s
  [[nodiscard]] double flux() const { return flux_; }                                     ///< int v dZ, m^2/s
  [[nodiscard]] double largest_speed() const { return *std::max_element(speed_.begin(), speed_.end()); }
  [[nodiscard]] double height() const { return height_; }

 private:
  [[nodiscard]] double interpolated(const std::vector<double>& values, double level) const {
    const auto above = std::lower_bound(level_.begin() + 1, level_.end() - 1, level);
    const auto i = static_cast<std::size_t>(above - level_.begin());
    const double share = (level - level_[i - 1]) / (level_[i] - level_[i - 1]);
    return values[i - 1] + share * (values[i] - values[i - 1]);
  }
  double height_, along_ = 0.0, across_ = 0.0, density_ = 0.0, flux_ = 0.0;
  Flow flow_;
  MaterialParameters material_;
  std::vector<double> level_, place_, speed_;
};

struct Measured {
  double cell = 0.0;                 ///< over H
  double profile_error = 0.0;        ///< L2 of the velocity over the largest exact one
  double flux = 0.0;                 ///< over the exact one
  double drift = 0.0;                ///< change of the flux over the last quarter of the time, over the exact one
  std::vector<double> level, speed;  ///< of the particles: Z/H; v over the largest exact one
  double particle_steps = 0.0;
};

Case case_of(const CaseContext& context, Flow flow) {
  Case c = context.read_case(flow == Flow::grains ? "grains.toml" : "case.toml");
  if (flow != Flow::channel) return c;
  c.numerics.slope = std::acos(0.0);
  c.material.as<WeaklyCompressibleFluid>().carries_tension = true;  // nothing presses it together
  WallSpec top = c.walls[0];
  top.point.z() = c.bodies[0].max.z();
  top.normal = -top.normal;
  c.walls.push_back(top);
  return c;
}

Measured run_flow(const CaseContext& context, const Settings& s) {
  Case c = case_of(context, s.flow);
  const double height = c.bodies[0].max.z(), dx = height / s.cells, length = 4.0 * dx, side = 0.5 * dx;
  c.numerics.cell_size = dx;
  c.numerics.contact = s.contact;
  c.numerics.transfer = s.transfer;
  c.numerics.grid_offset = Vec3(0.0, 0.0, s.offset);
  c.bodies[0].max.x() = length;
  set_side(c, side, {1});
  const Exact exact(c, s.flow);
  const CaseScene scene = make_scene(c);
  const State lattice = make_state(c, scene);
  const std::vector<Vec3> reference = reference_positions(lattice);
  const auto level = [&](const Particle& p) { return reference[p.id].z() - scene.offset.z(); };

  State state(dx, c.numerics.precision);
  state.next_id = lattice.next_id;
  lattice.grid.for_each_particle([&](Particle p) {
    const double z = level(p);
    const Steady now = exact.at(z);
    p.position[2] = exact.place(z) + scene.offset.z();
    p.velocity[0] = exact.speed(z);
    p.affine[6] = now.shear_rate;
    for (int i = 0; i < 3; ++i) p.stress[i] = -now.volume_ratio * now.pressure;
    p.stress[0] += now.volume_ratio * now.tilt;
    p.stress[2] -= now.volume_ratio * now.tilt;
    p.stress[4] = now.volume_ratio * now.shear_stress;
    if (s.flow != Flow::grains) p.internal = now.volume_ratio - 1.0;
    state.grid.insert(p);
  });
  state.grid.refresh();
  state.max_speed = exact.largest_speed();
  const PeriodicBox box(scene.offset, Vec3(length, 0.0, 0.0), 2.5 * dx, lattice.next_id);

  Measured m;
  m.cell = 1.0 / s.cells;
  // Relaxation: H^2/nu for a fluid. Grains: H^2/D with the diffusivity D = (p/rho) d mu/d(dv/dz) at half height.
  double duration = 0.0;
  if (s.flow == Flow::grains) {
    const Steady middle = exact.at(0.5 * height);
    const auto& grains = c.material.as<DruckerPrager>();
    const double number = middle.shear_rate * *grains.grain_diameter / std::sqrt(middle.pressure / *grains.grain_density);
    const double slope = (std::tan(*grains.limit_friction_angle) - std::tan(grains.friction_angle)) * *grains.reference_inertial_number /
                         std::pow(*grains.reference_inertial_number + number, 2);
    const double diffusivity =
        middle.pressure / grains.density * slope * *grains.grain_diameter / std::sqrt(middle.pressure / *grains.grain_density);
    duration = 2.0 * height * height / diffusivity;
  } else {
    const auto& fluid = c.material.as<WeaklyCompressibleFluid>();
    duration = (s.flow == Flow::channel ? 1.0 : 2.0) * height * height * fluid.density / fluid.viscosity;
  }
  std::vector<double> sum(reference.size(), 0.0);
  double samples = 0.0, half_sum[2] = {0.0, 0.0}, half_samples[2] = {0.0, 0.0};
  while (state.time < duration) {
    box.renew(state);
    step(state, scene, stable_time_step(state, scene));
    m.particle_steps += static_cast<double>(state.grid.particle_count());
    if (state.time < 0.75 * duration) continue;
    const std::size_t half = state.time < 0.875 * duration ? 0 : 1;
    double flux = 0.0;
    state.grid.for_each_particle([&](const Particle& p) {
      if (!box.owns(p)) return;
      sum[p.id] += p.velocity[0];
      flux += p.volume * p.velocity[0];
    });
    half_sum[half] += flux / (length * side);
    half_samples[half] += 1.0;
    samples += 1.0;
  }
  double squares = 0.0;
  const double largest = exact.largest_speed();
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const double z = reference[i].z() - scene.offset.z(), v = sum[i] / samples;
    squares += std::pow((v - exact.speed(z)) / largest, 2);
    m.level.push_back(z / height);
    m.speed.push_back(v / largest);
  }
  m.profile_error = std::sqrt(squares / static_cast<double>(sum.size()));
  m.flux = (half_sum[0] + half_sum[1]) / (samples * exact.flux());
  m.drift = (half_sum[1] / half_samples[1] - half_sum[0] / half_samples[0]) / exact.flux();
  return m;
}

struct Variant {
  std::string name;
  Settings settings;
};

void run(const CaseContext& context, CaseResult& result) {
  const auto fluid_grids = context.choose<std::vector<int>>({8, 11, 14}, {8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48});
  const auto grain_grids = context.choose<std::vector<int>>({8, 11, 14}, {8, 12, 16, 24}, {8, 12, 16, 24, 32, 48});
  std::vector<Variant> variants = {{"channel, surface, AFLIP", {.flow = Flow::channel}},
                                   {"film, surface, AFLIP", {.flow = Flow::film}},
                                   {"grains, surface, AFLIP", {.flow = Flow::grains}},
                                   {"film, surface half a cell off the nodes, AFLIP", {.flow = Flow::film, .offset = 0.5}}};
  if (context.level() != Level::quick) {
    variants.push_back({"channel, surface half a cell off the nodes, AFLIP", {.flow = Flow::channel, .offset = 0.5}});
    variants.push_back({"channel, nodes, APIC", {.flow = Flow::channel, .contact = ContactRule::nodal, .transfer = Transfer::apic}});
    variants.push_back({"film, surface, APIC", {.flow = Flow::film, .transfer = Transfer::apic}});
    variants.push_back({"film, nodes, APIC", {.flow = Flow::film, .contact = ContactRule::nodal, .transfer = Transfer::apic}});
    variants.push_back({"grains, surface, APIC", {.flow = Flow::grains, .transfer = Transfer::apic}});
  }
  struct Task {
    std::size_t variant, grid;
  };
  std::vector<Task> tasks;
  std::vector<std::vector<Measured>> all(variants.size());
  for (std::size_t v = 0; v < variants.size(); ++v) {
    all[v].resize((variants[v].settings.flow == Flow::grains ? grain_grids : fluid_grids).size());
    for (std::size_t g = 0; g < all[v].size(); ++g) tasks.push_back({v, all[v].size() - 1 - g});
  }
  in_parallel(tasks.size(), [&](std::size_t i) {
    Settings s = variants[tasks[i].variant].settings;
    s.cells = (s.flow == Flow::grains ? grain_grids : fluid_grids)[tasks[i].grid];
    all[tasks[i].variant][tasks[i].grid] = run_flow(context, s);
  });

  double work = 0.0;
  for (const auto& [flow, id, title] : {std::tuple{Flow::channel, "channel", "Viscous fluid between two walls"},
                                        std::tuple{Flow::film, "film", "Viscous film on a slope of 60°"},
                                        std::tuple{Flow::grains, "grains", "Grains with μ(I) on a slope of 26°"}}) {
    Plot profile{fmt::format("{}-profile", id), std::string(title) + ": velocity on the coarsest grid", "v / v_max [-]", "Z / H [-]"};
    Plot errors{fmt::format("{}-error", id),
                std::string(title) + ": error of the velocity",
                "dx / H [-]",
                "L2 error over v_max [-]",
                {},
                "",
                true,
                true};
    const Exact exact(case_of(context, flow), flow);
    Series line =
        reference_curve("exact", 0.0, 1.0, 100, [&](double level) { return exact.speed(level * exact.height()) / exact.largest_speed(); });
    std::swap(line.x, line.y);  // the level upwards
    profile.series.push_back(std::move(line));
    for (std::size_t v = 0; v < variants.size(); ++v) {
      if (variants[v].settings.flow != flow) continue;
      const bool surface = variants[v].settings.contact == ContactRule::surface;
      const std::string& name = variants[v].name;
      std::vector<double> cell, error, flux;
      for (const Measured& m : all[v]) {
        cell.push_back(m.cell), error.push_back(m.profile_error), flux.push_back(std::abs(m.flux - 1.0));
        work += m.particle_steps;
      }
      const double order = fitted_order(cell, error);
      const Measured& finest = all[v].back();
      if (surface && flow != Flow::grains) {
        result
            .check_order(Label::verification, name + ": order of the velocity", order, 1.8, 2.6,
                         "second order is the aim; up to 2.6 because the coarsest grid has 8 cells across the layer")
            .observed_order = order;
      } else if (surface) {
        result
            .check_order(Label::verification, name + ": order of the velocity", order, 1.3, 2.6,
                         "3/2: the shear rate falls to zero as the root of the depth, so its slope is not bounded at the top")
            .observed_order = order;
      }
      if (surface)
        result
            .check_relative(Label::verification, name + ": flux at the finest grid over the exact one", finest.flux, 1.0, "",
                            flow == Flow::grains ? 3.0 * finest.cell * std::sqrt(finest.cell) : 2.5 * finest.cell * finest.cell,
                            flow == Flow::grains
                                ? "3 (dx/H)^1.5: the order above, and three thicknesses per unit of flux"
                                : "2.5 (dx/H)²: the smoothing (k dx)²/8 of quadratic splines at k = π/H, once for each transfer")
            .in_summary(Quantity::speed, 0.0, exact.flux() / exact.height());
      result.check_at_most(Label::verification, name + ": change of the flux over the last eighth of the time", std::abs(finest.drift), 0.0,
                           "", 2e-3, "steady: the slowest part of the start's error has fallen to 1 % of it");
      result.notes.push_back(
          fmt::format("{}: error of the velocity {:.2e} to {:.2e}, order {:.2f}; flux {:.4f} to {:.4f} of the exact one, drift {:.0e}.",
                      name, error.front(), error.back(), order, all[v].front().flux, finest.flux, finest.drift));
      errors.series.push_back({name, cell, error, Series::Style::points});
      profile.series.push_back({name, all[v].front().speed, all[v].front().level, Series::Style::points});
    }
    errors.series.push_back(slope_line("order 2", errors.series.front().x, errors.series.front().y.back(), 2.0));
    result.plots.push_back(std::move(profile));
    result.plots.push_back(std::move(errors));
  }
  result.notes.push_back(fmt::format("{:.1f} million particle-steps.", 1e-6 * work));
}

const Registration registered{{.title = "Channel and slope: Poiseuille, Nusselt, Bagnold", .run = run}};

}  // namespace
}  // namespace mpm::validation::channel_flow
