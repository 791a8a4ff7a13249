#include <fmt/format.h>

#include <cmath>

#include "libmpm/driver/run.hpp"
#include "libmpm/observe/particles_inside_obstacle.hpp"

namespace mpm {

namespace {

/// A number, or "unknown".
std::string shown(double value, double scale) { return std::isfinite(value) ? fmt::format("{:.3g}", value * scale) : "unknown"; }

/// Why there are no means, and what helps.
std::string no_means(const Results& results) {
  const double constant = results.number("inflow_constant_from_s"), end = results.number("duration_s");
  if (constant > 0.0 && constant >= end) {
    return fmt::format(
        "no means: the inflow at the obstacle varies until {:.3g} s, the end of the run is at {:.3g} s; take the peaks, or give "
        "each of its stages a run with a steady inflow\n",
        constant, end);
  }
  return "no steady interval, so no means: take a longer output.duration_s\n";
}

/// The means with what each +- contains, those of the arm where there is one.
std::string means_text(const Results& results) {
  struct Line {
    const char *name, *mean, *standard_error, *numerical, *unit;
    double scale;
    int component;
  };
  constexpr const char* no_grid = nullptr;
  constexpr Line lines[] = {
      {"run-up", "runup_p99_mean_m", "runup_p99_standard_error_m", "runup_p99_numerical_uncertainty_m", "m", 1.0, 0},
      {"highest particle", "runup_mean_m", "runup_standard_error_m", "runup_numerical_uncertainty_m", "m", 1.0, 0},
      {"pressure height", "pressure_height_mean_m", "pressure_height_standard_error_m", "pressure_height_numerical_uncertainty_m", "m", 1.0,
       0},
      {"force downstream", "force_mean_n", "force_standard_error_n", "force_x_numerical_uncertainty_n", "kN", 1e-3, 0},
      {"overturning moment", "overturning_moment_mean_n_m", "overturning_moment_standard_error_n_m",
       "overturning_moment_numerical_uncertainty_n_m", "kN m", 1e-3, 0},
      {"arm, downstream", "arm_force_mean_n", "arm_force_standard_error_n", no_grid, "kN", 1e-3, 0},
      {"arm, upwards", "arm_force_mean_n", "arm_force_standard_error_n", no_grid, "kN", 1e-3, 2},
      {"arm, overturning", "arm_overturning_moment_mean_n_m", "arm_overturning_moment_standard_error_n_m", no_grid, "kN m", 1e-3, 0},
  };
  std::string text = fmt::format("means from {:.3g} to {:.3g} s:\n", results.number("steady_from_s"), results.number("steady_to_s"));
  for (const Line& line : lines) {
    if (!results.has(line.mean)) continue;
    const auto show = [&](const char* name) {
      return name == no_grid ? "unknown" : shown(results.number(name, line.component), line.scale);
    };
    text += fmt::format("  {:<20}{:>8} {:<5} +- {} (statistics) +- {} (grid)\n", line.name, show(line.mean), line.unit,
                        show(line.standard_error), show(line.numerical));
  }
  text +=
      "  statistics: standard error of the mean in time; grid: estimated from published grid studies at this resolution, not from this "
      "run; neither contains snow and model\n"
      "  run-up: height that holds 99 % of the mass before the mast; highest particle: the paper's run-up\n";
  text += fmt::format("  moment{} about the mast's own axis, x = {:.3g} m, at the ground\n",
                      results.has("arm_force_mean_n") ? ", of the mast without its arm and of the arm," : "",
                      results.number("overturning_moment_axis_x_m"));
  if (results.number("inflow_constant_from_s") > 0.0)
    text += "  these means are of the last row of the inflow, not of its strongest part\n";
  return text;
}

}  // namespace

std::string summary_text(const Results& results) {
  if (!results.has("steady") || !results.has("force_mean_n")) return {};
  const bool steady = results.number("steady") != 0.0;
  std::string text = steady ? means_text(results) : no_means(results);
  text += "forces downstream, and which of them to design with:\n";
  const bool splash = results.number("force_filtered_peak_time_s") <= results.number("first_impact_until_s");
  text += fmt::format(
      "  filtered peak {} kN (mean over {:.2g} s, at {:.3g} s{}): a peak of this run alone; mpm design gives its uncertainty and "
      "the response of the mast\n",
      shown(results.number("force_filtered_peak_n"), 1e-3), results.number("force_window_s"), results.number("force_filtered_peak_time_s"),
      splash ? ", before the first splash has fallen back: it depends on the front" : "");
  if (steady && results.number("inflow_constant_from_s") == 0.0)
    text += fmt::format("  steady mean {} kN: the load while the avalanche passes, for what responds slowly, such as a foundation\n",
                        shown(results.number("force_mean_n"), 1e-3));
  text += fmt::format("  raw peak {} kN (a row of {:.2g} s, at {:.3g} s): no design value, it grows with output.series_per_second\n",
                      shown(results.number("force_peak_n"), 1e-3), results.number("force_interval_s"), results.number("force_peak_time_s"));
  if (results.has("arm_force_filtered_peak_n"))
    text +=
        fmt::format("  filtered peak on the arm {} kN downstream, {} kN upwards, in addition\n",
                    shown(results.number("arm_force_filtered_peak_n"), 1e-3), shown(results.number("arm_force_z_filtered_peak_n"), 1e-3));
  return text;
}

std::vector<std::string> result_warnings(const Results& results) {
  if (results.has("particles_final") && results.number("particles_final") == 0.0) {
    const double lost = results.number("particles_lost"), downstream = results.number("particles_left_downstream");
    if (lost + downstream == 0.0) return {};  // nothing was computed
    return {
        fmt::format("no particle is left at the end: {:.0f} left the domain on other sides than downstream, {:.0f} downstream; take a "
                    "larger domain or a shorter output.duration_s",
                    lost, downstream)};
  }
  std::vector<std::string> warnings;
  constexpr double largest_drift = 0.05;  // of the mean, as the running mean of the run-up may differ
  if (results.has("force_drift") && std::abs(results.number("force_drift")) > largest_drift) {
    const double drift = results.number("force_drift");
    warnings.push_back(fmt::format(
        "the force is not steady where the run-up is: over the second half of the steady interval its mean is {:.2g} % of the mean {} than "
        "over the first; take a longer output.duration_s",
        100.0 * std::abs(drift), drift > 0.0 ? "higher" : "lower"));
  }
  constexpr double most = ParticlesInsideObstacle::tolerated_share;
  if (!results.has("share_inside_obstacle") || !(results.number("share_inside_obstacle") > most)) return warnings;
  warnings.push_back(
      fmt::format("{:.3g} m^3 of snow ({:.0f} particles) lie inside the obstacle, up to {:.2g} m behind its surface: that is {:.2g} % of "
                  "the obstacle's volume up to the flow height (more than {:g} %). Force and heights are those of a mast that lets snow "
                  "in; take smaller cells (numerics.cell_size_m) and compare",
                  results.number("volume_inside_obstacle_m3"), results.number("particles_inside_obstacle"),
                  results.number("depth_inside_obstacle_m"), 100.0 * results.number("share_inside_obstacle"), 100.0 * most));
  return warnings;
}

}  // namespace mpm
