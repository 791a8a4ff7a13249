#pragma once
/// How a component declares its parameters: once, beside the struct that holds them.
///
///     struct Parameters {
///       double friction_angle = 0.5;  ///< phi, rad
///       template <class Table>
///       static void declare(Table& table) {
///         table.add("friction_angle_deg", &Parameters::friction_angle).degrees().range(1e-9, 89.0).required().text("Friction angle phi");
///       }
///       template <class Report>
///       void check(Report& report) const {  // optional: conditions between parameters, through a ParameterReport
///         if (report.all_valid({"a_m", "b_m"}) && a > b) report.problem("a_m", "is above b_m; exchange them");
///       }
///     };
///
/// The default is the member's initialiser. Case files, range checks (of a file and of a struct filled in C++), error messages and the
/// reference of `mpm schema` all follow from this declaration. `declare` and `check` are templates so that a header with parameters
/// includes nothing; a long `check` may take a ParameterReport& and be defined in a source file.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "libmpm/base/types.hpp"

namespace mpm {

/// Receives the errors that a component finds in its parameters. Names are those of one table ("cfl"), or paths ("numerics.cfl", or a whole
/// table "numerics") where a check spans several tables.
class ParameterReport {
 public:
  virtual ~ParameterReport() = default;
  /// Whether a parameter was given, as opposed to left at its default.
  [[nodiscard]] virtual bool given(const std::string& name) const = 0;
  /// Whether no error is known of a parameter. A check that combines parameters needs all of them to be valid.
  [[nodiscard]] virtual bool valid(const std::string& name) const = 0;
  /// @param text  continues a sentence that begins with the name: "= 3 is above ..., give at most 2"; of a table: with its brackets, and of
  ///              the whole file (an empty name): a sentence of its own
  virtual void problem(const std::string& name, const std::string& text) = 0;

  /// Whether no error is known of any of these parameters.
  [[nodiscard]] bool all_valid(const std::vector<std::string>& names) const {
    return std::all_of(names.begin(), names.end(), [&](const std::string& name) { return valid(name); });
  }
};

/// The report of one table (or of one entry of a repeated table) as a part of a larger one.
class TableReport final : public ParameterReport {
 public:
  /// @param all    report of the whole file; must outlive this one @param table  path of the table or entry
  /// ("body[0]"); empty: none
  TableReport(ParameterReport& all, std::string table) : all_(all), table_(std::move(table)) {}
  [[nodiscard]] bool given(const std::string& name) const override { return all_.given(path(name)); }
  [[nodiscard]] bool valid(const std::string& name) const override { return all_.valid(path(name)); }
  void problem(const std::string& name, const std::string& text) override { all_.problem(path(name), text); }

 private:
  [[nodiscard]] std::string path(const std::string& name) const {
    return table_.empty() ? name : name.empty() ? table_ : table_ + "." + name;
  }
  ParameterReport& all_;
  std::string table_;
};

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
  bool hide_default = false;                   ///< not in the hash of a case while it has its default, so that cases without it keep theirs
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

/// A parameter of an Owner, with access to its value.
template <class Owner>
struct Parameter {
  ParameterInfo info;                                              ///< description for users
  std::function<std::optional<ParameterValue>(const Owner&)> get;  ///< empty: left out
  std::function<void(Owner&, const ParameterValue&)> set;          ///< the value has the right type

