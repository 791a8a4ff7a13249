#include "libmpm/config/reader.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/config/file_problems.hpp"
#include "libmpm/config/guard.hpp"
#include "libmpm/config/toml_text.hpp"

namespace mpm::config {

namespace {

// ---- The text, with overrides ----------------------------------------------------------------------------------------------------------

constexpr std::string_view blanks = " \t\r\n\f\v";

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

/// The TOML text of a file after the overrides of --set, with the origin of each entry.
class TomlInput {
 public:
  /// @param overrides  "table.key=value"; invalid ones are reported to the problems
  /// @param prefix     of an override in messages
  /// @throws ConfigError if the text is not TOML
  TomlInput(const Schema& schema, std::string_view text, std::string_view file, const std::vector<std::string>& overrides,
            std::string_view prefix, FileProblems& problems)
      : schema_(schema), problems_(problems), prefix_(prefix), root_(parsed(text, file)) {
    for (const std::string& override_text : overrides) {
      Override change{"", override_text};
      const std::string problem = apply(change);
      overrides_.push_back(change);
      if (!problem.empty()) problems.add(position_of(change, overrides_.size()), problem);
    }
  }

  [[nodiscard]] const toml::table& root() const { return root_; }  ///< with the overrides
  /// Position of a key or table: at `source` in the file, or in an override.
  [[nodiscard]] FilePosition position_of(const std::string& path, const toml::source_region& source) const {
    for (std::size_t i = overrides_.size(); i-- > 0;) {
      const Override& o = overrides_[i];
      const bool inside = path == o.path || path.starts_with(o.path + ".") || path.starts_with(o.path + "[");
      if (inside || (source.begin.line == 0 && o.path.starts_with(path + "."))) return position_of(o, i + 1);
    }
    return problems_.in_file(source.begin.line, source.begin.column);
  }

 private:
  struct Override {
    std::string path;  ///< "body[0].velocity_m_s"; empty if invalid
    std::string text;  ///< as given
  };
  /// @param number  from 1
  [[nodiscard]] FilePosition position_of(const Override& change, std::size_t number) const {
    return {number, 1, 1, prefix_ + one_line(change.text)};
  }

  /// @returns the error; empty if there is none
  std::string apply(Override& change) {
    const std::size_t equals = change.text.find('=');
    const std::string path(equals == std::string::npos ? "" : trimmed(std::string_view(change.text).substr(0, equals), blanks));
    if (!is_override_path(path)) return "not understood; write table.key=value, or body[0].key=value";
    change.path = path;
    std::string problem;
    toml::table* table = table_for(path, problem);
    if (table == nullptr) return problem;
    const std::string name = path.substr(path.rfind('.') == std::string::npos ? 0 : path.rfind('.') + 1);
    if (name.ends_with(']')) return "only a whole key can be replaced; write table.key=value";

    const std::string value(trimmed(std::string_view(change.text).substr(equals + 1), blanks));
    try {
      const std::string line = "value = " + value;
      check_text(line, change.text);
      const toml::table parsed = toml::parse(line);
      if (parsed.size() != 1) return "more than one value; write table.key=value";
      parsed.get("value")->visit([&](const auto& v) { table->insert_or_assign(name, v); });
    } catch (const toml::parse_error&) {
      table->insert_or_assign(name, value);  // a bare word
    } catch (const ConfigError&) {
      table->insert_or_assign(name, value);
    }
    remove_rivals(path, *table);
    return {};
  }

  /// The table that holds the key of a path; created if missing. @param problem  the reason if that fails
  toml::table* table_for(const std::string& path, std::string& problem) {
    const auto refuse = [&](std::string why) -> toml::table* {
      problem = std::move(why);
      return nullptr;
    };
    toml::table* table = &root_;
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
      if (node->is_array()) return refuse(fmt::format("{} is repeated; give its number, e.g. {}[0]", part, part));
      table = node->as_table();
      if (table == nullptr) return refuse(fmt::format("{} is no table; write table.key=value", part));
    }
    return table;
  }

