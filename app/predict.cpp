/// `mpm predict`: the semi-empirical equations for one case, or for every combination of the given values.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "commands.hpp"
#include "libmpm/base/error.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm::app {

namespace {

struct PredictArguments {
  std::vector<double> froude{3.0}, velocity, critical_state_slope{0.4}, cohesion_beta{0.0}, flow_height{1.75}, obstacle_width{1.75},
      hardening_xi{5.0};
  double gravity = standard_gravity, density = 300.0, young_modulus = 1.0e6, poisson_ratio = 0.1, preconsolidation_pressure = 1.0e4;
  bool csv = false;
};

struct PredictCase {
  double velocity, critical_state_slope, cohesion_beta, flow_height, obstacle_width, hardening_xi;
};

/// One column of the CSV, one line of the list for a single case.
struct Quantity {
  std::string key, unit, meaning;
  double value;
  std::string column;  ///< heading in the table of several cases; empty: no column
};

std::vector<Quantity> quantities(const PredictCase& c, const PredictArguments& a) {
  const double H = c.flow_height, friction = effective_friction(c.critical_state_slope, c.cohesion_beta);
  const double stiffness = bulk_modulus(a.young_modulus, a.poisson_ratio);
  const double relative_width = c.obstacle_width / H, f = width_factor(relative_width), limited = limited_width_factor(relative_width);
  const double runup = predicted_runup(friction, c.velocity, H, a.gravity),
               height = predicted_pressure_height(friction, c.velocity, H, a.gravity);
  const auto guideline = [&](double lambda, double factor) { return H + guideline_runup(c.velocity, lambda, factor, a.gravity); };
  const double angle = friction <= 3.0 ? friction_angle(friction) * 180.0 / std::numbers::pi : std::numeric_limits<double>::quiet_NaN();
  return {
      {"froude_number", "", "Froude number v/sqrt(g H)", froude_number(c.velocity, H, a.gravity), "Fr"},
      {"velocity_m_s", "m/s", "flow velocity v", c.velocity, "v, m/s"},
      {"critical_state_slope", "", "critical-state slope M", c.critical_state_slope, "M"},
      {"cohesion_beta", "", "cohesion beta", c.cohesion_beta, "beta"},
      {"flow_height_m", "m", "flow height H", H, "H, m"},
      {"obstacle_width_m", "m", "obstacle width w", c.obstacle_width, "w, m"},
      {"hardening_xi", "", "hardening parameter xi", c.hardening_xi, "xi"},
      {"effective_friction", "", "effective internal friction M' (Eq. 2)", friction, "M'"},
      {"friction_angle_deg", "deg", "friction angle phi'; none for M' > 3", angle, ""},
      {"plastic_compressibility_percent", "%", "plastic compressibility chi(25 kPa) (Eqs. A1-A2)",
       100.0 * plastic_compressibility(c.hardening_xi, 25e3, a.preconsolidation_pressure, stiffness), ""},
      {"conveyor_width_m", "m", "width W of the simulated avalanche (Fig. 2)", conveyor_width(c.hardening_xi, c.obstacle_width), ""},
      {"runup_m", "m", "run-up above ground (Eqs. 7-10, Table A1; regressed for w = H)", runup, "h_r, m"},
      {"runup_over_flow_height", "", "... over H", runup / H, "h_r/H"},
      {"runup_magnification", "", "... magnification factor zeta_r", magnification_factor(friction, runup_coefficients), ""},
      {"runup_dissipation", "", "... dissipation factor lambda_r", dissipation_factor(friction, runup_coefficients), ""},
      {"pressure_height_m", "m", "pressure height above ground (Eqs. 7-10, Table A2; regressed for w = H)", height, "h_p, m"},
      {"pressure_height_over_flow_height", "", "... over H", height / H, "h_p/H"},
      {"pressure_height_magnification", "", "... magnification factor zeta_p", magnification_factor(friction, pressure_height_coefficients),
       ""},
      {"pressure_height_dissipation", "", "... dissipation factor lambda_p", dissipation_factor(friction, pressure_height_coefficients),
       ""},
      {"bernoulli_m", "m", "inviscid bound H + v^2/2g", bernoulli_height(c.velocity, H, a.gravity), "Bernoulli, m"},
      {"width_factor", "", "guideline width factor f(w/H) (Eq. 6)", f, ""},
      {"width_factor_limited", "", "... not below 0.7 (Sect. 5)", limited, ""},
      {"guideline_loose_m", "m", "guideline run-up above ground, dry and loose: H + v^2/(2 g 1.5) f (Eq. 5)",
       guideline(guideline_lambda_loose, f), "loose, m"},
      {"guideline_loose_limited_m", "m", "... with the limited width factor", guideline(guideline_lambda_loose, limited), ""},
      {"guideline_dense_upper_m", "m", "guideline run-up above ground, dense, lambda 2", guideline(guideline_lambda_dense_low, f), ""},
      {"guideline_dense_m", "m", "guideline run-up above ground, dense, lambda 3", guideline(guideline_lambda_dense, f), "dense, m"},
      {"guideline_dense_limited_m", "m", "... with the limited width factor", guideline(guideline_lambda_dense, limited), ""},
      {"elastic_stagnation_pressure_pa", "Pa", "stagnation pressure of the elastic, inviscid snow",
       hencky_stagnation_pressure(c.velocity, a.density, stiffness), ""},
  };
}

/// Every combination of the values given, the first named list slowest.
std::vector<PredictCase> combinations(const PredictArguments& a) {
  std::vector<PredictCase> cases;
  const bool by_velocity = !a.velocity.empty();
  for (const double speed : by_velocity ? a.velocity : a.froude) {
    for (const double slope : a.critical_state_slope) {
      for (const double beta : a.cohesion_beta) {
        for (const double height : a.flow_height) {
          for (const double width : a.obstacle_width) {
            for (const double xi : a.hardening_xi) {
              cases.push_back({by_velocity ? speed : flow_velocity(speed, height, a.gravity), slope, beta, height, width, xi});
            }
          }
        }
      }
    }
  }
  return cases;
}

void predict(const PredictArguments& arguments) {
  constexpr double most_cases = 1e5;
  double cases = 1.0;
  for (const auto* values : {&arguments.froude, &arguments.velocity, &arguments.critical_state_slope, &arguments.cohesion_beta,
                             &arguments.flow_height, &arguments.obstacle_width, &arguments.hardening_xi})
    cases *= std::max(1.0, static_cast<double>(values->size()));
  if (cases > most_cases)
    throw ConfigError(fmt::format("{:.3g} combinations of values, at most {:g} are possible; give fewer", cases, most_cases));
  std::vector<std::vector<Quantity>> rows;
  std::vector<std::string> outside;  // each once
  for (const PredictCase& c : combinations(arguments)) {
    rows.push_back(quantities(c, arguments));
    for (std::string& value :
         outside_of_equations(froude_number(c.velocity, c.flow_height, arguments.gravity), c.obstacle_width / c.flow_height,
                              effective_friction(c.critical_state_slope, c.cohesion_beta), c.hardening_xi)) {
      if (std::ranges::find(outside, value) == outside.end()) outside.push_back(std::move(value));
    }
  }
  if (!outside.empty()) fmt::print(stderr, "extrapolated: the equations were not fitted to {}\n", fmt::join(outside, ", "));

  if (arguments.csv) {
    std::vector<std::string> head;
    for (const Quantity& quantity : rows.front()) head.push_back(quantity.key);
    fmt::print("{}", csv_line(head));
    for (const auto& row : rows) {
      std::vector<double> values;
      for (const Quantity& quantity : row) values.push_back(quantity.value);
      fmt::print("{}", csv_line(values));
    }
  } else if (rows.size() == 1) {
    for (const Quantity& quantity : rows.front()) fmt::print("{:12.4f} {:4} {}\n", quantity.value, quantity.unit, quantity.meaning);
  } else {
    static constexpr std::size_t narrowest = 7;
    const auto print_row = [](const std::vector<Quantity>& row, auto text) {
      for (const Quantity& quantity : row) {
        if (!quantity.column.empty()) fmt::print("{:>{}}  ", text(quantity), std::max(quantity.column.size(), narrowest));
      }
      fmt::print("\n");
    };
    print_row(rows.front(), [](const Quantity& quantity) { return quantity.column; });
    for (const auto& row : rows) print_row(row, [](const Quantity& quantity) { return fmt::format("{:.4g}", quantity.value); });
    fmt::print(
        "h_r run-up, h_p pressure height (Eqs. 7-10); Bernoulli H + v^2/2g; loose, dense: guideline run-up above ground, lambda 1.5 and "
        "3\n");
  }
}

}  // namespace

