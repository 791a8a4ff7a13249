#include "libmpm/config/schema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

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

std::optional<Value> Schema::written(const Key& key, const Table& table, const void* root, std::size_t i, Defaults defaults) const {
  if (i >= table.entries(root) || !used(key, table, root, i)) return std::nullopt;
  const auto value = key.get(root, i);
  return key.hide_default && defaults == Defaults::shown && value == key.preset ? std::nullopt : value;
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

// ---- Objects as TOML -------------------------------------------------------------------------------------------------------------------

namespace {

bool skips(const std::vector<std::string>& skip, const Table& table, const Key& key) {
  return std::ranges::find(skip, key_path(table.name, key.name)) != skip.end();
}

/// A long text, such as a raster, by its beginning and its hash.
std::string shortened(const std::string& text) {
  constexpr std::size_t longest = 200, beginning = 60;
  if (text.size() <= longest) return text;
  return fmt::format("{}... ({} characters, hash {:016x})", text.substr(0, beginning), text.size(), hash(text));
}

}  // namespace

std::string write(const Schema& schema, const void* root, Defaults defaults, const std::vector<std::string>& skip) {
  std::string out;
  for (const Table& table : schema.tables()) {
    for (std::size_t i = 0; i < table.entries(root); ++i) {
      std::string lines;
      for (const Key& key : table.keys) {
        if (skips(skip, table, key)) continue;
        if (const auto value = schema.written(key, table, root, i, defaults)) lines += fmt::format("{} = {}\n", key.name, to_toml(*value));
      }
      if (lines.empty()) continue;  // a table of optional keys, none of them given
      if (!table.name.empty()) out += fmt::format("\n{}\n", table.bracketed());
      out += lines;
    }
  }
  return out;
}

std::optional<std::string> value_of(const Schema& schema, const void* root, const std::string& path) {
  const std::size_t dot = path.rfind('.');
  std::string table_name = dot == std::string::npos ? "" : path.substr(0, dot);
  const std::string name = dot == std::string::npos ? path : path.substr(dot + 1);
  std::size_t index = 0;
  if (const auto bracket = table_name.find('['); bracket != std::string::npos) {
    index = static_cast<std::size_t>(std::strtoul(table_name.c_str() + bracket + 1, nullptr, 10));
    table_name.resize(bracket);
  }
  const Key* key = schema.find_key(table_name, name);
  if (key == nullptr) return {};
  const auto value = schema.written(*key, *schema.find(table_name), root, index, Defaults::all);
  if (!value) return {};
  const auto* text = std::get_if<std::string>(&*value);
  return text != nullptr ? *text : to_toml(*value);
}

std::vector<std::string> differences(const Schema& schema, const void* before, const void* now, const std::vector<std::string>& skip) {
  std::vector<std::string> found;
  for (const Table& table : schema.tables()) {
    for (std::size_t i = 0; i < std::max(table.entries(before), table.entries(now)); ++i) {
      for (const Key& key : table.keys) {
        if (skips(skip, table, key)) continue;
        const auto text = [&](const void* root) {
          const auto value = schema.written(key, table, root, i, Defaults::all);
          return value ? to_toml(*value) : "(none)";
        };
        const std::string was = text(before), is = text(now);
        if (was != is) {
          found.push_back(fmt::format("{} was {}, is {}", key_path(table.entry_path(i), key.name), shortened(was), shortened(is)));
        }
      }
    }
  }
  return found;
}

std::uint64_t hash(std::string_view text) {
  std::uint64_t h = 0xcbf29ce484222325u;  // offset basis
  for (const char c : text) {
    h ^= static_cast<unsigned char>(c);
    h *= 0x100000001b3u;  // prime
  }
  return h;
}

}  // namespace mpm::config
