#pragma once
/// The entries of results.json as values: observers make them, files hold them as JSON, and everything that reads a results.json (metrics,
/// the comparison, campaigns, studies) gets them from Results::from_json.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace mpm {

/// Nature of an entry of results.json, for the comparison of two results.
enum class Nature : std::uint8_t {
  physics,      ///< outcome of the computation: compared
  uncertainty,  ///< standard error, effective samples: the tolerance of the comparison
  execution,    ///< case, program, machine, time: not compared
};

/// Value of an entry. A number that is unknown, alone or in a vector, is NaN; results.json has null then.
using Value = std::variant<double, std::uint64_t, bool, std::string, std::array<double, 3>>;

/// One entry of results.json.
struct Result {
  std::string name;                 ///< its key, with the unit at its end
  Value value;                      ///< what was found
  std::string unit;                 ///< "N m"; empty: a pure number
  std::string meaning;              ///< one line, for the documentation
  Nature nature = Nature::physics;  ///< whether and how it is compared
};

/// The entries of results.json in their order.
class Results {
 public:
  /// The entries of a text, without units, meanings and natures. Empty if it is no JSON object of such values.
  [[nodiscard]] static std::optional<Results> from_json(const std::string& text);
  /// The content of results.json: one object, with the checksum (io/json.hpp) if it has that entry.
  [[nodiscard]] std::string to_json() const;

  /// Adds one entry at the end.
  void add(Result result) { entries_.push_back(std::move(result)); }
  /// Adds entries at the end.
  void add(std::vector<Result> results);
  /// Puts entries in the places of those of the same names, else at the end.
  void replace(std::vector<Result> results);

  [[nodiscard]] const std::vector<Result>& entries() const& { return entries_; }  ///< in their order
  [[nodiscard]] std::vector<Result> entries() && { return std::move(entries_); }  ///< moved out
  /// The entries with single values: vectors by component, force_mean_n.x.
  [[nodiscard]] std::vector<Result> components() const;
  /// Null for an unknown name.
  [[nodiscard]] const Result* find(std::string_view name) const;
  [[nodiscard]] bool has(std::string_view name) const { return find(name) != nullptr; }  ///< whether there is an entry of this name
  /// A number; true as 1, false as 0; NaN if unknown. @param component of a vector
  /// @throws Error for an unknown name, or a text
  [[nodiscard]] double number(std::string_view name, std::size_t component = 0) const;
  /// The same from a file that may lack the entry: NaN then, and for a text.
  [[nodiscard]] double number_or_nan(std::string_view name) const;
  /// A text; empty if there is none of this name.
  [[nodiscard]] std::string text(std::string_view name) const;

 private:
  std::vector<Result> entries_;
};

/// A single value as a number; true as 1, false as 0. Empty for an unknown number, a text and a vector.
[[nodiscard]] std::optional<double> as_number(const Value& value);
/// A value as results.json has it.
[[nodiscard]] std::string as_json(const Value& value);

/// The name of component i of a vector, force_mean_n.x, as all tables and commands have it.
[[nodiscard]] std::string component_name(const std::string& vector, std::size_t i);
/// The entry that holds the standard error of another one: X_standard_error_UNIT of X_mean_UNIT; empty for other names.
[[nodiscard]] std::string standard_error_name(std::string name);

}  // namespace mpm
