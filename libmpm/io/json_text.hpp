#pragma once
/// JSON files, checked before they are parsed.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace mpm {

/// The text of a JSON file. Parsed values are read, written and destroyed recursively, so deeply nested brackets would cause a stack
/// overflow. The parser checks the syntax.
/// @throws IoError if it cannot be read, is larger than 256 MB or nested deeper than 64
std::string read_json_text(const std::filesystem::path& path);

/// The object in a JSON file; null if the file does not hold one. @throws IoError as read_json_text
nlohmann::ordered_json read_json_object(const std::filesystem::path& path);

}  // namespace mpm
