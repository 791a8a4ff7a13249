#include "libmpm/config/toml_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/config/guard.hpp"
#include "libmpm/config/toml_text.hpp"

namespace mpm::config {

namespace {

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

}  // namespace

TomlInput::TomlInput(const Schema& schema, std::string_view text, std::string_view file, const std::vector<std::string>& overrides,
                     std::string_view prefix, FileProblems& problems)
    : schema_(schema), problems_(problems), prefix_(prefix), root_(parsed(text, file)) {
  for (const std::string& override_text : overrides) {
    Override change{"", override_text};
    const std::string problem = apply(change);
    overrides_.push_back(change);
    if (!problem.empty()) problems.add(position_of(change, overrides_.size()), problem);
  }
}

FilePosition TomlInput::position_of(const Override& change, std::size_t number) const {
  return {number, 1, 1, prefix_ + one_line(change.text)};
}

FilePosition TomlInput::position_of(const std::string& path, const toml::source_region& source) const {
  for (std::size_t i = overrides_.size(); i-- > 0;) {
    const Override& o = overrides_[i];
    const bool inside = path == o.path || path.starts_with(o.path + ".") || path.starts_with(o.path + "[");
    if (inside || (source.begin.line == 0 && o.path.starts_with(path + "."))) return position_of(o, i + 1);
  }
  return problems_.in_file(source.begin.line, source.begin.column);
}

std::string TomlInput::apply(Override& change) {
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

toml::table* TomlInput::table_for(const std::string& path, std::string& problem) {
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

void TomlInput::remove_rivals(const std::string& path, toml::table& table) {
  for (const std::string& rival : schema_.rivals(path)) {
    const bool overridden = std::ranges::any_of(overrides_, [&](const Override& o) { return o.path == rival; });
    if (!overridden) table.erase(rival.substr(rival.rfind('.') + 1));
  }
}

}  // namespace mpm::config
