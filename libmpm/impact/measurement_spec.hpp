#pragma once
/// Windows of the measurements at the obstacle, as a case gives them.

#include <cstdint>
#include <optional>
#include <string>

#include "libmpm/base/types.hpp"

namespace mpm {

/// [measurement]: windows of the pressure profile on the obstacle, m. Empty values follow the cell size, as in the paper (Sect. 2.3).
/// A grid study should fix them, because the bias of a window that shrinks with the grid looks like a grid error.
struct MeasurementSpec {
  std::optional<double> bin_height;     ///< of the profile's bins; empty: dx/2
  std::optional<double> filter_length;  ///< of the Savitzky-Golay window, an odd number of bins; empty: 13 bins
  std::optional<double> box_upstream;   ///< depth of the measuring box before the face; empty: 2.5 dx
  std::optional<double> box_inside;     ///< its depth behind the face; empty: 0.5 dx
  double force_window = 0.1;            ///< s: of the moving mean behind the filtered peak of the force
  /// The run-up whose running mean decides where the steady interval begins and whether a run may end (impact/steady.hpp).
  enum class SteadyBy : std::uint8_t {
    runup_p99,
    runup
  } steady_by = SteadyBy::runup_p99;  ///< without single particles, or the highest particle
  bool operator==(const MeasurementSpec&) const = default;

  /// The column of series.csv that is steady in the steady interval.
  [[nodiscard]] std::string steady_column() const { return steady_by == SteadyBy::runup ? "runup_m" : "runup_p99_m"; }

  /// The keys of [measurement] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    const auto at_an_impact = [](auto& parameter) -> auto& { return parameter.only_with_table("conveyor").only_with_table("obstacle"); };
    at_an_impact(table.add("bin_height_m", &MeasurementSpec::bin_height))
        .unit("m")
        .positive(longest_length)
        .left_out("cell_size_m / 2")
        .text("Height of the pressure profile's bins");
    at_an_impact(table.add("filter_length_m", &MeasurementSpec::filter_length))
        .unit("m")
        .positive(longest_length)
        .left_out("13 bins")
        .text("Window of the Savitzky-Golay filter (degree 2) over the profile, an odd number of bins");
    at_an_impact(table.add("box_upstream_m", &MeasurementSpec::box_upstream))
        .unit("m")
        .positive(longest_length)
        .left_out("2.5 cell_size_m")
        .text("Depth of the measuring box before the obstacle's face");
    at_an_impact(table.add("box_inside_m", &MeasurementSpec::box_inside))
        .unit("m")
        .range(0.0, longest_length)
        .left_out("0.5 cell_size_m")
        .text("Depth of the measuring box behind the face, for particles that are slightly inside");
    at_an_impact(table.add("force_window_s", &MeasurementSpec::force_window))
        .unit("s")
        .positive(1e3)
        .hide_default()
        .text("Window of the moving mean of the force; the highest value of this mean is the filtered peak");
    at_an_impact(table.add("steady_by", &MeasurementSpec::steady_by, {"runup_p99", "runup"}))
        .no_effect_on_results()
        .hide_default()
        .text(
            "Run-up that has to be steady in the steady interval, over which all means are taken, and for output.stop_when_steady: "
            "runup_p99, the height that holds 99 % of the mass; runup, the highest particle, as the paper measures it");
  }
};

}  // namespace mpm
