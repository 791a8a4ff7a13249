/// `mpm compare A B`: whether two results agree.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "commands.hpp"
#include "libmpm/base/error.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/observe/results.hpp"

namespace mpm::app {

namespace {

struct CompareArguments {
  std::filesystem::path a, b;
  std::optional<double> tolerance;
  bool csv = false;
};

/// results.json, vectors by component: force_mean_n.x
Results read_results(const std::filesystem::path& directory) {
  const ResultsFile file(directory);
  if (!file.exists() && std::filesystem::exists(directory / "checkpoint.h5"))
    throw IoError(fmt::format("{0}: the run has not ended; go on with `mpm run CASE.toml --out {0} --resume`", directory.string()));
  if (!file.exists()) throw file_error("cannot read", directory / "results.json", ENOENT);
  file.require_undamaged();
  Results results;
  results.add(file.results()->components());
  return results;
}

/// Empty for a number that is unknown, and a missing key.
std::optional<Value> known_value(const Results& results, const std::string& key) {
  const Result* const found = results.find(key);
  const bool known = found != nullptr && (as_number(found->value) || std::holds_alternative<std::string>(found->value));
  return known ? std::optional(found->value) : std::nullopt;
}

/// A number, true and false as 1 and 0; empty for an unknown one, text and a missing key.
std::optional<double> known_number(const Results& results, const std::string& key) {
  const Result* const found = results.find(key);
  return found == nullptr ? std::nullopt : as_number(found->value);
}

/// Whether a key is an outcome of the computation, not information about the run or about uncertainty.
bool is_quantity(const std::string& key) { return nature_of(key) == Nature::physics; }

/// One quantity of two results, as printed: a table or, with --csv, CSV.
struct Row {
  std::string quantity, a, b, difference, relative, allowed, verdict;
};

/// Two results side by side.
class Comparison {
 public:
  explicit Comparison(const CompareArguments& arguments)
      : tolerance_(arguments.tolerance), csv_(arguments.csv), a_(read_results(arguments.a)), b_(read_results(arguments.b)) {
    same_run_ = a_.has("case_hash") && std::ranges::all_of(std::vector{"case_hash", "commit", "duration_s", "measured_from", "frames"},
                                                           [&](const char* key) { return known_value(a_, key) == known_value(b_, key); });
    for (const Results* results : {&a_, &b_}) {
      for (const Result& r : results->entries()) {
        if (is_quantity(r.name) && (results == &a_ || !a_.has(r.name))) keys_.push_back(r.name);
      }
    }
  }

  /// Prints a line for each quantity.
  void print() {
    if (csv_) {
      print({"quantity", "a", "b", "difference", "relative", "allowed", "verdict"});
    } else {
      print({"quantity", "A", "B", "B - A", "relative", "allowed", "verdict"});
    }
    constexpr const char* steady = "steady_column";
    if (known_value(a_, steady) != known_value(b_, steady)) compare_others(steady, false);
    for (const std::string& key : keys_) {
      const auto x = known_number(a_, key), y = known_number(b_, key);
      if (x && y) {
        compare_numbers(key, *x, *y);
      } else if (x || y || known_value(a_, key) != known_value(b_, key)) {
        compare_others(key, x || y);
      }
    }
    if (csv_) return;
    fmt::print("{} of {} quantities judged, {} differ ({})\n", judged_, keys_.size(), failed_,
               same_run_ ? "same case, program, duration and samples: what has no standard error must be identical"
                         : "different case, program, duration or samples: what has no standard error is judged only with --tolerance");
  }
  [[nodiscard]] int judged() const { return judged_; }
  [[nodiscard]] int failed() const { return failed_; }

