#include "libmpm/config/writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "libmpm/config/toml_text.hpp"

namespace mpm::config {

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

std::string write(const Schema& schema, const void* root, const std::vector<std::string>& skip) {
  std::string out;
  for (const Table& table : schema.tables()) {
    for (std::size_t i = 0; i < table.entries(root); ++i) {
      std::string lines;
      for (const Key& key : table.keys) {
        if (skips(skip, table, key)) continue;
        if (const auto value = schema.written(key, table, root, i)) lines += fmt::format("{} = {}\n", key.name, to_toml(*value));
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
  const auto value = schema.written(*key, *schema.find(table_name), root, index);
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
          const auto value = schema.written(key, table, root, i);
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
