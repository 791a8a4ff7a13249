#include "libmpm/observe/time_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

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

const std::vector<double>& stored_array(const Arrays& arrays, std::string_view name, std::size_t size) {
  const auto found = arrays.find(name);
  if (found == arrays.end())
    throw IoError(fmt::format("there is no array '{}'; go on with the version of the program that wrote it", name));
  if (found->second.size() != size)
    throw IoError(fmt::format("the array '{}' has {} numbers, {} were expected", name, found->second.size(), size));
  return found->second;
}

Peak peak_of(std::span<const double> values) {
  Peak result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && !(result.value >= values[i])) result = {values[i], i};
  }
  return result;
}

TimeSeries::TimeSeries(const std::vector<Column>& columns) {
  columns_.push_back({.quantity = "time", .unit = "s", .meaning = "time; with a conveyor, since the front was at the obstacle"});
  columns_.insert(columns_.end(), columns.begin(), columns.end());
  for (const Column& column : columns_) {
    if (std::ranges::find(names_, column.name()) != names_.end())
      throw Error(ExitCode::internal, fmt::format("two columns of the series have the name '{}'", column.name()));
    names_.push_back(column.name());
  }
  values_.resize(columns_.size());
}

void TimeSeries::append(std::span<const double> row) {
  if (row.size() != values_.size())
    throw Error(ExitCode::internal, fmt::format("a row of {} numbers for a series of {} columns", row.size(), values_.size()));
  for (std::size_t i = 0; i < row.size(); ++i) values_[i].push_back(row[i]);
}

std::span<const double> TimeSeries::operator[](std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  if (found == names_.end()) throw Error(ExitCode::internal, fmt::format("the series has no column '{}'", name));
  return values_[static_cast<std::size_t>(found - names_.begin())];
}

Arrays TimeSeries::save() const {
  Arrays arrays;
  for (std::size_t i = 0; i < names_.size(); ++i) arrays[names_[i]] = values_[i];
  return arrays;
}

void TimeSeries::load(const Arrays& arrays, std::size_t rows) {
  if (arrays.size() > names_.size()) {
    throw IoError(
        fmt::format("{} columns of series.csv are stored, this run writes {}; go on with the version and the observers that began it",
                    arrays.size(), names_.size()));
  }
  std::vector<std::vector<double>> values;
  for (const std::string& name : names_) values.push_back(stored_array(arrays, name, rows));
  values_ = std::move(values);
}

}  // namespace mpm