  /// Unit of the value as a user gives it, "kg/m^3".
  Parameter& unit(std::string u) { return info.unit = std::move(u), *this; }
  /// One line for the reference of keys.
  Parameter& text(std::string description) { return info.description = std::move(description), *this; }
  /// [low, high]
  Parameter& range(double low, double high) { return info.range = Range{low, high}, *this; }
  /// [low, high)
  Parameter& below(double low, double high) { return info.range = Range{low, high, false, true}, *this; }
  /// Above 0. The least value is far below any useful one; it prevents overflow of counts and quotients.
  Parameter& positive(double high) { return range(1e-9, high); }
  /// The permitted words or whole numbers.
  Parameter& one_of(std::vector<std::string> choices) { return info.choices = std::move(choices), *this; }
  /// Effect of omitting the parameter.
  Parameter& left_out(std::string what) { return info.left_out = "left out: " + std::move(what), *this; }
  /// Required wherever the parameter is used.
  Parameter& required() { return info.required = Condition{}, *this; }
  /// Required in a file that does not have this table.
  Parameter& required_without_table(std::string table) {
    return info.required = Condition{{{.table = std::move(table), .present = false}}}, *this;
  }
  /// Used only where another parameter of the table is one of these words; refused elsewhere.
  Parameter& only_with(std::string key, std::vector<std::string> words) {
    return info.used.tests.push_back({.key = std::move(key), .words = std::move(words)}), *this;
  }
  /// Used only where another parameter of the table is below a limit; refused elsewhere.
  Parameter& only_below(std::string key, double limit) { return info.used.tests.push_back({.key = std::move(key), .below = limit}), *this; }
  /// Used only in a file that has this table (present), or that does not have it.
  Parameter& only_with_table(std::string table, bool present = true) {
    return info.used.tests.push_back({.table = std::move(table), .present = present}), *this;
  }
  /// The other parameter sets the same quantity: at most one of the two may be given.
  Parameter& excludes(std::string other) { return info.excludes.push_back(std::move(other)), *this; }
  /// Not written while it has its default, so that the hash of cases without it stays.
  Parameter& hide_default() { return info.hide_default = true, *this; }
  /// Not part of the hash of a case: the parameter sets how long a run lasts, or what it writes at which time of the clock, but no number
  /// that it computes.
  Parameter& no_effect_on_results() { return info.affects_results = false, *this; }

  /// Degrees outside, radians inside. The value in degrees is written so that it reads back to the same radians.
  Parameter& degrees() {
    constexpr double rad = std::numbers::pi / 180.0;
    get = [inner = get](const Owner& owner) -> std::optional<ParameterValue> {
      const auto value = inner(owner);
      if (!value) return std::nullopt;
      const double exact = std::get<double>(*value), degrees = exact / rad;
      const double round = std::round(degrees * 1e9) / 1e9;  // few digits, if these suffice
      for (const double candidate : {round, degrees, std::nextafter(degrees, -1e9), std::nextafter(degrees, 1e9)}) {
        if (candidate * rad == exact) return candidate;
      }
      return degrees;
    };
    set = [inner = set](Owner& owner, const ParameterValue& value) { inner(owner, std::get<double>(value) * rad); };
    return unit("deg");
  }
  /// Changes a value before it is stored. @param change  T -> T
  template <class T>
  Parameter& stored_as(T (*change)(const T&)) {
    set = [inner = set, change](Owner& owner, const ParameterValue& value) { inner(owner, change(std::get<T>(value))); };
    return *this;
  }
};

namespace detail {

template <class T>
constexpr ParameterType parameter_type() {
  if constexpr (requires { typename T::value_type; } && !std::same_as<T, std::string> && !std::same_as<T, Vec3> && !std::same_as<T, Mat3>) {
    return parameter_type<typename T::value_type>();  // std::optional
  } else if constexpr (std::same_as<T, bool>) {
    return ParameterType::boolean;
  } else if constexpr (std::integral<T>) {
    return ParameterType::integer;
  } else if constexpr (std::same_as<T, std::string>) {
    return ParameterType::text;
  } else if constexpr (std::same_as<T, Vec3>) {
    return ParameterType::vector;
  } else if constexpr (std::same_as<T, Mat3>) {
    return ParameterType::matrix;
  } else {
    static_assert(std::same_as<T, double>);
    return ParameterType::number;
  }
}

}  // namespace detail

/// All parameters of an Owner, in the order in which they are written.
template <class Owner>
class ParameterTable {
 public:
  /// Takes the declarations of Owner; the defaults are those of Owner{}.
  ParameterTable() {
    Owner::declare(*this);
    for (Parameter<Owner>& p : all_) {
      if (!p.info.preset) p.info.preset = p.get(Owner{});
    }
  }

  [[nodiscard]] const std::vector<Parameter<Owner>>& all() const { return all_; }  ///< in the order of declaration

