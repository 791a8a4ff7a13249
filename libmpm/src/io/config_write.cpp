#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "config_keys.hpp"
#include "mpm/io/config.hpp"

namespace mpm {

namespace config {

namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

struct TomlWriter {
  std::string operator()(bool x) const { return x ? "true" : "false"; }
  std::string operator()(std::int64_t x) const { return fmt::format("{}", x); }
  std::string operator()(double x) const { return to_toml(x); }
  std::string operator()(const std::string& x) const { return quoted(x); }
  std::string operator()(const Vec3& x) const { return fmt::format("[{}, {}, {}]", to_toml(x[0]), to_toml(x[1]), to_toml(x[2])); }
  std::string operator()(const Mat3& x) const {
    return fmt::format("[{}, {}, {}]", (*this)(Vec3(x.row(0))), (*this)(Vec3(x.row(1))), (*this)(Vec3(x.row(2))));
  }
  std::string operator()(const std::vector<std::string>& x) const {
    std::string out;
    for (const std::string& word : x) out += (out.empty() ? "" : ", ") + quoted(word);
    return "[" + out + "]";
  }
};

/// The case as TOML without the keys that `skip` names ("table.name").
std::string write(const Case& spec, const std::vector<std::string>& skip) {
  Draft draft;
  draft.spec = spec;
  std::string out;
  for (const TableInfo& table : schema_tables()) {
    if (!table.in_case) continue;
    for (std::size_t i = 0; i < entries(draft, table.name); ++i) {
      std::string lines;
      for (const Key& key : keys()) {
        if (key.table != table.name || (key.used && !key.used->holds(draft, i))) continue;
        const std::string path = key_path(table.name, key.name);
        if (std::find(skip.begin(), skip.end(), path) != skip.end()) continue;
        if (const auto value = key.get(draft, i)) lines += fmt::format("{} = {}\n", key.name, to_toml(*value));
      }
      if (lines.empty()) continue;  // a table of optional keys, none of them given
      if (!table.name.empty()) out += table.repeated ? fmt::format("\n[[{}]]\n", table.name) : fmt::format("\n[{}]\n", table.name);
      out += lines;
    }
  }
  return out;
}

}  // namespace

std::string to_toml(double x) {
  std::string out = fmt::format("{}", x);
  if (out.find_first_of(".en") == std::string::npos) out += ".0";  // otherwise TOML reads an integer
  return out;
}

std::string to_toml(const Value& value) { return std::visit(TomlWriter{}, value); }

}  // namespace config

std::string write_case(const Case& spec) { return config::write(spec, {}); }

std::optional<std::string> case_value(const Case& spec, const std::string& path) {
  std::string name = path;
  std::size_t index = 0;
  if (const auto bracket = name.find('['); bracket != std::string::npos) {
    const auto end = name.find(']', bracket);
    if (end == std::string::npos) return {};
    index = static_cast<std::size_t>(std::strtoul(name.c_str() + bracket + 1, nullptr, 10));
    name.erase(bracket, end + 1 - bracket);
  }
  config::Draft draft;
  draft.spec = spec;
  for (const config::Key& key : config::keys()) {
    if (config::key_path(key.table, key.name) != name || index >= config::entries(draft, key.table)) continue;
    const auto value = key.get(draft, index);
    if (!value) return {};
    const auto* text = std::get_if<std::string>(&*value);
    return text != nullptr ? *text : config::to_toml(*value);
  }
  return {};
}

namespace {

/// Keys without influence on the computed numbers.
std::vector<std::string> keys_outside_hash(const Case& spec) {
  std::vector<std::string> skip{"title", "output.checkpoint_minutes"};
  const bool strip = spec.conveyor && spec.conveyor->feed == ConveyorSpec::Feed::strip;
  if (!strip) skip.emplace_back("output.duration_s");
  return skip;
}

}  // namespace

std::vector<std::string> case_differences(const Case& before, const Case& now) {
  const std::vector<std::string> skip = keys_outside_hash(before);
  config::Draft a, b;
  a.spec = before;
  b.spec = now;
  const auto text = [](const config::Draft& draft, const std::string& table, const config::Key& key, std::size_t i) -> std::string {
    if (i >= config::entries(draft, table) || (key.used && !key.used->holds(draft, i))) return "(none)";
    const auto value = key.get(draft, i);
    return value ? config::to_toml(*value) : "(none)";
  };
  std::vector<std::string> differences;
  for (const TableInfo& table : schema_tables()) {
    if (!table.in_case) continue;
    for (std::size_t i = 0; i < std::max(config::entries(a, table.name), config::entries(b, table.name)); ++i) {
      for (const config::Key& key : config::keys()) {
        if (key.table != table.name || std::ranges::find(skip, config::key_path(table.name, key.name)) != skip.end()) continue;
        const std::string was = text(a, table.name, key, i), is = text(b, table.name, key, i);
        const std::string place = table.repeated ? fmt::format("{}[{}]", table.name, i) : table.name;
        if (was != is) differences.push_back(fmt::format("{} was {}, is {}", config::key_path(place, key.name), was, is));
      }
    }
  }
  return differences;
}

std::uint64_t case_hash(const Case& spec) {
  const std::vector<std::string> skip = keys_outside_hash(spec);
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a, 64 bit: offset basis and prime
  for (const char c : config::write(spec, skip)) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3u;
  }
  return hash;
}

std::string case_hash_text(const Case& spec) { return fmt::format("{:016x}", case_hash(spec)); }

}  // namespace mpm
