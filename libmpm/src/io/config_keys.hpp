#pragma once
/// Internal to io/config: the key table with its bindings to the data that a file fills.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "mpm/case.hpp"
#include "mpm/io/schema.hpp"
#include "mpm/types.hpp"

namespace mpm::config {

/// A value as it stands in a file; the alternative follows from KeyType (text and choice: string; axes: list of strings).
using Value = std::variant<bool, std::int64_t, double, std::string, Vec3, Mat3, std::vector<std::string>>;

/// One entry of path.segments; which of the three kinds it is follows from the keys given.
struct SegmentDraft {
  std::optional<double> d_eps_v, d_eps_q;
  std::optional<Mat3> velocity_gradient;  ///< 1/s
  std::optional<double> time;             ///< s
  std::optional<double> radial_stress;    ///< Pa
  std::optional<double> d_eps_axial;
};

/// Everything that a case file or a point path can say, before alternatives are resolved.
struct Draft {
  Case spec;
  std::optional<double> froude_number;   ///< instead of conveyor.velocity
  std::optional<double> conveyor_width;  ///< empty: from hardening_xi
  std::optional<double> friction_ratio;  ///< instead of obstacle.friction
  int steps_per_segment = 160;
  std::vector<SegmentDraft> segments;
};

/// A statement about the other keys of a draft; i: index in a repeated table.
struct Condition {
  std::string text;  ///< empty: always true
  std::string key;   ///< "table.name" of the key it depends on (in the same entry of a repeated table); empty: none
  std::function<bool(const Draft&, std::size_t i)> holds;
};

struct Key : KeyInfo {
  std::function<std::optional<Value>(const Draft&, std::size_t i)> get;  ///< empty: left out
  std::function<void(Draft&, std::size_t i, const Value&)> set;
  std::optional<Condition> used;      ///< none: always
  std::optional<Condition> required;  ///< none: never
};

/// The key table, in the order of schema_tables().
[[nodiscard]] const std::vector<Key>& keys();

/// How the reader makes room for a table that is present, and how many entries of it there are.
void add_entry(Draft& draft, const std::string& table);
[[nodiscard]] std::size_t entries(const Draft& draft, const std::string& table);

/// A value as TOML; numbers with as many digits as it takes to read the same bits.
[[nodiscard]] std::string to_toml(const Value& value);
/// A number alone.
[[nodiscard]] std::string to_toml(double value);

/// Key name in one entry: "material.density_kg_m3", "body[0].min_m", "title".
[[nodiscard]] std::string key_path(const std::string& table_path, const std::string& name);

/// The paper's belt width W = (6 + 3 log10(xi/0.05)) w (Sect. 2.2); 12 w, its value at xi = 5, for a law without xi.
[[nodiscard]] double default_conveyor_width(const MaterialSpec& material, double obstacle_width);

}  // namespace mpm::config