 private:
  void compare_numbers(const std::string& key, double x, double y) {
    x += 0.0, y += 0.0;  // -0 becomes 0, and so in their difference
    const double difference = y - x, scale = std::max(std::abs(x), std::abs(y));
    const std::string of_error = standard_error_name(key);
    const auto error_a = known_number(a_, of_error), error_b = known_number(b_, of_error);
    const bool uncertain = error_a && error_b;
    const bool judge = uncertain || tolerance_ || same_run_;
    const double allowed = std::max(uncertain ? 2.0 * std::hypot(*error_a, *error_b) : 0.0, tolerance_.value_or(0.0) * scale);
    const bool holds = std::abs(difference) <= allowed;
    judged_ += judge ? 1 : 0;
    failed_ += judge && !holds ? 1 : 0;
    const std::string verdict = !judge ? "not judged" : holds ? (difference == 0.0 ? "identical" : "agrees") : "DIFFERS";
    if (csv_) {
      print({key, format_number(x), format_number(y), format_number(difference), scale > 0.0 ? format_number(difference / scale) : "nan",
             judge ? format_number(allowed) : "nan", verdict});
    } else {
      print({key, fmt::format("{:.7g}", x), fmt::format("{:.7g}", y), fmt::format("{:.4g}", difference),
             scale > 0.0 ? fmt::format("{:+.3f} %", 100.0 * difference / scale) : "", judge ? fmt::format("{:.4g}", allowed) : "",
             verdict});
    }
  }

  /// For a quantity that is missing on one side, or differs as text.
  void compare_others(const std::string& key, bool one_is_a_number) {
    const auto text = [](const std::optional<Value>& value) { return value ? as_json(*value) : "none"; };
    const bool judge = one_is_a_number || same_run_;
    judged_ += judge ? 1 : 0;
    failed_ += judge ? 1 : 0;
    const std::string nothing = csv_ ? "nan" : "";
    print({key, text(known_value(a_, key)), text(known_value(b_, key)), nothing, nothing, nothing, judge ? "DIFFERS" : "not judged"});
  }

  void print(const Row& row) const {
    if (csv_) {
      const std::array cells{row.quantity, row.a, row.b, row.difference, row.relative, row.allowed, row.verdict};
      fmt::print("{}", csv_line(cells));
    } else {
      fmt::print("{:<36} {:>14} {:>14} {:>12} {:>10} {:>12}  {}\n", row.quantity, row.a, row.b, row.difference, row.relative, row.allowed,
                 row.verdict);
    }
  }

  std::optional<double> tolerance_;
  bool csv_ = false;
  Results a_, b_;
  // Two runs of one case and duration by one program agree to the bit, on any number of threads. Results of frames (mpm post) have
  // fewer samples than those of the run.
  bool same_run_ = false;
  std::vector<std::string> keys_;
  int judged_ = 0, failed_ = 0;
};

bool compare(const CompareArguments& arguments) {
  Comparison comparison(arguments);
  comparison.print();
  if (comparison.judged() == 0) {
    throw ConfigError(
        fmt::format("{} and {}: nothing could be judged: they differ in case, program, duration or samples, and no quantity has a "
                    "standard error; give --tolerance",
                    arguments.a.string(), arguments.b.string()));
  }
  return comparison.failed() == 0;
}

}  // namespace

void add_compare(CLI::App& app) {
  CLI::App* command = app.add_subcommand("compare",
                                         "Compare every quantity of two result folders; exit code 1 if one differs by more than twice the "
                                         "combined standard error. Quantities without a "
                                         "standard error must be identical if both folders hold the same case, run for the same time by "
                                         "the same program; else they are shown only");
  const auto arguments = std::make_shared<CompareArguments>();
  command->add_option("A", arguments->a, "Result folder")->required()->type_name("DIR");
  command->add_option("B", arguments->b, "Result folder")->required()->type_name("DIR");
  command->add_option("--tolerance", arguments->tolerance, "Also allow this relative difference, and judge every quantity")
      ->type_name("REL")
      ->check(in_range(0.0, 1e300));
  command->add_flag("--csv", arguments->csv, "One line a quantity as CSV, with the header");
  command->callback([arguments] {
    if (!compare(*arguments)) throw CLI::RuntimeError(static_cast<int>(ExitCode::failed));
  });
}

}  // namespace mpm::app
