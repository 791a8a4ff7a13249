#pragma once
/// Arguments of several subcommands: CASE.toml, --set, --threads, --ranks; and ranges of numbers. Those of CLI11 accept NaN, and print the
/// largest double with all digits.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "libmpm/driver/threads.hpp"

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

struct CaseArguments {
  std::filesystem::path file;
  std::vector<std::string> overrides;
};

/// --set table.key=value, any number of times.
inline void add_overrides_argument(CLI::App& command, std::vector<std::string>& overrides, const std::string& text) {
  command.add_option("--set", overrides, text)->type_name("table.key=value")->type_size(1)->allow_extra_args(false);
}

inline void add_case_arguments(CLI::App& command, CaseArguments& arguments) {
  command.add_option("case", arguments.file, "Case file (keys: `mpm schema`)")->required()->type_name("CASE.toml");
  add_overrides_argument(command, arguments.overrides, "Replace a key of the case: numerics.cell_size_m=0.5, body[0].velocity_m_s=[1,0,0]");
}

/// --threads N, of a command that computes.
inline void add_threads_argument(CLI::App& command, int& threads) {
  command
      .add_option("--threads", threads, fmt::format("Number of threads, at most {} on this machine (default: all cores)", most_threads()))
      ->check(in_range(1, most_threads()))
      ->type_name("N");
}

/// --ranks N, of a command that starts them.
inline void add_ranks_argument(CLI::App& command, int& ranks, const std::string& text) {
  constexpr int most_ranks = 100000;
  command.add_option("--ranks", ranks, text)->check(in_range(1, most_ranks))->type_name("N");
}

}  // namespace mpm::app