void add_predict(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "predict",
      "Run-up, pressure height and guideline values by the semi-empirical equations; several values (a,b,c) give every combination");
  const auto a = std::make_shared<PredictArguments>();
  const auto add_list = [command](const char* name, std::vector<double>& values, const char* text, double low, double high) {
    return command->add_option(name, values, text)->delimiter(',')->check(in_range(low, high))->capture_default_str();
  };
  CLI::Option* froude = add_list("--froude", a->froude, "Froude number v/sqrt(g H)", 0.0, 100.0);
  add_list("--velocity", a->velocity, "Flow velocity, m/s, instead of the Froude number", 0.0, 1e3)->excludes(froude);
  add_list("--critical-state-slope", a->critical_state_slope, "Critical-state slope M", 0.0, 10.0);
  add_list("--cohesion-beta", a->cohesion_beta, "Cohesion beta, below 1", 0.0, 1.0);
  add_list("--flow-height", a->flow_height, "Flow height H, m", 1e-9, 1e3);
  add_list("--obstacle-width", a->obstacle_width, "Obstacle width w, m", 1e-9, 1e4);
  add_list("--hardening-xi", a->hardening_xi, "Hardening parameter xi", 2e-3, 1e3);
  command->add_option("--gravity", a->gravity, "Gravity g, m/s^2")->check(in_range(1e-9, 1e3))->capture_default_str();
  command->add_option("--density", a->density, "Density rho_0, kg/m^3")->check(in_range(1.0, 1e5))->capture_default_str();
  command->add_option("--young-modulus", a->young_modulus, "Young's modulus E, Pa")->check(in_range(1.0, 1e12))->capture_default_str();
  command->add_option("--poisson-ratio", a->poisson_ratio, "Poisson's ratio nu")->check(in_range(0.0, 0.499999))->capture_default_str();
  command->add_option("--preconsolidation-pressure", a->preconsolidation_pressure, "Initial pre-consolidation pressure p_c0, Pa")
      ->check(in_range(1e-3, 1e9))
      ->capture_default_str();
  command->add_flag("--csv", a->csv, "All quantities as CSV, one row a case");
  command->callback([a, command] {
    std::string chosen;
    for (const char* name : {"--critical-state-slope", "--cohesion-beta", "--flow-height", "--obstacle-width", "--hardening-xi"}) {
      const CLI::Option* option = command->get_option(name);
      if (option->count() > 0) continue;
      const std::string list = option->get_default_str();  // "[0.4]"
      chosen += fmt::format("{}{} {}", chosen.empty() ? "" : ", ", name, list.substr(1, list.size() - 2));
    }
    if (!chosen.empty()) fmt::print(stderr, "not given, so taken: {}\n", chosen);
    predict(*a);
  });
}

}  // namespace mpm::app