  /// A member: double, int, bool, std::string, Vec3, Mat3, or a std::optional of these.
  template <class Base, class T>
  Parameter<Owner>& add(std::string name, T Base::*member) {
    return add(
        std::move(name), detail::parameter_type<T>(),
        [member](const Owner& owner) -> std::optional<ParameterValue> {
          const T& x = owner.*member;
          if constexpr (std::same_as<T, int>) {
            return std::int64_t{x};
          } else if constexpr (requires { x.has_value(); }) {
            return x ? std::optional<ParameterValue>(*x) : std::nullopt;
          } else {
            return x;
          }
        },
        [member](Owner& owner, const ParameterValue& value) {
          T& x = owner.*member;
          if constexpr (std::same_as<T, int>) {
            x = static_cast<int>(std::get<std::int64_t>(value));
          } else if constexpr (requires { x.has_value(); }) {
            x = std::get<typename T::value_type>(value);
          } else {
            x = std::get<T>(value);
          }
        });
  }

  /// An enumeration, as one of its words in the order of the enumerators.
  template <class Base, class Enum>
  Parameter<Owner>& add(std::string name, Enum Base::*member, const std::vector<std::string>& words) {
    return add(
               std::move(name), ParameterType::choice,
               [member, words](const Owner& owner) -> std::optional<ParameterValue> {
                 return words.at(static_cast<std::size_t>(owner.*member));
               },
               [member, words](Owner& owner, const ParameterValue& value) {
                 const auto at = std::find(words.begin(), words.end(), std::get<std::string>(value));
                 owner.*member = static_cast<Enum>(at - words.begin());
               })
        .one_of(words);
  }

  /// Two flags, written as the list of the axes whose flag is set.
  template <class Base>
  Parameter<Owner>& add_axes(std::string name, bool Base::*x, bool Base::*y) {
    using Words = std::vector<std::string>;
    return add(
               std::move(name), ParameterType::axes,
               [x, y](const Owner& owner) -> std::optional<ParameterValue> {
                 Words axes;
                 if (owner.*x) axes.emplace_back("x");
                 if (owner.*y) axes.emplace_back("y");
                 return axes;
               },
               [x, y](Owner& owner, const ParameterValue& value) {
                 const auto& axes = std::get<Words>(value);
                 owner.*x = std::find(axes.begin(), axes.end(), "x") != axes.end();
                 owner.*y = std::find(axes.begin(), axes.end(), "y") != axes.end();
               })
        .one_of({"x", "y"});
  }

  /// A constant: the only permitted number; it is not stored.
  Parameter<Owner>& add_constant(std::string name, int only) {
    return add(
               std::move(name), ParameterType::integer, [only](const Owner&) { return std::int64_t{only}; },
               [](Owner&, const ParameterValue&) {})
        .one_of({std::to_string(only)});
  }

  /// A parameter with its own access functions. @param get  returns nothing if the parameter is left out
  Parameter<Owner>& add(std::string name, ParameterType type, std::function<std::optional<ParameterValue>(const Owner&)> get,
                        std::function<void(Owner&, const ParameterValue&)> set) {
    ParameterInfo info;
    info.name = std::move(name);
    info.type = type;
    Parameter<Owner>& p = all_.emplace_back();
    p.info = std::move(info);
    p.get = std::move(get);
    p.set = std::move(set);
    return p;
  }

  /// A std::variant of structs with parameters: the parameter `name` says which of them it is, by their `name`s; then follow the parameters
  /// of all; common ones appear once. A parameter of some alternatives is used with these only.
  template <class... P>
  void alternatives(const std::string& name, std::variant<P...> Owner::*member, std::string description) {
    const std::size_t first = all_.size() + 1;
    add(
        name, ParameterType::choice,
        [member](const Owner& owner) -> std::optional<ParameterValue> {
          return std::visit([](const auto& p) { return std::string(p.name); }, owner.*member);
        },
        [member](Owner& owner, const ParameterValue& value) {
          const auto take = [&]<class Q>(std::type_identity<Q>) {
            if (Q::name == std::get<std::string>(value)) owner.*member = Q{};
          };
          (take(std::type_identity<P>{}), ...);
        })
        .text(std::move(description))
        .one_of({std::string(P::name)...});
    (take_over<P>(name, member, first), ...);
    for (std::size_t i = first; i < all_.size(); ++i) {
      Condition& used = all_[i].info.used;
      std::optional<Condition>& required = all_[i].info.required;
      if (required && *required == used) required = Condition{};
      if (used.tests.front().words.size() == sizeof...(P)) used.tests.erase(used.tests.begin());
    }
  }

