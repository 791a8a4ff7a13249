#pragma once
/// Bounds on what is handed to the TOML parser, and on how much is reported about it.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace mpm::config {

/// A case of a million bodies is smaller; the parser needs some hundred bytes of memory for each byte of keys.
inline constexpr std::size_t most_bytes = std::size_t{8} << 20;

/// Parts of a dotted key, as in a.b.c = 1. The parser makes a table of each and takes them down recursively: without a bound a key of
/// a hundred thousand parts ends the program by a stack overflow. (It bounds the nesting of values itself.)
inline constexpr int most_key_parts = 16;

/// Problems after which a file is not read on, and how many of them are shown.
/// @{
inline constexpr std::size_t most_problems = 1000, problems_shown = 200;
/// @}

/// @throws ConfigError with its place if the text is larger than most_bytes, a key has more than most_key_parts, or where the parser of
/// Debian 12 (toml++ 3.3) would leave what its language defines: a table's header without a name fails an assertion, a character beyond
/// ASCII outside quotes and comments reaches code that is marked unreachable
void check_text(std::string_view text, std::string_view file_name);

/// The text of a file; no more than most_bytes + 1 bytes are read, so that an endless device ends, too. @throws IoError
[[nodiscard]] std::string bounded_file_text(const std::filesystem::path& file);

}  // namespace mpm::config
