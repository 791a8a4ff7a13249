#include "libmpm/config/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "libmpm/config/findings.hpp"
#include "libmpm/config/nearest_word.hpp"
#include "libmpm/config/source.hpp"
#include "libmpm/config/toml_text.hpp"
#include "libmpm/config/value.hpp"

namespace mpm::config {

namespace {

/// Walks the tables of a file.
class Reader {
 public:
  Reader(const Schema& schema, const Source& source, Findings& findings, void* root)
      : schema_(schema), source_(source), findings_(findings), root_(root) {}

  void read_all() { read_table(*schema_.find(""), "", source_.root(), 0); }
  void check_all() {
    for (const Table& table : schema_.tables()) {
      if (!findings_.sound(table.name)) continue;
      for (std::size_t i = 0; i < table.entries(root_) && !findings_.given_up(); ++i) check_entry(table, i);
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
      if (findings_.given_up()) return;
      std::string name(toml_key.str());
      const Place at = source_.place_of(key_path(path, name), toml_key.source());
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
      findings_.give_key(key_at, source_.place_of(key_at, node.source()));
      std::string problem;
      if (auto value = to_value(key, node, problem)) {
        values.emplace_back(&key, std::move(*value));
      } else {
        findings_.problem(key_at, fmt::format("= {} {}; give {}", shown(node), problem, expected_value(key)));
      }
    }
    std::ranges::sort(values, {}, [](const auto& v) { return v.first; });  // as declared: the law comes before its parameters
    for (const auto& [key, value] : values) key->set(root_, i, value);
  }

  void read_child(const Table& table, const std::string& path, const toml::node& node, const Place& at) {
    const auto enter = [&](const std::string& entry, const toml::table& content, std::size_t i) {
      const auto& source = content.source();
      findings_.enter_table(entry, source.begin.line == 0 ? at : source_.place_of(entry, source));
      table.add_entry(root_);
      read_table(table, entry, content, i);
    };
    const auto refuse = [&](const Place& place, const std::string& text) {
      findings_.mark_unsound(path);
      findings_.add(place, text);
    };
    if (!table.repeated) {
      if (const toml::table* content = node.as_table()) return enter(path, *content, 0);
      return refuse(at, fmt::format("{} is {}; write [{}] once, its keys below it", path, kind_of(node), path));
    }
    if (const toml::table* content = node.as_table()) {
      findings_.add(at, fmt::format("{} is a single table; write [[{}]] with two brackets, once for each", path, path));
      return enter(path + "[0]", *content, 0);
    }
    const toml::array* list = node.as_array();
    if (list == nullptr) return refuse(at, fmt::format("{} is {}; write [[{}]] and its keys below it", path, kind_of(node), path));
    for (std::size_t i = 0; i < list->size() && !findings_.given_up(); ++i) {
      const std::string entry = fmt::format("{}[{}]", path, i);
      const toml::node& element = *list->get(i);
      static const toml::table nothing;
      const toml::table* content = element.as_table();
      if (content == nullptr) {
        findings_.mark_unsound(entry);
        findings_.add(source_.place_of(entry, element.source()), fmt::format("{} is {}; give a table", entry, kind_of(element)));
      }
      enter(entry, content != nullptr ? *content : nothing, i);
    }
  }

  /// @return the most similar name, empty if none is similar
  std::string report_unknown(const Table& table, const std::string& path, const std::string& name, const toml::node& node,
                             const Place& at) {
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
    std::string remedy = "see `mpm schema` for what there is";
    if (!elsewhere.empty()) remedy = "it belongs in " + elsewhere;
    if (!meant.empty()) {
      const Table* inner = child(table, meant);
      remedy = "did you mean " + (inner != nullptr ? inner->bracketed() : meant) + "?";
    }
    findings_.add(at, fmt::format("{}unknown {} {}; {}", path.empty() ? "" : fmt::format("[{}] ", path), is_table ? "table" : "key",
                                  is_table ? fmt::format("[{}]", one_line(name)) : one_line(name), remedy));
    return meant;
  }

  void check_entry(const Table& table, std::size_t i) {
    const std::string path = table.entry_path(i);
    if (!findings_.sound(path)) return;
    for (const Key& key : table.keys) check_key(table, key, path, i);
    TableReport report(findings_, path);
    table.check(root_, i, report);
  }

  /// Whether the condition holds, if its keys were read without error.
  [[nodiscard]] std::optional<bool> known(const Condition& condition, const Table& table, const std::string& path, std::size_t i) const {
    const auto sound = [&](const Condition::Test& test) {
      return findings_.sound(test.key.empty() ? test.table : key_path(path, test.key));
    };
    return std::ranges::all_of(condition.tests, sound) ? std::optional(schema_.holds(condition, table, root_, i)) : std::nullopt;
  }

  /// Reports keys that are missing, not used, or exclude each other.
  void check_key(const Table& table, const Key& key, const std::string& path, std::size_t i) {
    const std::string here = key_path(path, key.name);
    const bool is_given = findings_.given(here);
    if (is_given && known(key.used, table, path, i) == false)
      findings_.problem(here, fmt::format("is used with {} only; leave it out", key.used_when));
    for (const std::string& other : key.excludes) {
      if (is_given && findings_.given(key_path(path, other)))
        findings_.problem(here, fmt::format("is given beside {}; both set the same quantity, leave one out", other));
    }
    if (key.required && !is_given && schema_.used(key, table, root_, i) &&
        known(key.required->always() ? key.used : *key.required, table, path, i) == true) {
      const std::string why = key.required_when == "always" ? "" : " (required with " + key.required_when + ")";
      findings_.problem(here, fmt::format("is missing{}; give {}: {}", why, expected_value(key), key.description));
    }
  }

  const Schema& schema_;
  const Source& source_;
  Findings& findings_;
  void* root_;
};

}  // namespace

void read(const Schema& schema, std::string_view text, std::string_view file, const std::vector<std::string>& overrides, void* root,
          const std::function<void(ParameterReport&)>& check, std::string_view prefix) {
  Findings findings{std::string(file)};
  const Source source(schema, text, file, overrides, prefix, findings);
  Reader reader(schema, source, findings, root);
  reader.read_all();
  reader.check_all();
  check(findings);
  findings.throw_if_any();
}

}  // namespace mpm::config
