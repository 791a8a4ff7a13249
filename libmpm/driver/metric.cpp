#include "libmpm/driver/metric.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>

#include "libmpm/base/error.hpp"
#include "libmpm/config/nearest_word.hpp"
#include "libmpm/driver/observers.hpp"

namespace mpm {

namespace {

using Json = nlohmann::ordered_json;

/// Names of single values, vectors by component.
std::vector<std::string> names_in(const Json& results) {
  std::vector<std::string> names;
  for (const auto& [key, value] : results.items()) {
    if (!value.is_array()) names.push_back(key);
    for (std::size_t i = 0; value.is_array() && i < value.size(); ++i) names.push_back(component_name(key, i, value.size()));
  }
  return names;
}

/// force_mean_n[0] is force_mean_n.x.
std::string with_axis(const std::string& name) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (name.ends_with(fmt::format("[{}]", i))) return component_name(name.substr(0, name.size() - 3), i, 3);
  }
  return name;
}

/// Null without the name.
Json at(const Json& results, const std::string& name) {
  for (const auto& [key, value] : results.items()) {
    if (key == name) return value;
    for (std::size_t i = 0; value.is_array() && i < value.size(); ++i) {
      if (component_name(key, i, value.size()) == name) return value[i];
    }
  }
  return {};
}

/// @return the name as it is among the known ones. @throws ConfigError if it is not
std::string require_name(const std::string& name, const std::vector<std::string>& known) {
  const std::string key = with_axis(name);
  for (const std::string& same : {name, key}) {
    if (std::ranges::find(known, same) != known.end()) return same;
  }
  const bool vector = std::ranges::find(known, key + ".x") != known.end();
  const std::string nearest = nearest_word(key, known);
  throw ConfigError(fmt::format("metric {}: results.json has no such number; {}", name,
                                vector            ? fmt::format("it is a vector: give {0}.x, {0}.y or {0}.z", key)
                                : nearest.empty() ? "docs/results.md lists the metrics of a run"
                                                  : fmt::format("did you mean {}?", nearest)));
}

}  // namespace

std::string component_name(const std::string& vector, std::size_t i, std::size_t size) {
  return size == 3 ? fmt::format("{}.{}", vector, "xyz"[i]) : fmt::format("{}[{}]", vector, i);
}

std::string standard_error_name(std::string name) {
  constexpr std::string_view mean = "_mean";
  const auto place = name.find(mean);
  return place == std::string::npos ? "" : name.replace(place, mean.size(), "_standard_error");
}

Metric metric_of(const std::string& results_json, const std::string& name) {
  const Json results = Json::parse(results_json, nullptr, false);
  if (!results.is_object()) throw IoError("results.json is not a JSON object; run the case again");
  const std::string key = require_name(name, names_in(results));
  const Json value = at(results, key);
  if (value.is_string() || value.is_boolean()) throw ConfigError(fmt::format("metric {}: {} is not a number", name, value.dump()));
  Metric metric;
  if (value.is_number()) metric.value = value.get<double>();
  if (const Json error = at(results, standard_error_name(key)); error.is_number()) metric.standard_error = error.get<double>();
  return metric;
}

std::vector<std::string> known_metrics(const Case& c) {
  std::vector<std::string> names;
  for (const Result& r : expected_results(c).entries()) {
    if (std::holds_alternative<double>(r.value) || std::holds_alternative<std::uint64_t>(r.value)) names.push_back(r.name);
    const auto* vector = std::get_if<std::array<double, 3>>(&r.value);
    for (std::size_t i = 0; vector != nullptr && i < vector->size(); ++i) names.push_back(component_name(r.name, i, vector->size()));
  }
  return names;
}

void require_known_metrics(const Case& c, const std::vector<std::string>& names) {
  const std::vector<std::string> known = known_metrics(c);
  for (const std::string& name : names) (void)require_name(name, known);
}

}  // namespace mpm
