#pragma once
/// JSON files of results before they are parsed.

#include <filesystem>
#include <string>

namespace mpm {

/// The text of a JSON file. Parsed values are walked, written and destroyed by recursion: a file of brackets would end the program by a
/// stack overflow. Whether it is JSON at all is the parser's business.
/// @throws IoError if it cannot be read, is larger than 256 MB or nested deeper than 64
std::string read_json_text(const std::filesystem::path& path);

}  // namespace mpm
