#pragma once
/// What is measured, described: columns of series.csv and entries of results.json, each with its unit and its meaning. Files, the
/// comparison of results and the tables of the documentation follow from these descriptions.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace mpm {

/// What a measurement needs.
enum class Source : std::uint8_t {
  particles,  ///< the particles of one instant: a stored frame gives it again
  run,        ///< the run: sums over steps, the whole state, the machine
};

/// One column of series.csv, or of profile.csv.
struct Column {
  /// To which time a value belongs.
  enum class Kind : std::uint8_t {
    instant,        ///< at the time of the row
    interval_mean,  ///< mean over the interval since the row before
  };
  std::string quantity;       ///< "force"
  char axis = '\0';           ///< 'x', 'y' or 'z': a component of a vector; 0: a scalar
  std::string unit;           ///< "N m", "kg m/s"; empty: a pure number
  std::string meaning;        ///< one line, for the documentation
  Kind kind = Kind::instant;  ///< what the value of a row is
  bool mean = false;          ///< whether results.json has its mean over the steady interval

  /// "force_x_n": quantity, axis, unit.
  [[nodiscard]] std::string name() const;
  /// "force_mean_n", "force_effective_samples": a statistic of the quantity; the components of a vector share it.
  [[nodiscard]] std::string statistic(std::string_view what, bool with_unit = true) const;
};

/// The three components of a vector quantity.
std::vector<Column> vector_columns(const Column& common);

/// How a unit is written at the end of a name: "N m" gives "_n_m", "kg m/s" gives "_kg_m_s", no unit gives nothing.
std::string unit_suffix(std::string_view unit);

/// What an entry of results.json says, for the comparison of two results.
enum class Nature : std::uint8_t {
  physics,      ///< outcome of the computation: compared
  uncertainty,  ///< standard error, effective samples: what the comparison allows
  execution,    ///< which case, which program, which machine, how long: not compared
};

/// NaN: unknown; results.json has null then.
using Value = std::variant<double, std::uint64_t, bool, std::string, std::array<double, 3>>;

/// One entry of results.json.
struct Result {
  std::string name;                 ///< its key, with the unit at its end
  Value value;                      ///< NaN, alone or in an array: unknown
  std::string unit;                 ///< "N m"; empty: a pure number
  std::string meaning;              ///< one line, for the documentation
  Nature nature = Nature::physics;  ///< whether and how it is compared
};

/// The entries of results.json in their order.
class Results {
 public:
  /// Adds one entry at the end.
  void add(Result result) { entries_.push_back(std::move(result)); }
  /// Adds entries at the end.
  void add(std::vector<Result> results);
  [[nodiscard]] const std::vector<Result>& entries() const& { return entries_; }  ///< in their order
  [[nodiscard]] std::vector<Result> entries() && { return std::move(entries_); }  ///< moved out
  /// Null for an unknown name.
  [[nodiscard]] const Result* find(std::string_view name) const;
  [[nodiscard]] bool has(std::string_view name) const { return find(name) != nullptr; }  ///< whether there is an entry of this name
  /// A number; a yes as 1, a no as 0; NaN where it is unknown. @param component of a vector
  /// @throws Error for a name that the run does not have, or a text
  [[nodiscard]] double number(std::string_view name, std::size_t component = 0) const;

 private:
  std::vector<Result> entries_;
};

}  // namespace mpm
