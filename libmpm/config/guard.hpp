#pragma once
/// Bounds on the input of the TOML parser.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace mpm::config {

/// Largest file. A case of a million bodies is smaller; the parser needs some hundred bytes of memory for each byte of keys.
inline constexpr std::size_t most_bytes = std::size_t{8} << 20;

/// Most parts of a dotted key, as in a.b.c = 1. The parser makes a table of each and destroys them recursively: without a bound a key of
/// a hundred thousand parts causes a stack overflow. (The parser itself bounds the nesting of values.)
inline constexpr int most_key_parts = 16;

/// @throws ConfigError with its place if the text is larger than most_bytes, a key has more than most_key_parts, or for input on which the
/// parser of Debian 12 (toml++ 3.3) has undefined behaviour: a table's header without a name fails an assertion, a character beyond ASCII
/// outside quotes and comments reaches code that is marked unreachable
void check_text(std::string_view text, std::string_view file_name);

/// The text of a file; no more than most_bytes + 1 bytes are read, so that reading a device without end stops, too. @throws IoError
[[nodiscard]] std::string bounded_file_text(const std::filesystem::path& file);

/// Whether a line begins with [table]: which of the kinds of file a text is, where it cannot be read as the kind that was expected.
[[nodiscard]] bool has_table(std::string_view text, std::string_view table);

}  // namespace mpm::config
