#pragma once
/// Text of JSON files, checked before it is parsed.

#include <filesystem>
#include <string>

namespace mpm {

/// The text of a JSON file. Parsed values are read, written and destroyed recursively, so deeply nested brackets would cause a stack
/// overflow. The parser checks the syntax.
/// @throws IoError if it cannot be read, is larger than 256 MB or nested deeper than 64
std::string read_json_text(const std::filesystem::path& path);

}  // namespace mpm
