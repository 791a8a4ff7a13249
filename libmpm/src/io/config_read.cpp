#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <sstream>
#include <tuple>

#include "config_guard.hpp"
#include "config_keys.hpp"
#include "mpm/error.hpp"
#include "mpm/impact/semi_empirical.hpp"
#include "mpm/io/config.hpp"
#include "mpm/obstacle.hpp"
#include "mpm/point_path.hpp"
#include "toml_text.hpp"

namespace mpm::config {

namespace {

/// Where something stands; overrides come after the file.
struct Place {
  std::size_t override_number = 0;  ///< 1, 2, ... for --set
  std::uint32_t line = 1, column = 1;
  std::string text;

  [[nodiscard]] bool before(const Place& other) const {
    return std::tie(override_number, line, column) < std::tie(other.override_number, other.line, other.column);
  }
};

struct Fault {
  Place place;
  std::string text;
};

struct Override {
  std::string path;  ///< "body[0].velocity_m_s"
  std::string text;  ///< as given
};

std::string bracketed(const TableInfo& table) { return table.repeated ? "[[" + table.name + "]]" : "[" + table.name + "]"; }

/// "[material] " in front of a message; nothing for the keys above the first table.
std::string label(const std::string& table_path) { return table_path.empty() ? "" : "[" + table_path + "] "; }

std::string expected(const KeyInfo& key) {
  const std::string range = key.range ? fmt::format(" in {}{:g}, {:g}{}", key.range->low_open ? '(' : '[', key.range->low, key.range->high,
                                                    key.range->high_open ? ')' : ']')
                                      : "";
  const std::string unit = key.unit.empty() ? "" : " " + key.unit;
  switch (key.type) {
    case KeyType::text: return "a string in quotes";
    case KeyType::choice: return fmt::format("one of \"{}\"", fmt::join(key.choices, "\", \""));
    case KeyType::number: return "a number" + range + unit;
    case KeyType::integer: return key.choices.empty() ? "an integer" + range : fmt::format("one of {}", fmt::join(key.choices, ", "));
    case KeyType::boolean: return "true or false";
    case KeyType::vector: return "three numbers [x, y, z], each" + range + unit;
    case KeyType::matrix: return "three rows of three numbers, each" + range + unit;
    case KeyType::axes: return fmt::format("a list of distinct axes out of \"{}\"", fmt::join(key.choices, "\", \""));
  }
  return {};
}

std::string trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\r\n\f\v";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(blank) - first + 1));
}

/// One to three bare keys with dots between them, each with an index of at most six digits or without: body[0].min_m
bool is_override_path(std::string_view path) {
  constexpr std::size_t most_parts = 3, most_digits = 6;
  constexpr std::string_view digits = "0123456789", bare = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  for (std::size_t part = 0; part < most_parts; ++part) {
    const std::size_t dot = path.find('.');
    std::string_view name = path.substr(0, dot);
    if (const std::size_t bracket = name.find('['); bracket != std::string_view::npos) {
      const std::string_view index = name.substr(bracket + 1);
      if (index.size() < 2 || index.size() > most_digits + 1 || index.find_first_not_of(digits) != index.size() - 1 || index.back() != ']')
        return false;
      name = name.substr(0, bracket);
    }
    if (name.empty() || name.find_first_not_of(bare) != std::string_view::npos) return false;
    if (dot == std::string_view::npos) return true;
    path.remove_prefix(dot + 1);
  }
  return false;
}

class Reader {
 public:
  Reader(std::string_view file, bool is_path) : file_(file), is_path_(is_path) {}

  Draft read(std::string_view text, const std::vector<std::string>& overrides) {
    check_text(text, file_);
    toml::table root;
    try {
      root = toml::parse(text, file_);
    } catch (const toml::parse_error& error) {
      const auto& at = error.source().begin;
      throw ConfigError(fmt::format("{}:{}:{}: not valid TOML: {}", file_, at.line, at.column, printable(error.description())));
    }
    for (std::size_t i = 0; i < overrides.size(); ++i) apply_override(root, overrides[i], i + 1);
    places_[""] = file_place(1, 1);
    read_table(table_named(""), "", root, 0);
    check_conditions();
    check_material();
    is_path_ ? check_path() : check_case();
    throw_faults();
    return std::move(draft_);
  }

 private:
  // ---- faults and places -----------------------------------------------------------------------------------------------------------
  [[nodiscard]] Place file_place(std::uint32_t line, std::uint32_t column) const {
    return {0, line, column, fmt::format("{}:{}:{}", file_, line, column)};
  }

