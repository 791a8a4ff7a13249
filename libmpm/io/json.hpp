#pragma once
/// JSON files: read with bounds, written with a checksum. For sources only: with this header comes the JSON library, which users of the
/// other headers do not need.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace mpm {

/// The text of a JSON file. Parsed values are written and copied recursively, so deeply nested brackets would cause a stack
/// overflow. The parser checks the syntax.
/// @throws IoError if it cannot be read, is larger than 256 MB or nested deeper than 64
std::string read_json_text(const std::filesystem::path& path);

/// A JSON text with a line break at its end. Bytes that are not UTF-8, such as those of a path, are replaced: JSON has none.
inline std::string json_text(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

/// CRC-32 (that of zip) of a text, as eight hexadecimal digits.
[[nodiscard]] std::string checksum(std::string_view text);

/// Entry of a JSON file with the checksum of the file.
inline constexpr const char* checksum_entry = "crc32";
/// Its value while the checksum is computed.
inline constexpr const char* no_checksum = "00000000";

/// A JSON text with the checksum in place of the value no_checksum of its entry checksum_entry. Without such an entry it stays as it is.
[[nodiscard]] std::string with_checksum(std::string json);
/// Whether a JSON text is as with_checksum() made it; true for a text without any, such as one written by hand.
[[nodiscard]] bool is_intact(const std::string& json);

}  // namespace mpm