  /// Removes the file's value of the same quantity. A value from another override stays, so that the conflict of the two is reported.
  void remove_rivals(const std::string& path, toml::table& table) {
    for (const std::string& rival : schema_.rivals(path)) {
      const bool overridden = std::ranges::any_of(overrides_, [&](const Override& o) { return o.path == rival; });
      if (!overridden) table.erase(rival.substr(rival.rfind('.') + 1));
    }
  }

  const Schema& schema_;
  const FileProblems& problems_;
  std::string prefix_;
  toml::table root_;
  std::vector<Override> overrides_;
};

// ---- Values ----------------------------------------------------------------------------------------------------------------------------

/// Whether a word is a number that no key can hold: --set takes text that is not TOML, such as NaN and 1e400, as a word.
std::string number_word_problem(const std::string& word) {
  char* end = nullptr;
  const double x = std::strtod(word.c_str(), &end);
  if (word.empty() || end != word.c_str() + word.size()) return {};
  if (std::isnan(x)) return "is not a finite number";
  if (std::isinf(x)) return word.find_first_of("0123456789") == std::string::npos ? "is not a finite number" : "is too large for a number";
  return {};
}

std::optional<double> number(const toml::node& node, std::string& problem) {
  if (const auto whole = node.value_exact<std::int64_t>()) return static_cast<double>(*whole);
  if (const auto x = node.value_exact<double>()) return x;
  if (const auto word = node.value_exact<std::string>()) problem = number_word_problem(*word);
  return std::nullopt;
}

std::optional<Vec3> vector(const toml::node& node, std::string& problem) {
  const toml::array* list = node.as_array();
  if (list == nullptr) return std::nullopt;
  if (list->size() != 3) {
    problem = fmt::format("has {} entries", list->size());
    return std::nullopt;
  }
  Vec3 v;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto x = number(*list->get(i), problem);
    if (!x && problem.empty()) problem = "holds " + kind_of(*list->get(i));
    if (!x) return std::nullopt;
    v[static_cast<Eigen::Index>(i)] = *x;
  }
  return v;
}

std::optional<Mat3> matrix(const toml::node& node, std::string& problem) {
  const toml::array* rows = node.as_array();
  if (rows == nullptr || rows->size() != 3) return std::nullopt;
  Mat3 result;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = vector(*rows->get(i), problem);
    if (!row) return std::nullopt;
    result.row(static_cast<Eigen::Index>(i)) = row->transpose();
  }
  return result;
}

std::optional<std::vector<std::string>> word_list(const toml::node& node, std::string& problem) {
  const toml::array* list = node.as_array();
  if (list == nullptr) return std::nullopt;
  std::vector<std::string> words;
  for (const toml::node& element : *list) {
    const auto word = element.value_exact<std::string>();
    if (!word) {
      problem = "holds " + shown(element);
      return std::nullopt;
    }
    words.push_back(*word);
  }
  return words;
}

template <class T>
std::optional<Value> as_value(const std::optional<T>& x) {
  return x ? std::optional<Value>(*x) : std::nullopt;
}

/// The value, if it has the type of the key.
std::optional<Value> typed(KeyType type, const toml::node& node, std::string& problem) {
  switch (type) {
    case KeyType::text:
    case KeyType::choice: return as_value(node.value_exact<std::string>());
    case KeyType::number: return as_value(number(node, problem));
    case KeyType::integer: {
      auto whole = as_value(node.value_exact<std::int64_t>());
      if (const auto word = node.value_exact<std::string>()) problem = number_word_problem(*word);
      return whole;
    }
    case KeyType::boolean: return as_value(node.value_exact<bool>());
    case KeyType::vector: return as_value(vector(node, problem));
    case KeyType::matrix: return as_value(matrix(node, problem));
    case KeyType::axes: return as_value(word_list(node, problem));
  }
  return std::nullopt;
}

/// The value, if it has the type of the key and is permitted.
/// @param problem  otherwise the error: "is a string", "is out of range"
std::optional<Value> to_value(const KeyInfo& key, const toml::node& node, std::string& problem) {
  problem.clear();
  std::optional<Value> value = typed(key.type, node, problem);
  if (!value) {
    if (problem.empty()) problem = "is " + kind_of(node);
    return std::nullopt;
  }
  problem = value_problem(key, *value);
  if (problem.empty()) return value;
  if (key.type == KeyType::choice) {
    const std::string meant = nearest_word(std::get<std::string>(*value), key.choices);
    if (!meant.empty()) problem += " (did you mean \"" + meant + "\"?)";
  }
  return std::nullopt;
}