  /// Of a key or table that stands at `source` in the file, or that an override made.
  [[nodiscard]] Place place_of(const std::string& path, const toml::source_region& source) const {
    for (std::size_t i = overrides_.size(); i-- > 0;) {
      const Override& o = overrides_[i];
      const bool inside = path == o.path || path.starts_with(o.path + ".") || path.starts_with(o.path + "[");
      if (inside || (source.begin.line == 0 && o.path.starts_with(path + "."))) return {i + 1, 1, 1, "--set " + one_line(o.text)};
    }
    return file_place(std::max<std::uint32_t>(1, source.begin.line), std::max<std::uint32_t>(1, source.begin.column));
  }

  /// Of a key; of its table where the key is left out; the top of the file where the table is missing, too.
  [[nodiscard]] Place place(const std::string& table_path, const std::string& name) const {
    for (const std::string& path : {key_path(table_path, name), table_path}) {
      if (const auto at = places_.find(path); at != places_.end()) return at->second;
    }
    return places_.at("");
  }

  void fault(const Place& at, const std::string& text) {
    if (!given_up()) faults_.push_back({at, text});
  }

  void fault_key(const std::string& table_path, const std::string& name, const std::string& text) {
    fault(place(table_path, name), label(table_path) + name + " " + text);
    faulty_.insert(key_path(table_path, name));
  }

  void throw_faults() {
    if (faults_.empty()) return;
    std::stable_sort(faults_.begin(), faults_.end(), [](const Fault& a, const Fault& b) { return a.place.before(b.place); });
    std::string message;
    for (const Fault& f : std::span(faults_).first(std::min(faults_.size(), faults_told)))
      message += (message.empty() ? "" : "\n") + f.place.text + ": " + f.text;
    if (faults_.size() > faults_told) {
      message += fmt::format("\n{}: {}{} more faults; mend these first, or see whether this is the right file", file_,
                             given_up() ? "at least " : "", faults_.size() - faults_told);
    }
    throw ConfigError(message);
  }

  /// So many faults that reading on would tell nobody anything.
  [[nodiscard]] bool given_up() const { return faults_.size() >= most_faults; }

  [[nodiscard]] bool given(const std::string& path) const { return places_.contains(path); }
  /// None of these keys is at fault: a check that combines them makes sense.
  [[nodiscard]] bool sound(const std::vector<std::string>& paths) const {
    return std::none_of(paths.begin(), paths.end(), [&](const std::string& path) { return faulty_.contains(path); });
  }

  // ---- overrides -------------------------------------------------------------------------------------------------------------------
  void apply_override(toml::table& root, const std::string& text, std::size_t number) {
    const Place here{number, 1, 1, "--set " + one_line(text)};
    overrides_.push_back({"", text});
    const auto refuse = [&](const std::string& why) { fault(here, why); };

    const std::size_t equals = text.find('=');
    const std::string path = equals == std::string::npos ? "" : trimmed(text.substr(0, equals));
    if (!is_override_path(path)) return refuse("not understood; write table.key=value, or body[0].key=value");
    overrides_.back().path = path;

    // down to the table that holds the key
    toml::table* table = &root;
    std::size_t start = 0;
    for (std::size_t dot = path.find('.'); dot != std::string::npos; start = dot + 1, dot = path.find('.', start)) {
      std::string part = path.substr(start, dot - start);
      std::optional<std::size_t> index;
      if (const std::size_t bracket = part.find('['); bracket != std::string::npos) {
        index = std::stoul(part.substr(bracket + 1));
        part.resize(bracket);
      }
      toml::node* node = table->get(part);
      if (index) {
        toml::array* list = node != nullptr ? node->as_array() : nullptr;
        const std::size_t size = list != nullptr ? list->size() : 0;
        if (*index >= size) return refuse(fmt::format("there is no {}[{}]; the file has {} (counted from 0)", part, *index, size));
        node = list->get(*index);
      } else if (node == nullptr) {
        table->insert(part, toml::table{});
        node = table->get(part);
      }
      if (node->is_array()) return refuse(fmt::format("{} is repeated; say which one, e.g. {}[0]", part, part));
      table = node->as_table();
      if (table == nullptr) return refuse(fmt::format("{} is no table; write table.key=value", part));
    }
    const std::string name = path.substr(start);
    if (name.ends_with(']')) return refuse("only a whole key can be replaced; write table.key=value");

    const std::string value = trimmed(text.substr(equals + 1));
    try {
      const std::string line = "value = " + value;
      check_text(line, here.text);
      const toml::table parsed = toml::parse(line);
      if (parsed.size() != 1) return refuse("one value, please; write table.key=value");
      parsed.get("value")->visit([&](const auto& v) { table->insert_or_assign(name, v); });
    } catch (const toml::parse_error&) {
      table->insert_or_assign(name, value);  // a bare word
    } catch (const ConfigError&) {
      table->insert_or_assign(name, value);
    }
    if (path == "conveyor.velocity_m_s") table->erase("froude_number");
    if (path == "conveyor.froude_number") table->erase("velocity_m_s");
    if (path == "obstacle.friction") table->erase("friction_ratio");
    if (path == "obstacle.friction_ratio") table->erase("friction");
  }

