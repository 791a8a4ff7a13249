#include "libmpm/config/schema.hpp"

#include <algorithm>

#include "libmpm/config/toml_text.hpp"

namespace mpm::config {

std::string key_path(const std::string& table_path, const std::string& name) { return table_path.empty() ? name : table_path + "." + name; }

const Table* Schema::find(std::string_view table) const {
  const auto at = std::ranges::find(tables_, table, &Table::name);
  return at != tables_.end() ? &*at : nullptr;
}

const Key* Schema::find_key(std::string_view table, std::string_view name) const {
  const Table* owner = find(table);
  if (owner == nullptr) return nullptr;
  const auto at = std::ranges::find(owner->keys, name, &Key::name);
  return at != owner->keys.end() ? &*at : nullptr;
}

std::vector<std::string> Schema::rivals(const std::string& path) const {
  std::vector<std::string> others;
  for (const Table& table : tables_) {
    for (const Key& key : table.keys) {
      const std::string here = key_path(table.name, key.name);
      for (const std::string& excluded : key.excludes) {
        const std::string there = key_path(table.name, excluded);
        if (here == path) others.push_back(there);
        if (there == path) others.push_back(here);
      }
    }
  }
  return others;
}

bool Schema::holds(const Condition& condition, const Table& table, const void* root, std::size_t i) const {
  return std::ranges::all_of(condition.tests, [&](const Condition::Test& test) {
    if (test.key.empty()) {
      const Table* other = find(test.table);
      return (other != nullptr && other->entries(root) > 0) == test.present;
    }
    const std::optional<Value> value = find_key(table.name, test.key)->get(root, i);
    if (!value) return false;
    return test.below ? std::get<double>(*value) < *test.below
                      : std::ranges::find(test.words, std::get<std::string>(*value)) != test.words.end();
  });
}

std::optional<Value> Schema::written(const Key& key, const Table& table, const void* root, std::size_t i) const {
  if (i >= table.entries(root) || !used(key, table, root, i)) return std::nullopt;
  const auto value = key.get(root, i);
  return key.hide_default && value == key.preset ? std::nullopt : value;
}

Table& Schema::add(std::string name, bool repeated, std::string description) {
  return tables_.emplace_back(Table{std::move(name), repeated, std::move(description), {}, {}, {}, {}});
}

void Schema::describe(KeyInfo& key, const std::string& table) {
  key.table = table;
  if (!key.used.always()) key.used_when = key.used.text();
  if (key.required) key.required_when = key.required->always() ? key.used.text() : key.required->text();
  key.default_text = key.left_out;
  const bool always_given = key.required && key.required->always();  // wherever it is used
  if (key.left_out.empty() && !always_given && key.preset) key.default_text = to_toml(*key.preset);
}

}  // namespace mpm::config