 private:
  /// The parameters of one alternative.
  template <class Q, class Variant>
  void take_over(const std::string& name, Variant Owner::*member, std::size_t first) {
    const ParameterTable<Q> table;
    for (const Parameter<Q>& inner : table.all()) {
      const auto there = std::find_if(all_.begin() + static_cast<std::ptrdiff_t>(first), all_.end(),
                                      [&](const Parameter<Owner>& p) { return p.info.name == inner.info.name; });
      const bool is_new = there == all_.end();
      Parameter<Owner>& p = is_new ? all_.emplace_back() : *there;
      const Condition::Test own{.key = name, .words = {std::string(Q::name)}};
      if (is_new) {
        p.info = inner.info;
        p.info.used.tests.insert(p.info.used.tests.begin(), own);
        if (p.info.required) p.info.required->tests.insert(p.info.required->tests.begin(), own);
        p.get = [](const Owner&) { return std::nullopt; };
        p.set = [](Owner&, const ParameterValue&) {};
      } else {
        merge(p.info, inner.info, own);
      }
      p.get = [member, get = inner.get, others = p.get](const Owner& owner) {
        const Q* q = std::get_if<Q>(&(owner.*member));
        return q != nullptr ? get(*q) : others(owner);
      };
      p.set = [member, set = inner.set, others = p.set](Owner& owner, const ParameterValue& value) {
        if (Q* q = std::get_if<Q>(&(owner.*member)))
          set(*q, value);
        else
          others(owner, value);
      };
    }
  }

  /// Extends a parameter that an earlier alternative already has.
  static void merge(ParameterInfo& p, const ParameterInfo& other, const Condition::Test& own) {
    p.used.tests.front().words.push_back(own.words.front());
    if (other.required) {
      if (p.required)
        p.required->tests.front().words.push_back(own.words.front());
      else
        p.required = Condition{{own}};
    }
    if (p.preset != other.preset) p.preset.reset(), p.left_out = "depends on " + own.key;
    if (p.description != other.description) p.description += "; " + own.words.front() + ": " + other.description;
  }

  std::vector<Parameter<Owner>> all_;
};

/// The table of an Owner, made once.
template <class Owner>
const ParameterTable<Owner>& parameters_of() {
  static const ParameterTable<Owner> table;
  return table;
}

namespace detail {

/// Collects the problems of parameters that come from C++, where every parameter counts as given.
class CollectedProblems final : public ParameterReport {
 public:
  [[nodiscard]] bool given(const std::string&) const override { return true; }
  [[nodiscard]] bool valid(const std::string& name) const override { return std::find(names_.begin(), names_.end(), name) == names_.end(); }
  void problem(const std::string& name, const std::string& text) override;
  /// @throws ConfigError with all problems, one a line, if there is one.
  void throw_if_any() const;

 private:
  std::vector<std::string> names_;
  std::string message_;
};

}  // namespace detail

/// Checks the ranges of the table, and calls the owner's own `check`. @returns owner
/// @throws ConfigError with all problems, one a line: "cohesion_beta = 1.5 is out of range; give a number in [0, 1)"
template <class Owner>
const Owner& checked(const Owner& owner) {
  detail::CollectedProblems problems;
  for (const Parameter<Owner>& p : parameters_of<Owner>().all()) {
    const auto value = p.get(owner);
    if (const std::string what = value ? value_problem(p.info, *value) : ""; !what.empty())
      problems.problem(p.info.name, "= " + value_text(*value) + " " + what + "; give " + expected_value(p.info));
  }
  if constexpr (requires { owner.check(problems); }) owner.check(problems);
  problems.throw_if_any();
  return owner;
}

}  // namespace mpm
