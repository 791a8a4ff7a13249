#include <fmt/format.h>

#include <cmath>

#include "libmpm/driver/run.hpp"
#include "libmpm/observe/particles_inside_obstacle.hpp"

namespace mpm {

namespace {

/// A number, or "unknown".
std::string shown(double value, double scale) { return std::isfinite(value) ? fmt::format("{:.3g}", value * scale) : "unknown"; }

}  // namespace

std::string summary_text(const Results& results) {
  if (!results.has("steady") || !results.has("force_mean_n")) return {};
  std::string text;
  if (results.number("steady") == 0.0) {
    text += "no steady interval, so no means: take a longer output.duration_s\n";
  } else {
    struct Line {
      const char *name, *mean, *standard_error, *numerical, *unit;
      double scale;
    };
    constexpr Line lines[] = {
        {"run-up", "runup_p99_mean_m", "runup_p99_standard_error_m", "runup_p99_numerical_uncertainty_m", "m", 1.0},
        {"highest particle", "runup_mean_m", "runup_standard_error_m", "runup_numerical_uncertainty_m", "m", 1.0},
        {"pressure height", "pressure_height_mean_m", "pressure_height_standard_error_m", "pressure_height_numerical_uncertainty_m", "m",
         1.0},
        {"force downstream", "force_mean_n", "force_standard_error_n", "force_x_numerical_uncertainty_n", "kN", 1e-3},
        {"overturning moment", "overturning_moment_mean_n_m", "overturning_moment_standard_error_n_m",
         "overturning_moment_numerical_uncertainty_n_m", "kN m", 1e-3},
    };
    text += fmt::format("means from {:.3g} to {:.3g} s:\n", results.number("steady_from_s"), results.number("steady_to_s"));
    for (const Line& line : lines) {
      text +=
          fmt::format("  {:<20}{:>8} {:<5} +- {} (statistics) +- {} (grid)\n", line.name, shown(results.number(line.mean), line.scale),
                      line.unit, shown(results.number(line.standard_error), line.scale), shown(results.number(line.numerical), line.scale));
    }
    text +=
        "  statistics: standard error of the mean in time; grid: estimated from published grid studies at this resolution, not from this "
        "run; neither contains snow and model\n";
    text += "  run-up: height that holds 99 % of the mass before the mast; highest particle: the paper's run-up\n";
    text += fmt::format("  moment about the mast's own axis, x = {:.3g} m, at the ground\n", results.number("overturning_moment_axis_x_m"));
  }
  text += "forces downstream, and which of them to design with:\n";
  const bool first = results.number("force_filtered_peak_time_s") <= results.number("first_impact_until_s");
  text += fmt::format(
      "  filtered peak {} kN (mean over {:.2g} s, at {:.3g} s{}): for design, with its uncertainty and the response of the mast "
      "(mpm design)\n",
      shown(results.number("force_filtered_peak_n"), 1e-3), results.number("force_window_s"), results.number("force_filtered_peak_time_s"),
      first ? ", first impact of an ideal vertical front" : "");
  if (results.number("steady") != 0.0)
    text += fmt::format("  steady mean {} kN: the load while the avalanche passes, for what responds slowly, such as a foundation\n",
                        shown(results.number("force_mean_n"), 1e-3));
  text += fmt::format("  raw peak {} kN (a row of {:.2g} s, at {:.3g} s): no design value, it grows with output.series_per_second\n",
                      shown(results.number("force_peak_n"), 1e-3), results.number("force_interval_s"), results.number("force_peak_time_s"));
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
  constexpr double most = ParticlesInsideObstacle::tolerated_share;
  if (!results.has("share_inside_obstacle") || !(results.number("share_inside_obstacle") > most)) return {};
  return {fmt::format(
      "{:.3g} m^3 of snow ({:.0f} particles) lie inside the obstacle, up to {:.2g} m behind its surface: that is {:.2g} % of the "
      "obstacle's "
      "volume up to the flow height (more than {:g} %). Force and heights are those of a mast that lets snow in; take smaller cells "
      "(numerics.cell_size_m) and compare",
      results.number("volume_inside_obstacle_m3"), results.number("particles_inside_obstacle"), results.number("depth_inside_obstacle_m"),
      100.0 * results.number("share_inside_obstacle"), 100.0 * most)};
}

}  // namespace mpm