  // ---- tables and keys -------------------------------------------------------------------------------------------------------------
  [[nodiscard]] bool here(const TableInfo& table) const { return is_path_ ? table.in_path : table.in_case; }

  [[nodiscard]] static const TableInfo& table_named(const std::string& name) {
    const auto& tables = schema_tables();
    return *std::find_if(tables.begin(), tables.end(), [&](const TableInfo& t) { return t.name == name; });
  }

  /// The table `name` inside `parent`, if there is one.
  [[nodiscard]] const TableInfo* child(const TableInfo& parent, const std::string& name) const {
    if (name.empty() || name.find('.') != std::string::npos) return nullptr;
    for (const TableInfo& table : schema_tables()) {
      if (here(table) && table.name == key_path(parent.name, name)) return &table;
    }
    return nullptr;
  }

  [[nodiscard]] static const Key* key_named(const std::string& table, const std::string& name) {
    for (const Key& key : keys()) {
      if (key.table == table && key.name == name) return &key;
    }
    return nullptr;
  }

  void read_table(const TableInfo& info, const std::string& path, const toml::table& table, std::size_t index) {
    for (const auto& [toml_key, node] : table) {
      if (given_up()) return;
      std::string name(toml_key.str());
      const Place at = place_of(key_path(path, name), toml_key.source());
      if (child(info, name) == nullptr && key_named(info.name, name) == nullptr) {
        const std::string meant = report_unknown(info, path, name, node, at);
        if (meant.empty() || table.contains(meant)) continue;
        name = meant;  // go on as if it had been written right: its value may be at fault, too
      }
      if (const TableInfo* inner = child(info, name)) {
        read_child(*inner, key_path(path, name), node, at);
        continue;
      }
      const Key& key = *key_named(info.name, name);
      places_[key_path(path, name)] = place_of(key_path(path, name), node.source());
      if (const auto value = convert(key, path, node)) key.set(draft_, index, *value);
    }
  }

  void read_child(const TableInfo& info, const std::string& path, const toml::node& node, const Place& at) {
    const auto enter = [&](const std::string& entry, const toml::table& table, std::size_t index) {
      const auto& source = table.source();
      places_[entry] = source.begin.line == 0 ? at : place_of(entry, source);
      add_entry(draft_, info.name);
      read_table(info, entry, table, index);
    };
    if (!info.repeated) {
      if (const toml::table* table = node.as_table()) return enter(path, *table, 0);
      faulty_.insert(path);
      return fault(at, fmt::format("{} is {}; write [{}] once, its keys below it", path, kind_of(node), path));
    }
    if (const toml::table* table = node.as_table()) {
      fault(at, fmt::format("{} is a single table; write [[{}]] with two brackets, once for each", path, path));
      return enter(path + "[0]", *table, 0);
    }
    const toml::array* list = node.as_array();
    faulty_.insert(path);
    if (list == nullptr) return fault(at, fmt::format("{} is {}; write [[{}]] and its keys below it", path, kind_of(node), path));
    faulty_.erase(path);
    for (std::size_t i = 0; i < list->size() && !given_up(); ++i) {
      const std::string entry = fmt::format("{}[{}]", path, i);
      const toml::node& element = *list->get(i);
      static const toml::table nothing;
      const toml::table* table = element.as_table();
      if (table == nullptr) {
        faulty_.insert(entry);
        fault(place_of(entry, element.source()), fmt::format("{} is {}; give a table", entry, kind_of(element)));
      }
      enter(entry, table != nullptr ? *table : nothing, i);
    }
  }

  /// @return the name that was probably meant, empty if none is near
  std::string report_unknown(const TableInfo& info, const std::string& path, const std::string& name, const toml::node& node,
                             const Place& at) {
    const bool is_table = node.is_table() || node.is_array_of_tables();
    std::vector<std::string> candidates;
    std::string elsewhere;
    for (const TableInfo& table : schema_tables()) {
      if (!here(table)) continue;
      if (table.name.size() > info.name.size() && child(info, table.name.substr(info.name.empty() ? 0 : info.name.size() + 1)) == &table) {
        candidates.push_back(table.name.substr(info.name.empty() ? 0 : info.name.size() + 1));
      }
      for (const Key& key : keys()) {
        if (key.table != table.name) continue;
        if (table.name == info.name) {
          candidates.push_back(key.name);
        } else if (!is_table && key.name == name) {
          elsewhere += (elsewhere.empty() ? "" : " or ") + (table.name.empty() ? "the top of the file" : bracketed(table));
        }
      }
    }
    std::string meant = elsewhere.empty() ? nearest_word(name, candidates) : "";
    std::string remedy = "see `mpm schema` for what there is";
    if (!elsewhere.empty()) remedy = "it belongs in " + elsewhere;
    if (!meant.empty()) {
      const TableInfo* inner = child(info, meant);
      remedy = "did you mean " + (inner != nullptr ? bracketed(*inner) : meant) + "?";
    }
    fault(at, fmt::format("{}unknown {} {}; {}", label(path), is_table ? "table" : "key",
                          is_table ? "[" + one_line(name) + "]" : one_line(name), remedy));
    return meant;
  }

