#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mpm/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/norms.hpp"

namespace mpm::validation {
namespace {

constexpr double height = 1.75, density = 300.0, gravity = 9.81, young = 1e6, poisson = 0.1;
constexpr double bulk = young / (3.0 * (1.0 - 2.0 * poisson)), shear = young / (2.0 * (1.0 + poisson));

/// Principal branch of Lambert's W for s >= 0: w e^w = s, by Newton's method on a convex function.
double lambert_w(double s) {
  double w = std::log1p(s);
  for (int i = 0; i < 60; ++i) w -= (w * std::exp(w) - s) / (std::exp(w) * (1.0 + w));
  return w;
}

/// Exact state of a confined column with modulus E_oed, at reference height z.
struct Column {
  double modulus;
  [[nodiscard]] double stress(double z) const { return -density * gravity * (height - z); }
  [[nodiscard]] double displacement(double z) const {  // Simpson's rule; the integrand is smooth
    constexpr int n = 64;
    double sum = 0.0;
    for (int i = 0; i <= n; ++i) {
      const double j = std::exp(-lambert_w(density * gravity * (height - z * i / n) / modulus));
      sum += (i == 0 || i == n ? 1.0 : i % 2 ? 4.0 : 2.0) * (j - 1.0);
    }
    return sum * z / (3.0 * n);
  }
};

struct Rest {
  std::vector<double> z, stress, displacement;  ///< by particle: reference height, Cauchy sigma_zz, vertical displacement
  double lateral_ratio = 0.0;                   ///< largest deviation of tau_xx/tau_zz from the law's
  double force_over_weight = 0.0, settlement_share = 0.0;
  double cell = 0.0;
  std::uint64_t steps = 0;
};

/// Column of two by two cells between slip walls.
Case column_case(bool fluid, int cells) {
  Case c;
  const double dx = height / cells, side = 2.0 * dx;
  c.material.model = fluid ? "cohesive_cam_clay" : "hencky_elastic";
  c.material.density = density;
  c.material.young_modulus = young;
  c.material.poisson_ratio = poisson;
  c.material.critical_state_slope = 0.0;
  c.material.preconsolidation_pressure = 1e4;  // the floor carries 5.2 kPa
  c.numerics.cell_size = dx;
  c.numerics.gravity = gravity;
  c.bodies.push_back({BodySpec::Shape::box, Vec3::Zero(), Vec3(side, side, height), Vec3::Zero()});
  const auto wall = [&](const Vec3& point, const Vec3& normal) {
    WallSpec w;
    w.point = point;
    w.normal = normal;
    w.contact = Contact::slip;
    c.walls.push_back(w);
  };
  wall(Vec3::Zero(), Vec3::UnitZ());  // first: its impulse is the floor's
  wall(Vec3::Zero(), Vec3::UnitX());
  wall(Vec3::Zero(), Vec3::UnitY());
  wall(Vec3(side, 0, 0), -Vec3::UnitX());
  wall(Vec3(0, side, 0), -Vec3::UnitY());
  return c;
}

/// Ramps gravity over the first half of the time and damps the velocity at twice the first frequency of the column.
Rest settle(bool fluid, int cells) {
  const Case c = column_case(fluid, cells);
  const Column exact{fluid ? bulk : bulk + 4.0 / 3.0 * shear};
  Scene scene = make_scene(c);
  const Vec3 full_gravity = scene.gravity;
  State state = make_state(c, scene);
  std::vector<double> z(state.grid.particle_count());
  double mass = 0.0;
  state.grid.for_each_particle([&](const Particle& p) {
    z[p.id] = p.position[2];
    mass += density * p.volume;
  });
  const double frequency = 0.5 * std::numbers::pi / height * std::sqrt(exact.modulus / density);  // rad/s
  const double duration = 60.0 / frequency, ramp = 0.5 * duration;  // the slowest mode decays like exp(-2 frequency t) or faster
  double floor_force = 0.0;
  while (state.time < duration) {
    const double dt = stable_time_step(state, scene);
    const double share = state.time >= ramp ? 1.0 : 0.5 * (1.0 - std::cos(std::numbers::pi * state.time / ramp));
    scene.gravity = share * full_gravity;
    const StepReport report = step(state, scene, dt);
    floor_force = -report.impulses.at(0).linear.z() / dt;
    const double keep = std::exp(-2.0 * frequency * dt);
    for (const auto b : state.grid.occupied_blocks()) {
      auto& particles = state.grid.block(b).particles;
      for (int s = 0; s < particles.count(); ++s) {
        for (double& v : particles[s].velocity) v *= keep;
        for (double& a : particles[s].affine) a *= keep;
      }
    }
  }
  Rest rest;
  rest.cell = c.numerics.cell_size;
  rest.steps = state.step;
  rest.force_over_weight = floor_force / (mass * gravity);
  const double ratio = fluid ? 1.0 : poisson / (1.0 - poisson);
  double top = 0.0;
  state.grid.for_each_particle([&](const Particle& p) {
    const MaterialState<double> s{{p.stress[0], p.stress[1], p.stress[2], p.stress[3], p.stress[4], p.stress[5]}, p.internal};
    const double j = std::visit([&](const auto& law) { return law.volume_ratio(s); }, scene.material);
    const double u = p.position[2] - z[p.id];
    rest.z.push_back(z[p.id]);
    rest.stress.push_back(p.stress[2] / j);
    rest.displacement.push_back(u);
    rest.lateral_ratio = std::max(rest.lateral_ratio, std::abs(p.stress[0] / p.stress[2] - ratio));
    if (z[p.id] > top) {
      top = z[p.id];
      rest.settlement_share = u / exact.displacement(top);
    }
  });
  return rest;
}

struct Errors {
  double displacement;  ///< L2, m
  double stress;        ///< L1 of cell means over rho g H
  std::vector<double> cell_z, cell_stress;
};

Errors compare(const Rest& rest, const Column& exact) {
  std::vector<double> u;
  const auto cells = static_cast<std::size_t>(std::lround(height / rest.cell));
  std::vector<double> sum(cells, 0.0), count(cells, 0.0), mean(cells), wanted(cells), z(cells);
  for (std::size_t i = 0; i < rest.z.size(); ++i) {
    u.push_back(exact.displacement(rest.z[i]));
    const auto k = std::min(cells - 1, static_cast<std::size_t>(rest.z[i] / rest.cell));
    sum[k] += rest.stress[i];
    count[k] += 1.0;
  }
  for (std::size_t k = 0; k < cells; ++k) {
    z[k] = (static_cast<double>(k) + 0.5) * rest.cell;
    mean[k] = sum[k] / count[k];
    wanted[k] = exact.stress(z[k]);
  }
  return {error_norms(rest.displacement, u).l2, error_norms(mean, wanted).l1 / (density * gravity * height), z, mean};
}

void study(const CaseContext& context, CaseResult& result, bool fluid) {
  const std::string word = fluid ? "M = 0" : "elastic";
  const Column exact{fluid ? bulk : bulk + 4.0 / 3.0 * shear};
  const double strain = density * gravity * height / exact.modulus;
  std::vector<double> size, displacement_error, stress_error, settlement;
  Plot profile{(fluid ? std::string("fluid") : word) + "-stress",
               "Vertical stress at rest, " + word,
               "-σ_zz [kPa]",
               "reference height Z [m]",
               {{"ρ0 g (H - Z)", {density * gravity * height * 1e-3, 0.0}, {0.0, height}, Series::Style::reference}},
               "Means over one cell.",
               false,
               false};
  Plot shape{(fluid ? std::string("fluid") : word) + "-settlement",
             "Displacement at rest, " + word,
             "-u [mm]",
             "reference height Z [m]",
             {},
             "",
             false,
             false};
  Series curve{"exact (Lambert W)", {}, {}, Series::Style::reference};
  for (int i = 0; i <= 40; ++i) {
    curve.y.push_back(height * i / 40.0);
    curve.x.push_back(-1e3 * exact.displacement(curve.y.back()));
  }
  shape.series.push_back(curve);
  const double full_settlement = -exact.displacement(height);
  Rest rest;
  for (const int cells : context.choose<std::vector<int>>({7, 14, 28}, {7, 14, 28, 56}, {7, 14, 28, 56, 112})) {
    rest = settle(fluid, cells);
    const Errors e = compare(rest, exact);
    size.push_back(rest.cell);
    displacement_error.push_back(e.displacement);
    stress_error.push_back(e.stress);
    settlement.push_back(rest.settlement_share * full_settlement * 1e3);
    Series simulated{fmt::format("dx = H/{}", cells), {}, e.cell_z, Series::Style::points};
    for (const double s : e.cell_stress) simulated.x.push_back(-1e-3 * s);
    profile.series.push_back(std::move(simulated));
    Series moved{fmt::format("dx = H/{}", cells), {}, {}, Series::Style::points};
    for (std::size_t i = 0; i < rest.z.size(); i += 16) {  // one of the 16 particles of a layer
      moved.x.push_back(-1e3 * rest.displacement[i]);
      moved.y.push_back(rest.z[i]);
    }
    shape.series.push_back(std::move(moved));
    context.log(fmt::format("{}: {} cells, {} steps", word, cells, rest.steps));
  }
  result.check_relative(Label::verification, word + ": force on the floor over weight", rest.force_over_weight, 1.0, "", 1e-5,
                        "what is left of the motion");
  result.check_absolute(Label::verification, word + ": lateral over vertical stress, largest deviation", rest.lateral_ratio, 0.0, "", 1e-9,
                        "lateral strain is exactly zero, the ratio is the law's");
  result
      .check_absolute(Label::verification, word + ": displacement, L2 error", 1e3 * displacement_error.back(), 0.0, "mm",
                      1e3 * strain * rest.cell / 4.0, "twice the effect of the resting nodes behind the floor, ε0 dx/8")
      .observed_order = fitted_order(size, displacement_error);
  result
      .check_absolute(Label::verification, word + ": σ_zz of cells, L1 error over ρ0 g H", stress_error.back(), 0.0, "",
                      rest.cell / (4.0 * height), "twice the mean error 1/8 in a layer of one cell at the floor")
      .observed_order = fitted_order(size, stress_error);
  result.check_order(Label::verification, word + ": order of the displacement", fitted_order(size, displacement_error), 0.85, 1.2,
                     "first order at the floor; the band is the second-order part at the coarsest grid");
  result.check_order(Label::verification, word + ": order of the stress (L1)", fitted_order(size, stress_error), 0.85, 1.2,
                     "first order at the floor; the band is the second-order part at the coarsest grid");
  const GridStudy grids = grid_study(size, settlement, 1.0);
  result
      .check_relative(Label::verification, word + ": settlement extrapolated to dx = 0", grids.extrapolated, 1e3 * full_settlement, "mm",
                      5e-3, "second-order remainder: square of the 5 % of the coarsest grid, doubled")
      .observed_order = grids.order;
  result.studies.push_back({word + ": settlement of the top", "mm", grids});
  result.plots.push_back(std::move(profile));
  result.plots.push_back(std::move(shape));
  Series slope{"order 1", {size.front(), size.back()}, {}, Series::Style::bound};
  for (const double h : slope.x) slope.y.push_back(displacement_error.back() / height * h / size.back());
  std::vector<double> scaled;
  for (const double e : displacement_error) scaled.push_back(e / height);
  result.plots.push_back({(fluid ? std::string("fluid") : word) + "-order",
                          "Errors against cell size, " + word,
                          "dx [m]",
                          "error [-]",
                          {slope,
                           {"displacement (L2) / H", size, scaled, Series::Style::points},
                           {"σ_zz of cells (L1) / ρ0 g H", size, stress_error, Series::Style::points}},
                          "",
                          true,
                          true});
}

void run(const CaseContext& context, CaseResult& result) {
  study(context, result, false);
  study(context, result, true);
}

const Registration registered{{MPM_CASE_NAME, "Hydrostatic column", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
