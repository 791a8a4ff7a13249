#pragma once
/// JSON objects from files. For sources only: with this header comes the JSON library, which users of the headers do not need.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "libmpm/io/json_text.hpp"

namespace mpm {

/// The object in a JSON file; null if the file does not hold one. @throws IoError as read_json_text
inline nlohmann::ordered_json read_json_object(const std::filesystem::path& path) {
  auto json = nlohmann::ordered_json::parse(read_json_text(path), nullptr, false);
  if (!json.is_object()) json = nullptr;
  return json;
}

/// A JSON text with a line break at its end. Bytes that are not UTF-8, such as those of a path, are replaced: JSON has none.
inline std::string json_text(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace mpm