  // ---- values ----------------------------------------------------------------------------------------------------------------------
  /// The value if it has the type and lies in the range of the key; otherwise reports why not.
  std::optional<Value> convert(const Key& key, const std::string& table_path, const toml::node& node) {
    std::string problem;
    std::optional<Value> value;
    switch (key.type) {
      case KeyType::text:
        if (const auto text = node.value_exact<std::string>()) value = *text;
        break;
      case KeyType::choice:
        if (const auto word = node.value_exact<std::string>()) {
          const bool known = std::find(key.choices.begin(), key.choices.end(), *word) != key.choices.end();
          if (known) value = *word;
          const std::string meant = known ? "" : nearest_word(*word, key.choices);
          problem = known ? "" : meant.empty() ? "is not known" : "is not known (did you mean \"" + meant + "\"?)";
        }
        break;
      case KeyType::number:
        if (const auto x = number(key, node, problem)) value = *x;
        break;
      case KeyType::integer:
        if (const auto x = node.value_exact<std::int64_t>()) {
          const bool permitted =
              key.choices.empty() || std::find(key.choices.begin(), key.choices.end(), std::to_string(*x)) != key.choices.end();
          if (permitted && (!key.range || key.range->contains(static_cast<double>(*x)))) {
            value = *x;
          } else {
            problem = "is out of range";
          }
        }
        break;
      case KeyType::boolean:
        if (const auto x = node.value_exact<bool>()) value = *x;
        break;
      case KeyType::vector:
        if (const auto x = vector(key, node, problem)) value = *x;
        break;
      case KeyType::matrix:
        if (const toml::array* rows = node.as_array(); rows != nullptr && rows->size() == 3) {
          Mat3 matrix;
          int good = 0;
          for (const toml::node& row : *rows) {
            if (const auto x = vector(key, row, problem)) matrix.row(good++) = x->transpose();
          }
          if (good == 3) value = matrix;
        }
        break;
      case KeyType::axes:
        if (const toml::array* list = node.as_array()) value = axes(key, *list, problem);
        break;
    }
    if (value) return value;
    if (problem.empty()) problem = "is " + kind_of(node);
    fault_key(table_path, key.name, fmt::format("= {} {}; give {}", shown(node), problem, expected(key)));
    return std::nullopt;
  }

  static std::optional<double> number(const Key& key, const toml::node& node, std::string& problem) {
    std::optional<double> x = node.value_exact<double>();
    if (const auto whole = node.value_exact<std::int64_t>()) x = static_cast<double>(*whole);
    if (!x) return std::nullopt;
    if (!std::isfinite(*x)) {
      problem = "is not a finite number";
    } else if (key.range && !key.range->contains(*x)) {
      problem = "is out of range";
    } else {
      return x;
    }
    return std::nullopt;
  }

  static std::optional<Vec3> vector(const Key& key, const toml::node& node, std::string& problem) {
    const toml::array* list = node.as_array();
    if (list == nullptr) return std::nullopt;
    if (list->size() != 3) {
      problem = fmt::format("has {} entries", list->size());
      return std::nullopt;
    }
    Vec3 v;
    for (int i = 0; i < 3; ++i) {
      const auto x = number(key, *list->get(static_cast<std::size_t>(i)), problem);
      if (!x && problem.empty()) problem = "holds " + kind_of(*list->get(static_cast<std::size_t>(i)));
      if (!x) return std::nullopt;
      v[i] = *x;
    }
    return v;
  }

  static std::optional<Value> axes(const Key& key, const toml::array& list, std::string& problem) {
    std::vector<std::string> words;
    for (const toml::node& element : list) {
      const std::string word = element.value_exact<std::string>().value_or("");
      const bool known = std::find(key.choices.begin(), key.choices.end(), word) != key.choices.end();
      if (!known || std::find(words.begin(), words.end(), word) != words.end()) {
        problem = known ? "names an axis twice" : "holds " + shown(element);
        return std::nullopt;
      }
      words.push_back(word);
    }
    return words;
  }

  // ---- required keys, keys that do not apply ---------------------------------------------------------------------------------------
  /// Path of one entry of a table, as used in places_.
  static std::string entry_path(const TableInfo& table, std::size_t i) {
    return table.repeated ? fmt::format("{}[{}]", table.name, i) : table.name;
  }

