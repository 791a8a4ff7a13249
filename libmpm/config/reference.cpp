#include "libmpm/config/reference.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace mpm::config {

namespace {

std::string type_text(const KeyInfo& key) {
  switch (key.type) {
    case KeyType::text:
    case KeyType::choice: return "string";
    case KeyType::number: return "number";
    case KeyType::integer: return "integer";
    case KeyType::boolean: return "true or false";
    case KeyType::vector: return "[x, y, z]";
    case KeyType::matrix: return "3 x 3 numbers by rows";
    case KeyType::axes: return "list of strings";
  }
  return {};
}

}  // namespace

void Reference::add(const Table& table, const void* empty, bool in_case, bool in_path) {
  tables.push_back({table.name, table.repeated, !table.repeated && table.entries(empty) == 0, in_case, in_path, table.description});
  keys.insert(keys.end(), table.keys.begin(), table.keys.end());
}

std::string reference_text(const Reference& reference) {
  std::string out = fmt::format(
      "Reference of {}, format version {}. TOML 1.0, SI units as named in the keys.\n"
      "A key that is not listed, or that does not apply, is refused. Ranges: [ ] with, ( ) without the end.\n",
      reference.files, reference.format_version);
  for (const TableInfo& table : reference.tables) {
    const std::string title = table.name.empty() ? "(top)" : table.repeated ? "[[" + table.name + "]]" : "[" + table.name + "]";
    out += fmt::format("\n{}  {}.\n", title, table.description);
    for (const KeyInfo& key : reference.keys) {
      if (key.table != table.name) continue;
      std::string kind = type_text(key);
      if (!key.unit.empty()) kind += ", " + key.unit;
      if (key.range) kind += ", " + range_text(*key.range);
      out += fmt::format("  {:<30}{}\n", key.name, kind);
      const auto detail = [&](std::string_view what, const std::string& text) {
        if (!text.empty()) out += fmt::format("      {:<9} {}\n", what, text);
      };
      out += fmt::format("      {}.\n", key.description);
      detail("one of", fmt::format("{}", fmt::join(key.choices, ", ")));
      detail("required", key.required_when);
      detail("default", key.default_text);
      detail("only with", key.used_when);
    }
  }
  if (!reference.models.empty()) out += "\nLaws (material.model), and the keys of [material] they use besides model and density_kg_m3:\n";
  for (const ModelInfo& model : reference.models) {
    out += fmt::format("  {}\n      {}.\n      keys      {}\n", model.name, model.description, fmt::join(model.keys, ", "));
  }
  return out;
}

std::string reference_json(const Reference& reference) {
  using nlohmann::ordered_json;
  ordered_json root;
  root["format_version"] = reference.format_version;
  for (const TableInfo& table : reference.tables) {
    ordered_json keys = ordered_json::array();
    for (const KeyInfo& key : reference.keys) {
      if (key.table != table.name) continue;
      ordered_json entry{{"name", key.name}, {"type", type_text(key)}, {"unit", key.unit}, {"description", key.description}};
      if (key.range) {
        entry["range"] = ordered_json{
            {"low", key.range->low}, {"high", key.range->high}, {"low_open", key.range->low_open}, {"high_open", key.range->high_open}};
      }
      if (!key.choices.empty()) entry["one_of"] = key.choices;
      if (!key.default_text.empty()) entry["default"] = key.default_text;
      if (!key.required_when.empty()) entry["required"] = key.required_when;
      if (!key.used_when.empty()) entry["only_with"] = key.used_when;
      keys.push_back(entry);
    }
    root["tables"].push_back({{"name", table.name},
                              {"repeated", table.repeated},
                              {"optional", table.optional},
                              {"in_case", table.in_case},
                              {"in_path", table.in_path},
                              {"description", table.description},
                              {"keys", keys}});
  }
  for (const ModelInfo& model : reference.models) {
    root["models"].push_back({{"name", model.name}, {"description", model.description}, {"keys", model.keys}});
  }
  return root.dump(2) + "\n";
}

}  // namespace mpm::config
