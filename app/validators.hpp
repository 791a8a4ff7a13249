#pragma once
/// Ranges of numbers on the command line. Those of CLI11 accept NaN, and print the largest double with all digits.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>
#include <string>

namespace mpm::app {

/// A number in [low, high].
inline CLI::Validator in_range(double low, double high) {
  return {[=](const std::string& text) {
            double x = std::numeric_limits<double>::quiet_NaN();
            const bool holds = CLI::detail::lexical_cast(text, x) && x >= low && x <= high;
            return holds ? "" : fmt::format("{} is not in [{:g}, {:g}]", text, low, high);
          },
          fmt::format("in [{:g}, {:g}]", low, high)};
}

/// A finite number above 0.
inline CLI::Validator above_zero() {
  return {[](const std::string& text) {
            double x = std::numeric_limits<double>::quiet_NaN();
            const bool holds = CLI::detail::lexical_cast(text, x) && std::isfinite(x) && x > 0.0;
            return holds ? "" : fmt::format("{} is not a number above 0", text);
          },
          "above 0"};
}

}  // namespace mpm::app
