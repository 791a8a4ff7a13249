#pragma once
/// A parameter as a user sees it: name, kind of value, unit, range, when it is used or required; and how messages print these. How a
/// component declares its parameters is in parameter.hpp.

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "libmpm/base/types.hpp"

namespace mpm {

/// A value as a user writes it; the alternative follows from ParameterType (text and choice: string; axes: list of strings).
using ParameterValue = std::variant<bool, std::int64_t, double, std::string, Vec3, Mat3, std::vector<std::string>>;

/// Type of a value; determines how a file writes it.
enum class ParameterType {
  text,     ///< a string
  choice,   ///< one of a few strings
  number,   ///< a float; an integer is accepted
  integer,  ///< a whole number, one of `choices` where these are given
  boolean,
  vector,  ///< three numbers [x, y, z]
  matrix,  ///< three rows of three numbers
  axes,    ///< a list of distinct axis names out of `choices`
};

/// Interval of permitted values; every component of a vector or matrix has to lie in it.
struct Range {
  double low = -std::numeric_limits<double>::infinity();  ///< least value
  double high = std::numeric_limits<double>::infinity();  ///< greatest value
  bool low_open = false, high_open = false;               ///< the end itself is not permitted

  /// Whether x is permitted.
  [[nodiscard]] bool contains(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }
  bool operator==(const Range&) const = default;
};

/// When a parameter is used, or required: all tests must hold. Without tests: always.
struct Condition {
  /// One test.
  struct Test {
    std::string key;                 ///< parameter of the same table that is tested
    std::vector<std::string> words;  ///< permitted values, or
    std::optional<double> below;     ///< upper limit of a number
    std::string table;               ///< with an empty key: this table is tested
    bool present = true;             ///< whether the table must be given, or must be absent
    bool operator==(const Test&) const = default;
  };
  std::vector<Test> tests;  ///< all must hold

  [[nodiscard]] bool always() const { return tests.empty(); }  ///< no test
  /// As a user reads it: feed = "window", [conveyor] and [obstacle], always
  [[nodiscard]] std::string text() const;
  bool operator==(const Condition&) const = default;
};

/// A parameter as a user sees it.
struct ParameterInfo {
  std::string name;                            ///< with its unit, as in a file: cell_size_m
  ParameterType type = ParameterType::number;  ///< type of its value
  std::string unit;                            ///< empty: dimensionless
  std::optional<Range> range;                  ///< of numbers; none: any finite number
  std::vector<std::string> choices;            ///< permitted words or whole numbers; empty: any
  std::string description;                     ///< one line for the reference of keys
  std::optional<ParameterValue> preset;        ///< the default; none if it may be omitted
  std::string left_out;                        ///< effect of omitting it, if the default does not show it
  Condition used;                              ///< elsewhere it is refused
  std::optional<Condition> required;           ///< none: never; tested if the parameter is used
  std::vector<std::string> excludes;           ///< parameters of the same table that set the same quantity: only one of them may be given
  bool hidden_preset = false;                  ///< not written while it has its default, so that older cases keep their hash
  bool affects_results = true;                 ///< part of the case's hash
};

/// "a number in [0, 1) Pa", "one of "a", "b"": what a parameter accepts.
[[nodiscard]] std::string expected_value(const ParameterInfo& parameter);

/// "[0, 1)"
[[nodiscard]] std::string range_text(const Range& range);

/// A value in a message, numbers with at most nine digits.
[[nodiscard]] std::string value_text(const ParameterValue& value);

/// The error of a value of the right type ("is out of range", "is not a finite number"); empty if nothing is.
[[nodiscard]] std::string value_problem(const ParameterInfo& parameter, const ParameterValue& value);

}  // namespace mpm
