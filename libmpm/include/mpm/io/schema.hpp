#pragma once
/// What may stand in a case file or in a point path. Every key is declared once, in src/io/config_keys.cpp; reading, range
/// checks, suggestions, writing and the reference printed by `mpm schema` all follow from that one table.

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mpm {

enum class KeyType {
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
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;  ///< the end itself is not permitted

  [[nodiscard]] bool contains(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }
};

/// One key as a user sees it.
struct KeyInfo {
  std::string table;  ///< empty: above the first table
  std::string name;
  KeyType type = KeyType::number;
  std::string unit;  ///< empty: dimensionless
  std::optional<Range> range;
  std::vector<std::string> choices;
  std::string default_text;   ///< as TOML, or what happens when the key is left out; empty for a required key
  std::string required_when;  ///< empty: never; "always", or the condition
  std::string used_when;      ///< empty: always; where it is not used the key is refused
  std::string description;
};

/// One table as a user sees it.
struct TableInfo {
  std::string name;  ///< empty: the keys above the first table
  bool repeated;     ///< [[name]], any number of times
  bool in_case;      ///< may stand in a case file
  bool in_path;      ///< may stand in a point path
  std::string description;
};

/// One constitutive law as a user sees it.
struct ModelInfo {
  std::string name;  ///< value of material.model
  std::string description;
  std::vector<std::string> keys;  ///< keys of [material] that it uses besides model and density_kg_m3
};

/// The tables, keys and laws, in the order in which they are written.
[[nodiscard]] const std::vector<TableInfo>& schema_tables();
[[nodiscard]] const std::vector<KeyInfo>& schema_keys();
[[nodiscard]] const std::vector<ModelInfo>& schema_models();

/// The reference that `mpm schema` prints: readable text, or one JSON object {format_version, tables, models}.
[[nodiscard]] std::string schema_text();
[[nodiscard]] std::string schema_json();

/// The candidate that a misspelt word most likely meant; empty if none is near. Near is: at most two edits (a third of the
/// longer word's length, if that is more; edits are insertion, deletion, substitution, swap of neighbours), or one word
/// beginning with the other (a forgotten unit).
[[nodiscard]] std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace mpm