  void check_conditions() {
    for (const TableInfo& table : schema_tables()) {
      if (!here(table) || faulty_.contains(table.name)) continue;
      for (std::size_t i = 0; i < entries(draft_, table.name) && !given_up(); ++i) {
        const std::string path = entry_path(table, i);
        if (faulty_.contains(path)) continue;
        for (const Key& key : keys()) {
          if (key.table == table.name) check_key_conditions(key, path, i);
        }
      }
    }
  }

  void check_key_conditions(const Key& key, const std::string& path, std::size_t i) {
    const auto known = [&](const Condition& c) {  // what the condition looks at was read without fault
      return !faulty_.contains(c.key.starts_with(key.table + ".") ? path + c.key.substr(key.table.size()) : c.key);
    };
    const bool is_given = given(key_path(path, key.name));
    if (key.used && is_given && known(*key.used) && !key.used->holds(draft_, i)) {
      fault_key(path, key.name, fmt::format("is used with {} only; leave it out", key.used->text));
    }
    const bool used = !key.used || key.used->holds(draft_, i);
    if (key.required && used && !is_given && known(*key.required) && key.required->holds(draft_, i)) {
      const std::string why = key.required->text == "always" ? "" : " (required with " + key.required->text + ")";
      fault_key(path, key.name, fmt::format("is missing{}; give {}: {}", why, expected(key), key.description));
    }
  }

  // ---- checks across keys of [material] --------------------------------------------------------------------------------------------
  void check_material() {
    const MaterialSpec& m = draft_.spec.material;
    const auto relation = [&](const char* name, const char* other, bool holds, std::string_view remedy) {
      const std::string path = std::string("material.") + name;
      if (given(path) && sound({path, std::string("material.") + other}) && !holds) fault_key("material", name, std::string(remedy));
    };
    relation("dilatancy_angle_deg", "friction_angle_deg", m.dilatancy_angle <= m.friction_angle,
             "is above friction_angle_deg, which would create energy; give at most that");
    relation("limit_friction_angle_deg", "friction_angle_deg", !m.limit_friction_angle || *m.limit_friction_angle >= m.friction_angle,
             "is below friction_angle_deg; friction grows with the rate, give at least that");
    const std::vector<std::string> rate_keys{"limit_friction_angle_deg", "reference_inertial_number", "grain_diameter_m",
                                             "grain_density_kg_m3"};
    const auto is_given = [&](const std::string& name) { return given("material." + name); };
    const auto there = std::find_if(rate_keys.begin(), rate_keys.end(), is_given);
    if (there == rate_keys.end()) return;
    for (const std::string& name : rate_keys) {
      if (!is_given(name))
        fault_key("material", name, fmt::format("is missing beside {}; rate dependence needs all four of its keys", *there));
    }
    if (m.dilatancy_angle > 0.0 && is_given("dilatancy_angle_deg"))
      fault_key("material", "dilatancy_angle_deg",
                fmt::format("stands beside {}; rate-dependent flow keeps the volume, leave it out", *there));
  }

  // ---- checks across keys of a case ------------------------------------------------------------------------------------------------
  void check_case() {
    check_domain();
    check_grid_offset();
    check_filter();
    resolve_obstacle_friction();
    if (faulty_.contains("conveyor")) return;
    if (draft_.spec.conveyor) {
      resolve_conveyor();
      for (const std::string table : {"body", "wall"}) {
        for (std::size_t i = 0; i < entries(draft_, table); ++i) {
          const std::string path = fmt::format("{}[{}]", table, i);
          fault(place(path, ""), label(path) + "stands beside [conveyor], which brings its own; leave out one of the two");
        }
      }
    } else if (draft_.spec.bodies.empty() && !faulty_.contains("body")) {
      fault(places_.at(""), "the scene is empty; give [conveyor], or at least one [[body]]");
    }
    check_bodies_and_walls();
  }

  void check_domain() {
    const DomainSpec& d = draft_.spec.domain;
    for (int axis = 0; axis < 3 && sound({"domain.min_m", "domain.max_m"}); ++axis) {
      if (d.min[axis] < d.max[axis]) continue;
      fault_key("domain", "max_m", fmt::format("is not above min_m in {}: {} <= {}; exchange them", "xyz"[axis], d.max[axis], d.min[axis]));
    }
  }

  void check_grid_offset() {
    const Case& c = draft_.spec;
    if (!sound({"numerics.grid_offset_cells", "conveyor", "conveyor.mirror_y", "domain.mirror"})) return;
    const bool mirrored[] = {c.domain.mirror_x, c.domain.mirror_y || (c.conveyor && c.conveyor->mirror_y)};
    for (int axis = 0; axis < 2; ++axis) {
      if (!mirrored[axis] || c.numerics.grid_offset[axis] == 0.0) continue;
      fault_key(
          "numerics", "grid_offset_cells",
          fmt::format("shifts the mirror plane {0} = 0 off the grid by {1} cells in {0}; give 0 there, or compute the whole without the "
                      "mirror",
                      "xy"[axis], c.numerics.grid_offset[axis]));
    }
  }

