#pragma once
/// The measured quantities of a run: their columns, each with unit and meaning, from which files and the tables of the documentation
/// follow; their values at each sample; and the storage of observers in a checkpoint.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace mpm {

/// Data that a measurement needs.
enum class MeasuredFrom : std::uint8_t {
  frames,  ///< the particles of one instant; a stored frame suffices
  run,     ///< the running computation: sums over steps, the state, the machine
};

/// One column of series.csv, or of profile.csv.
struct Column {
  /// Time or interval of a value.
  enum class Kind : std::uint8_t {
    instant,        ///< at the time of the row
    interval_mean,  ///< mean over the interval since the previous row
  };
  std::string quantity;       ///< "force"
  char axis = '\0';           ///< 'x', 'y' or 'z': a component of a vector; 0: a scalar
  std::string unit;           ///< "N m", "kg m/s"; empty: a pure number
  std::string meaning;        ///< one line, for the documentation
  Kind kind = Kind::instant;  ///< time or interval of a value
  bool mean = false;          ///< whether results.json has its mean over the steady interval

  /// "force_x_n": quantity, axis, unit.
  [[nodiscard]] std::string name() const;
  /// "force_mean_n", "force_effective_samples": a statistic of the quantity, common to the components of a vector.
  [[nodiscard]] std::string statistic(std::string_view what, bool with_unit = true) const;
};

/// The three components of a vector quantity.
std::vector<Column> vector_columns(const Column& common);

/// A unit as the end of a name: "N m" gives "_n_m", "kg m/s" gives "_kg_m_s", "m^3" gives "_m3", "" without a unit.
std::string unit_suffix(std::string_view unit);

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

  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }   ///< all, time_s first
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }  ///< of all columns
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
