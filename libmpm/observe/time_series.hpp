#pragma once
/// The measured quantities of a run at each sample, as named columns; and the storage of observers in a checkpoint.

#include <cstddef>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/observe/column.hpp"

namespace mpm {

/// Named arrays of numbers: the state of an observer in a checkpoint.
using Arrays = std::map<std::string, std::vector<double>, std::less<>>;

/// An array of a known size. @throws IoError if it is missing or has another size
const std::vector<double>& stored_array(const Arrays& arrays, std::string_view name, std::size_t size);

/// Largest finite value of a series.
struct Peak {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN: no value is finite
  std::size_t at = 0;                                       ///< its index; of equal values the first
};
/// The largest finite value, with its index.
Peak peak_of(std::span<const double> values);

/// Rows of series.csv in memory. The first column is the time in s; rows are evenly spaced in time. NaN: unknown.
class TimeSeries {
 public:
  /// @param columns those after time_s. @throws Error if two have one name
  explicit TimeSeries(const std::vector<Column>& columns);

  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }   ///< without time_s
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }  ///< of all columns, time_s first
  [[nodiscard]] std::size_t size() const { return values_.front().size(); }       ///< rows

  /// @param row one number a column
  void append(std::span<const double> row);

  /// The values of a column. @throws Error for an unknown name
  [[nodiscard]] std::span<const double> operator[](std::string_view name) const;
  [[nodiscard]] std::span<const double> time() const { return values_.front(); }  ///< s
  /// All values, column by column.
  [[nodiscard]] const std::vector<std::vector<double>>& values() const { return values_; }

  [[nodiscard]] Arrays save() const;  ///< one array a column, by its name
  /// @param rows number of rows that each column must have. @throws IoError if one has not, or for columns of other observers; the series
  /// is then unchanged
  void load(const Arrays& arrays, std::size_t rows);

 private:
  std::vector<Column> columns_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> values_;
};

}  // namespace mpm