  /// The filter's window is an odd number of bins, as many as its parabola needs.
  void check_filter() {
    const MeasurementSpec& m = draft_.spec.measurement;
    if (!m.filter_length || !sound({"measurement.filter_length_m", "measurement.bin_height_m", "numerics.cell_size_m"})) return;
    const double bin = m.bin_height.value_or(0.5 * draft_.spec.numerics.cell_size), bins = *m.filter_length / bin;
    constexpr double most_bins = 9999.0;
    if (bins > most_bins) {
      fault_key("measurement", "filter_length_m",
                fmt::format("= {} is {:.6g} bins of {} m, more than {}; give a shorter filter or higher bins", *m.filter_length, bins, bin,
                            most_bins));
      return;
    }
    const double odd = std::max(3.0, 2.0 * std::round(0.5 * (bins - 1.0)) + 1.0);
    constexpr double rounding = 1e-6;  // of lengths given to six digits
    if (std::abs(bins - odd) > rounding * odd) {
      fault_key("measurement", "filter_length_m",
                fmt::format("= {} is {:.6g} bins of {} m; give an odd number of bins, at least 3, such as {:.6g} m", *m.filter_length, bins,
                            bin, odd * bin));
    }
  }

  void resolve_obstacle_friction() {
    if (!draft_.friction_ratio) return;
    if (given("obstacle.friction")) {
      fault_key("obstacle", "friction_ratio", "stands beside friction; both give the friction of the obstacle, leave one out");
      return;
    }
    if (!sound({"material.model", "material.critical_state_slope", "material.cohesion_beta", "material.friction_angle_deg"})) return;
    const std::optional<double> own = internal_friction(draft_.spec.material);
    if (!own) {
      fault_key("obstacle", "friction_ratio",
                fmt::format("is a share of the material's own friction, and \"{}\" has none; give friction", draft_.spec.material.model));
      return;
    }
    const Range permitted = *key_named("obstacle", "friction")->range;
    const double mu = *draft_.friction_ratio == 0.0 ? 0.0 : *draft_.friction_ratio * *own;
    if (permitted.contains(mu)) {
      draft_.spec.obstacle->friction = mu;
    } else {
      fault_key("obstacle", "friction_ratio",
                fmt::format("= {} makes a friction of {:.6g}; it has to be at most {}: give a smaller share, or friction itself",
                            *draft_.friction_ratio, mu, permitted.high));
    }
  }

  void resolve_conveyor() {
    Case& c = draft_.spec;
    ConveyorSpec& belt = *c.conveyor;
    const bool froude = given("conveyor.froude_number");
    const bool velocity = given("conveyor.velocity_m_s");
    if (froude && velocity) {
      fault_key("conveyor", "velocity_m_s", "stands beside froude_number; both give the speed, leave one out");
    } else if (!froude && !velocity) {
      fault(place("conveyor", ""), "[conveyor] has no speed; give froude_number or velocity_m_s");
      faulty_.insert("conveyor.velocity_m_s");
    } else if (froude && sound({"conveyor.froude_number", "conveyor.flow_height_m", "numerics.gravity_m_s2"})) {
      const double gravity = c.numerics.gravity;
      if (gravity > 0.0) belt.velocity = flow_velocity(*draft_.froude_number, belt.flow_height, gravity);
      const Range permitted = *key_named("conveyor", "velocity_m_s")->range;
      if (!permitted.contains(belt.velocity)) {
        fault_key("conveyor", "froude_number",
                  fmt::format("= {} makes a speed v = Fr sqrt(g H) of {} m/s; it has to be above 0 and at most {} m/s",
                              *draft_.froude_number, belt.velocity, permitted.high));
      }
    }

    if (!given("conveyor.width_m")) {
      if (!c.obstacle && sound({"obstacle"})) {
        fault_key("conveyor", "width_m", "is missing; without [obstacle] it does not follow from the obstacle's width, give it");
      } else if (c.obstacle && sound({"material.model", "material.hardening_xi", "obstacle.width_m"})) {
        belt.width = default_conveyor_width(c.material, c.obstacle->width);
      }
    }
    const bool plan_known = c.obstacle && sound(obstacle_plan_keys);
    const ObstaclePlan plan = plan_known ? obstacle_plan(*c.obstacle) : ObstaclePlan{};
    if (plan_known && sound({"conveyor.width_m", "material.hardening_xi"}) && belt.width < plan.width) {
      fault_key("obstacle", "width_m",
                fmt::format("= {}{} is wider than the belt, {} m; make it narrower, or give a larger conveyor.width_m", c.obstacle->width,
                            c.obstacle->rotation != 0.0 ? fmt::format(", turned {:.6g},", plan.width) : "", belt.width));
    }
    const bool window = belt.feed == ConveyorSpec::Feed::window;
    if (plan_known && window && sound({"conveyor.feed", "conveyor.downstream_length_m"}) && belt.downstream_length < plan.depth) {
      fault_key("conveyor", "downstream_length_m",
                fmt::format("= {} ends inside the obstacle; give at least its depth, {:.6g} m", belt.downstream_length, plan.depth));
    }
    if (plan_known && sound({"conveyor.mirror_y"}) && belt.mirror_y && !plan.symmetric) {
      fault_key("obstacle", "rotation_deg",
                "makes a box that is not symmetric about y = 0, of which half cannot stand for the whole; give conveyor.mirror_y = false");
    }
    check_inflow();
    if (sound({"conveyor.flow_height_m", "numerics.cell_size_m"}) && belt.flow_height < c.numerics.cell_size) {
      fault_key("conveyor", "flow_height_m",
                fmt::format("= {} is less than one cell; give at least cell_size_m = {} m, or finer cells", belt.flow_height,
                            c.numerics.cell_size));
    }
    if (window && sound({"conveyor.upstream_length_m", "numerics.cell_size_m"}) &&
        belt.upstream_length < least_upstream_cells * c.numerics.cell_size) {
      fault_key("conveyor", "upstream_length_m",
                fmt::format("= {} leaves no room between inlet and obstacle; give at least {} cells, {} m", belt.upstream_length,
                            least_upstream_cells, least_upstream_cells * c.numerics.cell_size));
    }
  }

