/// `mpm compare A B`: do two results say the same?

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "mpm/error.hpp"
#include "mpm/io/json_text.hpp"

namespace mpm::app {

namespace {

using Json = nlohmann::ordered_json;

struct CompareArguments {
  std::filesystem::path a, b;
  std::optional<double> tolerance;
};

/// results.json by keys; vectors as name[0], name[1], ...
struct Results {
  std::vector<std::string> order;
  std::map<std::string, Json> values;

  void add(const std::string& key, const Json& value) {
    if (value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) add(fmt::format("{}[{}]", key, i), value[i]);
    } else if (value.is_object()) {
      for (const auto& [name, member] : value.items()) add(key.empty() ? name : key + "." + name, member);
    } else {
      order.push_back(key);
      values[key] = value;
    }
  }
  [[nodiscard]] Json at(const std::string& key) const {
    const auto found = values.find(key);
    return found == values.end() ? Json() : found->second;
  }
  /// A number, true and false as 1 and 0; empty for null, text and a missing key.
  [[nodiscard]] std::optional<double> number(const std::string& key) const {
    const Json value = at(key);
    if (value.is_boolean()) return value.get<bool>() ? 1.0 : 0.0;
    if (value.is_number()) return value.get<double>();
    return std::nullopt;
  }
};

Results read_results(const std::filesystem::path& directory) {
  const auto path = directory / "results.json";
  const Json json = Json::parse(read_json_text(path), nullptr, false);
  if (!json.is_object())
    throw IoError(fmt::format("{}: not a JSON object; recompute it with `mpm post {}`", path.string(), directory.string()));
  Results results;
  results.add("", json);
  return results;
}

bool contains(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

/// What describes the run and not its outcome, and what is itself a statement of uncertainty.
bool is_figure(const std::string& key) {
  static const auto run_keys = {"title",
                                "case_hash",
                                "version",
                                "commit",
                                "compiler",
                                "build_type",
                                "instruction_set",
                                "threads",
                                "wall_time_s",
                                "million_particle_steps_per_s",
                                "peak_memory_bytes",
                                "format_version"};
  return std::ranges::find(run_keys, key) == run_keys.end() && !contains(key, "_standard_error") && !contains(key, "_effective_samples");
}

/// X_mean_UNIT has its standard error in X_standard_error_UNIT.
std::optional<double> standard_error(const Results& results, std::string key) {
  const auto place = key.find("_mean");
  if (place == std::string::npos) return std::nullopt;
  return results.number(key.replace(place, std::string_view("_mean").size(), "_standard_error"));
}

bool compare(const CompareArguments& arguments) {
  const Results a = read_results(arguments.a), b = read_results(arguments.b);
  // One case, run for the same time by the same program, has the same figures to the bit, on any number of threads.
  const bool same_run = a.values.contains("case_hash") && std::ranges::all_of(std::vector{"case_hash", "commit", "duration_s"},
                                                                              [&](const char* key) { return a.at(key) == b.at(key); });
  std::vector<std::string> keys = a.order;
  std::ranges::copy_if(b.order, std::back_inserter(keys), [&](const std::string& key) { return !a.values.contains(key); });

  fmt::print("{:<36} {:>14} {:>14} {:>12} {:>10} {:>12}  {}\n", "figure", "A", "B", "B - A", "relative", "allowed", "verdict");
  int judged = 0, failed = 0;
  for (const std::string& key : keys) {
    if (!is_figure(key)) continue;
    const auto x = a.number(key), y = b.number(key);
    if (!x && !y && a.at(key) == b.at(key)) continue;  // no figure on either side, or the same text
    if (!x || !y) {                                    // one side has no such figure, or they are different texts
      const auto text = [](const Json& value) { return value.is_null() ? std::string("none") : value.dump(); };
      const bool judge = x || y || same_run;
      judged += judge ? 1 : 0;
      failed += judge ? 1 : 0;
      fmt::print("{:<36} {:>14} {:>14} {:>12} {:>10} {:>12}  {}\n", key, text(a.at(key)), text(b.at(key)), "", "", "",
                 judge ? "DIFFERS" : "not judged");
      continue;
    }
    const double difference = *y - *x, scale = std::max(std::abs(*x), std::abs(*y));
    const auto error_a = standard_error(a, key), error_b = standard_error(b, key);
    const bool uncertain = error_a && error_b;
    const bool judge = uncertain || arguments.tolerance || same_run;
    const double allowed = std::max(uncertain ? 2.0 * std::hypot(*error_a, *error_b) : 0.0, arguments.tolerance.value_or(0.0) * scale);
    const bool holds = std::abs(difference) <= allowed;
    judged += judge ? 1 : 0;
    failed += judge && !holds ? 1 : 0;
    fmt::print("{:<36} {:>14.7g} {:>14.7g} {:>12.4g} {:>10} {:>12}  {}\n", key, *x, *y, difference,
               scale > 0.0 ? fmt::format("{:+.3f} %", 100.0 * difference / scale) : "", judge ? fmt::format("{:.4g}", allowed) : "",
               !judge  ? "not judged"
               : holds ? (difference == 0.0 ? "identical" : "agrees")
                       : "DIFFERS");
  }
  if (judged == 0) {
    throw ConfigError(
        fmt::format("{} and {}: nothing could be judged: they are of different cases, and no figure has a standard error; give --tolerance",
                    arguments.a.string(), arguments.b.string()));
  }
  fmt::print("{} of {} figures judged, {} differ ({})\n", judged, std::ranges::count_if(keys, is_figure), failed,
             same_run ? "same case, program and duration: what has no standard error must be identical"
                      : "different case, program or duration: what has no standard error is judged only with --tolerance");
  return failed == 0;
}

}  // namespace

void add_compare(CLI::App& app) {
  CLI::App* command = app.add_subcommand("compare",
                                         "Compare every figure of two result folders; exit code 1 if one differs by more than twice the "
                                         "combined standard error. Figures without a "
                                         "standard error must be identical if both folders hold the same case, run for the same time by "
                                         "the same program; else they are shown only");
  const auto arguments = std::make_shared<CompareArguments>();
  command->add_option("A", arguments->a, "Result folder")->required()->type_name("DIR");
  command->add_option("B", arguments->b, "Result folder")->required()->type_name("DIR");
  command->add_option("--tolerance", arguments->tolerance, "Also allow this relative difference, and judge every figure")
      ->type_name("REL")
      ->check(CLI::NonNegativeNumber);
  command->callback([arguments] {
    if (!compare(*arguments)) throw CLI::RuntimeError(static_cast<int>(ExitCode::failed));
  });
}

}  // namespace mpm::app