// ---- Tables ----------------------------------------------------------------------------------------------------------------------------

/// Walks the tables of a file.
class Reader {
 public:
  Reader(const Schema& schema, const TomlInput& source, FileProblems& problems, void* root)
      : schema_(schema), source_(source), problems_(problems), root_(root) {}

  void read_all() { read_table(*schema_.find(""), "", source_.root(), 0); }
  void check_all() {
    for (const Table& table : schema_.tables()) {
      if (!problems_.valid(table.name)) continue;
      for (std::size_t i = 0; i < table.entries(root_) && !problems_.given_up(); ++i) check_entry(table, i);
    }
  }

 private:
  /// The table `name` inside `parent`, if there is one.
  [[nodiscard]] const Table* child(const Table& parent, const std::string& name) const {
    return name.empty() || name.find('.') != std::string::npos ? nullptr : schema_.find(key_path(parent.name, name));
  }

  void read_table(const Table& table, const std::string& path, const toml::table& content, std::size_t i) {
    std::vector<std::pair<const Key*, Value>> values;
    for (const auto& [toml_key, node] : content) {
      if (problems_.given_up()) return;
      std::string name(toml_key.str());
      const FilePosition at = source_.position_of(key_path(path, name), toml_key.source());
      if (child(table, name) == nullptr && schema_.find_key(table.name, name) == nullptr) {
        const std::string meant = report_unknown(table, path, name, node, at);
        if (meant.empty() || content.contains(meant)) continue;
        name = meant;  // continue with the correct name: the value may have an error as well
      }
      const std::string key_at = key_path(path, name);
      if (const Table* inner = child(table, name)) {
        read_child(*inner, key_at, node, at);
        continue;
      }
      const Key& key = *schema_.find_key(table.name, name);
      problems_.give_key(key_at, source_.position_of(key_at, node.source()));
      std::string problem;
      if (auto value = to_value(key, node, problem)) {
        values.emplace_back(&key, std::move(*value));
      } else {
        problems_.problem(key_at, fmt::format("= {} {}; give {}", shown(node), problem, expected_value(key)));
      }
    }
    std::ranges::sort(values, {}, [](const auto& v) { return v.first; });  // as declared: the law comes before its parameters
    for (const auto& [key, value] : values) key->set(root_, i, value);
  }

  void read_child(const Table& table, const std::string& path, const toml::node& node, const FilePosition& at) {
    const auto enter = [&](const std::string& entry, const toml::table& content, std::size_t i) {
      const auto& source = content.source();
      problems_.enter_table(entry, source.begin.line == 0 ? at : source_.position_of(entry, source));
      table.add_entry(root_);
      read_table(table, entry, content, i);
    };
    const auto refuse = [&](const FilePosition& place, const std::string& text) {
      problems_.mark_invalid(path);
      problems_.add(place, text);
    };
    if (!table.repeated) {
      if (const toml::table* content = node.as_table()) return enter(path, *content, 0);
      return refuse(at, fmt::format("{} is {}; write [{}] once, its keys below it", path, kind_of(node), path));
    }
    if (const toml::table* content = node.as_table()) {
      problems_.add(at, fmt::format("{} is a single table; write [[{}]] with two brackets, once for each", path, path));
      return enter(path + "[0]", *content, 0);
    }
    const toml::array* list = node.as_array();
    if (list == nullptr) return refuse(at, fmt::format("{} is {}; write [[{}]] and its keys below it", path, kind_of(node), path));
    for (std::size_t i = 0; i < list->size() && !problems_.given_up(); ++i) {
      const std::string entry = fmt::format("{}[{}]", path, i);
      const toml::node& element = *list->get(i);
      static const toml::table nothing;
      const toml::table* content = element.as_table();
      if (content == nullptr) {
        problems_.mark_invalid(entry);
        problems_.add(source_.position_of(entry, element.source()), fmt::format("{} is {}; give a table", entry, kind_of(element)));
      }
      enter(entry, content != nullptr ? *content : nothing, i);
    }
  }

