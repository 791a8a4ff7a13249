#pragma once
/// Checksums of text files, so that a reader notices a digit that changed.

#include <string>
#include <string_view>

namespace mpm {

/// CRC-32 (that of zip) of a text, as eight hexadecimal digits.
[[nodiscard]] std::string checksum(std::string_view text);

/// Entry of a JSON file with the checksum of the file.
inline constexpr const char* checksum_entry = "crc32";
/// Its value while the checksum is computed.
inline constexpr const char* no_checksum = "00000000";

/// A JSON text with the checksum in place of the value no_checksum of its entry checksum_entry. Without such an entry it stays as it is.
[[nodiscard]] std::string with_checksum(std::string json);
/// Whether a JSON text is as with_checksum() made it; true for a text without any checksum, as in files of older versions.
[[nodiscard]] bool is_intact(const std::string& json);

}  // namespace mpm
