#pragma once
/// Numbers as text for messages, and small operations on text. The core links no formatting library.

#include <algorithm>
#include <cctype>
#include <charconv>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mpm {

/// x with at most `digits` significant digits, as printf's %g.
inline std::string number_text(double x, int digits = 6) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, x, std::chars_format::general, digits).ptr;
  return {buffer, end};
}

/// A count with its noun in the right number: "1 run", "2 runs". @param noun  one whose plural takes an s
inline std::string counted(std::integral auto count, std::string_view noun) {
  return std::to_string(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

/// "(x, y, z)" with at most `digits` significant digits each. @param v anything indexed 0, 1, 2
template <class Vector>
std::string vector_text(const Vector& v, int digits = 4) {
  return std::string("(") + number_text(v[0], digits) + ", " + number_text(v[1], digits) + ", " + number_text(v[2], digits) + ")";
}

/// The number that a text is, with or without a leading '+'; empty if it is not exactly one.
inline std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// A text without the blanks at both ends. @param blanks  the characters that are blanks
inline std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// A text without the byte-order mark of UTF-8 that spreadsheets put before it.
inline std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  return text.substr(text.starts_with(mark) ? mark.size() : 0);
}

/// Bytes of the character at the start of a text; 0 if the text is empty or does not start with UTF-8 (RFC 3629, section 4).
constexpr std::size_t utf8_length(std::string_view text) {
  const auto byte = [text](std::size_t at) { return at < text.size() ? static_cast<unsigned char>(text[at]) : 0u; };
  const unsigned first = byte(0);
  if (text.empty() || first < 0x80) return text.empty() ? 0 : 1;
  const std::size_t length = first < 0xc2 || first > 0xf4 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  const unsigned least = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;  // a smaller one has a shorter form
  const unsigned most = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;   // a greater one is a surrogate or above U+10FFFF
  if (byte(1) < least || byte(1) > most) return 0;
  for (std::size_t at = 2; at < length; ++at) {
    if ((byte(at) & 0xc0) != 0x80) return 0;
  }
  return length;
}

/// Place of the first byte that is not UTF-8; npos if all are.
constexpr std::size_t first_not_utf8(std::string_view text) {
  std::size_t at = 0;
  while (const std::size_t length = utf8_length(text.substr(at))) at += length;
  return at < text.size() ? at : std::string_view::npos;
}

/// A text for tables and JSON: bytes that are not UTF-8 and control characters become '?' and blanks.
inline std::string plain_text(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const bool control = static_cast<unsigned char>(text[0]) < 0x20 || text[0] == 0x7f;
    plain += control ? " " : length == 0 ? "?" : text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(1, length));
  }
  return plain;
}

/// The candidate most similar to a misspelt word; empty if none is similar. Similar means at most two edits (a third of the
/// longer word's length, if that is more; edits are insertion, deletion, substitution, swap of neighbours), or one word
/// beginning with the other (a forgotten unit).
[[nodiscard]] std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates);

/// A text with ASCII letters in lower case.
inline std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace mpm