  /// @return the most similar name, empty if none is similar
  std::string report_unknown(const Table& table, const std::string& path, const std::string& name, const toml::node& node,
                             const FilePosition& at) {
    const bool is_table = node.is_table() || node.is_array_of_tables();
    std::vector<std::string> candidates;
    std::string elsewhere;
    for (const Table& other : schema_.tables()) {
      const std::string inside = other.name.substr(std::min(other.name.size(), table.name.empty() ? 0 : table.name.size() + 1));
      if (child(table, inside) == &other) candidates.push_back(inside);
      for (const Key& key : other.keys) {
        if (&other == &table) {
          candidates.push_back(key.name);
        } else if (!is_table && key.name == name) {
          elsewhere += (elsewhere.empty() ? "" : " or ") + (other.name.empty() ? "the top of the file" : other.bracketed());
        }
      }
    }
    std::string meant = elsewhere.empty() ? nearest_word(name, candidates) : "";
    std::string remedy = fmt::format("see `{}` for what there is", schema_.command);
    if (!elsewhere.empty()) remedy = "it belongs in " + elsewhere;
    if (!meant.empty()) {
      const Table* inner = child(table, meant);
      remedy = "did you mean " + (inner != nullptr ? inner->bracketed() : meant) + "?";
    }
    problems_.add(at, fmt::format("{}unknown {} {}; {}", path.empty() ? "" : fmt::format("[{}] ", path), is_table ? "table" : "key",
                                  is_table ? fmt::format("[{}]", one_line(name)) : one_line(name), remedy));
    return meant;
  }

  void check_entry(const Table& table, std::size_t i) {
    const std::string path = table.entry_path(i);
    if (!problems_.valid(path)) return;
    for (const Key& key : table.keys) check_key(table, key, path, i);
    TableReport report(problems_, path);
    table.check(root_, i, report);
  }

  /// Whether the condition holds, if its keys were read without error.
  [[nodiscard]] std::optional<bool> known(const Condition& condition, const Table& table, const std::string& path, std::size_t i) const {
    const auto valid = [&](const Condition::Test& test) {
      return problems_.valid(test.key.empty() ? test.table : key_path(path, test.key));
    };
    return std::ranges::all_of(condition.tests, valid) ? std::optional(schema_.holds(condition, table, root_, i)) : std::nullopt;
  }

  /// Reports keys that are missing, not used, or exclude each other.
  void check_key(const Table& table, const Key& key, const std::string& path, std::size_t i) {
    const std::string here = key_path(path, key.name);
    const bool is_given = problems_.given(here);
    if (is_given && known(key.used, table, path, i) == false)
      problems_.problem(here, fmt::format("is used with {} only; leave it out", key.used_when));
    for (const std::string& other : key.excludes) {
      if (is_given && problems_.given(key_path(path, other)))
        problems_.problem(here, fmt::format("is given beside {}; both set the same quantity, leave one out", other));
    }
    if (key.required && !is_given && schema_.used(key, table, root_, i) &&
        known(key.required->always() ? key.used : *key.required, table, path, i) == true) {
      const std::string why = key.required_when == "always" ? "" : " (required with " + key.required_when + ")";
      problems_.problem(here, fmt::format("is missing{}; give {}: {}", why, expected_value(key), key.description));
    }
  }

  const Schema& schema_;
  const TomlInput& source_;
  FileProblems& problems_;
  void* root_;
};

}  // namespace

void read(const Schema& schema, std::string_view text, std::string_view file, const std::vector<std::string>& overrides, void* root,
          const std::function<void(ParameterReport&)>& check, std::string_view prefix) {
  FileProblems problems{std::string(file)};
  const TomlInput source(schema, text, file, overrides, prefix, problems);
  Reader reader(schema, source, problems, root);
  reader.read_all();
  reader.check_all();
  check(problems);
  problems.throw_if_any();
}

}  // namespace mpm::config