  /// Inflow that varies over height or in time.
  void check_inflow() {
    const Case& c = draft_.spec;
    const ConveyorSpec& belt = *c.conveyor;
    const bool sheared = belt.slip_ratio < 1.0 && sound({"conveyor.inflow_slip_ratio"});
    if (sheared && belt.sidewall_contact != Contact::slip && sound({"conveyor.sidewall_contact"})) {
      fault_key("conveyor", "inflow_slip_ratio",
                "is below 1, and side walls that move at one speed would even the flow out; give sidewall_contact = \"slip\"");
    }
    if (belt.inflow.empty() || faulty_.contains("conveyor.inflow")) return;
    const Place first = place("conveyor.inflow[0]", "");
    if (belt.feed != ConveyorSpec::Feed::window && sound({"conveyor.feed"}))
      fault(first, "[[conveyor.inflow]] stands beside feed = \"strip\", all of whose snow is there from the start; give feed = \"window\"");
    if (sheared) fault(first, "[[conveyor.inflow]] stands beside inflow_slip_ratio; what varies in time enters as a plug, leave one out");
    for (std::size_t i = 0; i < belt.inflow.size(); ++i) {
      const std::string path = fmt::format("conveyor.inflow[{}]", i);
      const InflowPoint& p = belt.inflow[i];
      if (i > 0 && !(p.time > belt.inflow[i - 1].time) && sound({path + ".time_s", fmt::format("conveyor.inflow[{}].time_s", i - 1)}))
        fault_key(path, "time_s",
                  fmt::format("= {} is not above that of the row before, {}; sort the rows", p.time, belt.inflow[i - 1].time));
      if (p.flow_height && *p.flow_height < c.numerics.cell_size && sound({path + ".flow_height_m", "numerics.cell_size_m"}))
        fault_key(path, "flow_height_m",
                  fmt::format("= {} is less than one cell; give at least cell_size_m = {} m", *p.flow_height, c.numerics.cell_size));
      if (p.density_ratio > 1.0 && c.material.model != "cohesive_cam_clay" && sound({path + ".density_ratio", "material.model"}))
        fault_key(path, "density_ratio",
                  fmt::format("= {} asks for snow that was compacted before; {} does not keep compaction, leave it out", p.density_ratio,
                              c.material.model));
    }
  }

  void check_bodies_and_walls() {
    const Case& c = draft_.spec;
    for (std::size_t i = 0; i < c.bodies.size(); ++i) check_body(fmt::format("body[{}]", i), c.bodies[i]);
    for (std::size_t i = 0; i < c.walls.size(); ++i) {
      const std::string path = fmt::format("wall[{}]", i);
      if (given(path + ".normal") && sound({path + ".normal"}) && c.walls[i].normal.isZero(0.0)) {
        fault_key(path, "normal", "= [0, 0, 0] has no direction; give a vector that points into the material");
      }
    }
  }

