#include "libmpm/observe/column.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>

#include "libmpm/base/error.hpp"

namespace mpm {

std::string unit_suffix(std::string_view unit) {
  if (unit.empty()) return {};
  std::string suffix = "_";
  for (const char c : unit) {
    if (c != '^') suffix += c == ' ' || c == '/' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return suffix;
}

std::string Column::name() const { return quantity + (axis != '\0' ? std::string{'_', axis} : "") + unit_suffix(unit); }

std::string Column::statistic(std::string_view what, bool with_unit) const {
  return fmt::format("{}_{}{}", quantity, what, with_unit ? unit_suffix(unit) : "");
}

std::vector<Column> vector_columns(const Column& common) {
  std::vector<Column> columns(3, common);
  for (std::size_t i = 0; i < 3; ++i) columns[i].axis = "xyz"[i];
  return columns;
}

void Results::add(std::vector<Result> results) { std::ranges::move(results, std::back_inserter(entries_)); }

const Result* Results::find(std::string_view name) const {
  const auto found = std::ranges::find(entries_, name, &Result::name);
  return found == entries_.end() ? nullptr : &*found;
}

double Results::number(std::string_view name, std::size_t component) const {
  const Result* result = find(name);
  if (result == nullptr) throw Error(ExitCode::internal, fmt::format("the run has no result '{}'", name));
  if (const auto* number = std::get_if<double>(&result->value)) return *number;
  if (const auto* count = std::get_if<std::uint64_t>(&result->value)) return static_cast<double>(*count);
  if (const auto* yes = std::get_if<bool>(&result->value)) return *yes ? 1.0 : 0.0;
  if (const auto* vector = std::get_if<std::array<double, 3>>(&result->value)) return vector->at(component);
  throw Error(ExitCode::internal, fmt::format("the result '{}' is a text", name));
}

}  // namespace mpm
