#include "libmpm/observe/results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "libmpm/base/error.hpp"
#include "libmpm/io/json.hpp"

namespace mpm {

namespace {

using Json = nlohmann::ordered_json;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t components_of_a_vector = std::tuple_size_v<std::array<double, 3>>;

bool is_number(const Json& json) { return json.is_number() || json.is_null(); }
double number_of(const Json& json) { return json.is_null() ? no_number : json.get<double>(); }

/// Empty for what no entry has.
std::optional<Value> value_of(const Json& json) {
  if (json.is_number_unsigned()) return json.get<std::uint64_t>();
  if (is_number(json)) return number_of(json);
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_string()) return json.get<std::string>();
  if (!json.is_array() || json.size() != components_of_a_vector || !std::ranges::all_of(json, is_number)) return std::nullopt;
  return std::array{number_of(json[0]), number_of(json[1]), number_of(json[2])};
}

Json json_of(const Value& value) {
  return std::visit([](const auto& x) { return Json(x); }, value);  // NaN is not JSON: the serialiser writes null
}

}  // namespace

std::optional<Results> Results::from_json(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  Results results;
  for (const auto& [name, member] : json.items()) {
    std::optional<Value> value = value_of(member);
    if (!value) return std::nullopt;
    results.add({name, std::move(*value), {}, {}});
  }
  return results;
}

std::string Results::to_json() const {
  Json json = Json::object();
  // with_checksum fills in the checksum; that of a text which was read is not of this one
  for (const Result& r : entries_) json[r.name] = r.name == checksum_entry ? Json(no_checksum) : json_of(r.value);
  return with_checksum(json_text(json, 2));
}

void Results::add(std::vector<Result> results) { std::ranges::move(results, std::back_inserter(entries_)); }

void Results::replace(std::vector<Result> results) {
  for (Result& r : results) {
    const auto there = std::ranges::find(entries_, r.name, &Result::name);
    (there == entries_.end() ? entries_.emplace_back() : *there) = std::move(r);
  }
}

std::vector<Result> Results::components() const {
  std::vector<Result> all;
  for (const Result& r : entries_) {
    const auto* vector = std::get_if<std::array<double, 3>>(&r.value);
    if (vector == nullptr) all.push_back(r);
    for (std::size_t i = 0; vector != nullptr && i < vector->size(); ++i)
      all.push_back({component_name(r.name, i), (*vector)[i], r.unit, r.meaning, r.nature});
  }
  return all;
}

const Result* Results::find(std::string_view name) const {
  const auto found = std::ranges::find(entries_, name, &Result::name);
  return found == entries_.end() ? nullptr : &*found;
}

double Results::number(std::string_view name, std::size_t component) const {
  const Result* result = find(name);
  if (result == nullptr) throw Error(ExitCode::internal, fmt::format("the run has no result '{}'", name));
  if (const auto* vector = std::get_if<std::array<double, 3>>(&result->value)) return vector->at(component);
  if (std::holds_alternative<std::string>(result->value)) throw Error(ExitCode::internal, fmt::format("the result '{}' is a text", name));
  return as_number(result->value).value_or(no_number);
}

double Results::number_or_nan(std::string_view name) const {
  const Result* result = find(name);
  return result == nullptr ? no_number : as_number(result->value).value_or(no_number);
}

std::string Results::text(std::string_view name) const {
  const Result* result = find(name);
  const auto* text = result == nullptr ? nullptr : std::get_if<std::string>(&result->value);
  return text == nullptr ? "" : *text;
}

std::optional<double> as_number(const Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return std::isnan(*number) ? std::nullopt : std::optional(*number);
  if (const auto* count = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*count);
  if (const auto* yes = std::get_if<bool>(&value)) return *yes ? 1.0 : 0.0;
  return std::nullopt;
}

std::string as_json(const Value& value) { return json_of(value).dump(); }

std::string component_name(const std::string& vector, std::size_t i) { return fmt::format("{}.{}", vector, "xyz"[i]); }

std::string standard_error_name(std::string name) {
  constexpr std::string_view mean = "_mean";
  const auto place = name.find(mean);
  return place == std::string::npos ? "" : name.replace(place, mean.size(), "_standard_error");
}

}  // namespace mpm
