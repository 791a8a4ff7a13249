#include "libmpm/impact/measurement_spec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmpm/base/parameter.hpp"

namespace mpm {

void check_measurement(const MeasurementSpec& measurement, double cell_size, ParameterReport& report) {
  const std::string name = "measurement.filter_length_m";
  if (!measurement.filter_length || !report.all_sound({name, "measurement.bin_height_m", "numerics.cell_size_m"})) return;
  const double length = *measurement.filter_length, bin = measurement.bin_height.value_or(0.5 * cell_size), bins = length / bin;
  constexpr double most_bins = 9999.0;
  if (bins > most_bins) {
    return report.problem(
        name, fmt::format("= {} is {:.6g} bins of {} m, more than {}; give a shorter filter or higher bins", length, bins, bin, most_bins));
  }
  const double odd = std::max(3.0, 2.0 * std::round(0.5 * (bins - 1.0)) + 1.0);
  constexpr double rounding = 1e-6;  // of lengths given to six digits
  if (std::abs(bins - odd) > rounding * odd) {
    report.problem(name, fmt::format("= {} is {:.6g} bin{} of {} m; give an odd number of bins, at least 3, such as {:.6g} m", length, bins,
                                     std::abs(bins - 1.0) < rounding ? "" : "s", bin, odd * bin));
  }
}

}  // namespace mpm
