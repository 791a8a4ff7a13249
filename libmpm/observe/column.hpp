#pragma once
/// Descriptions of the measured quantities: columns of series.csv and entries of results.json, each with its unit and its meaning. Files,
/// the comparison of results and the tables of the documentation follow from these descriptions.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace mpm {

/// Data that a measurement needs.
enum class Source : std::uint8_t {
  particles,  ///< the particles of one instant; a stored frame suffices
  run,        ///< the running computation: sums over steps, the state, the machine
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

/// Nature of an entry of results.json, for the comparison of two results.
enum class Nature : std::uint8_t {
  physics,      ///< outcome of the computation: compared
  uncertainty,  ///< standard error, effective samples: the tolerance of the comparison
  execution,    ///< case, program, machine, time: not compared
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
  /// A number; true as 1, false as 0; NaN if unknown. @param component of a vector
  /// @throws Error for an unknown name, or a text
  [[nodiscard]] double number(std::string_view name, std::size_t component = 0) const;

 private:
  std::vector<Result> entries_;
};

}  // namespace mpm