  void check_body(const std::string& path, const BodySpec& body) {
    const Case& c = draft_.spec;
    if (faulty_.contains(path) || !sound({path + ".min_m", path + ".max_m"})) return;
    for (int axis = 0; axis < 3; ++axis) {
      if (body.min[axis] < body.max[axis]) continue;
      return fault_key(path, "max_m",
                       fmt::format("is not above min_m in {}: {} <= {}; exchange them", "xyz"[axis], body.max[axis], body.min[axis]));
    }
    if (sound({"numerics.cell_size_m", "numerics.particles_per_cell"})) {
      const double spacing = c.numerics.cell_size / std::cbrt(c.numerics.particles_per_cell);
      const double thinnest = (body.max - body.min).minCoeff();
      constexpr double slack = 1.0 - 1e-9;  // rounding of the corners
      if (thinnest < spacing * slack) {
        fault_key(
            path, "max_m",
            fmt::format("- min_m is {} m at the thinnest, less than the distance of particles, {} m; give a larger body or finer cells",
                        thinnest, spacing));
      }
    }
    if (sound({"numerics.cell_size_m"})) {
      constexpr double reach = 4.0e6;  // cells from the origin: 2^20 blocks of four, with some room
      const double farthest = std::max(body.max.cwiseAbs().maxCoeff(), body.min.cwiseAbs().maxCoeff());
      if (farthest > reach * c.numerics.cell_size) {
        fault_key(
            path, "max_m",
            fmt::format("or min_m is {} m from the origin, beyond the {:g} cells of {} m that the grid reaches; move the scene to the "
                        "origin, or take larger cells",
                        farthest, reach, c.numerics.cell_size));
      }
    }
    const bool domain_known = given("domain.min_m") && given("domain.max_m") && sound({"domain.min_m", "domain.max_m"});
    if (domain_known && ((body.min.array() < c.domain.min.array()).any() || (body.max.array() > c.domain.max.array()).any())) {
      fault_key(path, "max_m", "or min_m lies outside [domain]; enlarge the domain or move the body");
    }
    if (c.obstacle && sound(obstacle_plan_keys) && sound({"obstacle.height_m", path + ".shape"}) && meets_obstacle(body, *c.obstacle)) {
      fault_key(path, "max_m", "and min_m reach into the obstacle; move the body, it may touch the obstacle");
    }
  }

  // ---- checks across keys of a path ------------------------------------------------------------------------------------------------
  void check_path() {
    if (faulty_.contains("path") || faulty_.contains("path.segments")) return;
    if (draft_.segments.empty()) fault(place("path", "segments"), "[path] segments is missing or empty; give at least one segment");
    for (std::size_t i = 0; i < draft_.segments.size(); ++i) {
      const std::string path = fmt::format("path.segments[{}]", i);
      if (faulty_.contains(path)) continue;
      const auto has = [&](const char* name) { return given(key_path(path, name)); };
      const bool strain = has("d_eps_v") || has("d_eps_q");
      const bool gradient = has("velocity_gradient") || has("time_s");
      const bool triaxial = has("radial_stress_pa") || has("d_eps_axial");
      const bool whole = strain || (has("velocity_gradient") && has("time_s")) || (has("radial_stress_pa") && has("d_eps_axial"));
      if (int{strain} + int{gradient} + int{triaxial} == 1 && whole) continue;
      fault(place(path, ""), label(path) +
                                 "is not one of {d_eps_v, d_eps_q}, {velocity_gradient, time_s}, {radial_stress_pa, d_eps_axial}; " +
                                 "give exactly one of these groups");
    }
  }

  inline static const std::vector<std::string> obstacle_plan_keys{"obstacle", "obstacle.shape", "obstacle.width_m", "obstacle.depth_m",
                                                                  "obstacle.rotation_deg"};
  static constexpr double least_upstream_cells = 4;  // inlet layer, the kernel's width and one free cell

  std::string file_;
  bool is_path_;
  Draft draft_;
  std::vector<Override> overrides_;
  std::vector<Fault> faults_;
  std::map<std::string, Place> places_;  ///< of every table entry and key given
  std::set<std::string> faulty_;         ///< paths of keys and tables with a fault
};

}  // namespace

}  // namespace mpm::config

namespace mpm {

Case parse_case(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides) {
  return config::Reader(file_name, false).read(text, overrides).spec;
}

PathSpec parse_path(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides) {
  const config::Draft draft = config::Reader(file_name, true).read(text, overrides);
  PathSpec path;
  path.material = draft.spec.material;
  path.steps_per_segment = draft.steps_per_segment;
  for (const config::SegmentDraft& s : draft.segments) {
    if (s.velocity_gradient) {
      path.segments.emplace_back(VelocityGradientSegment{*s.velocity_gradient, *s.time});
    } else if (s.radial_stress) {
      path.segments.emplace_back(TriaxialSegment{*s.radial_stress, *s.d_eps_axial});
    } else {
      path.segments.emplace_back(StrainSegment{s.d_eps_v.value_or(0.0), s.d_eps_q.value_or(0.0)});
    }
  }
  return path;
}

PathSpec read_path(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return parse_path(config::bounded_file_text(file), file.string(), overrides);
}

Case read_case(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return parse_case(config::bounded_file_text(file), file.string(), overrides);
}

}  // namespace mpm
