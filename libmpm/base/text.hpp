#pragma once
/// Numbers as text for messages, and small operations on text. The core links no formatting library.

#include <algorithm>
#include <cctype>
#include <charconv>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>

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
  return "(" + number_text(v[0], digits) + ", " + number_text(v[1], digits) + ", " + number_text(v[2], digits) + ")";
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

/// A text for tables and JSON: bytes that are not UTF-8 and control characters become '?' and blanks.
inline std::string plain_text(std::string_view text) {
  std::string plain;
  for (std::size_t at = 0; at < text.size();) {
    const auto c = static_cast<unsigned char>(text[at]);
    const std::size_t length = c < 0x80 ? 1 : c >= 0xc2 && c < 0xe0 ? 2 : c >= 0xe0 && c < 0xf0 ? 3 : c >= 0xf0 && c < 0xf5 ? 4 : 0;
    const std::string_view part = text.substr(at, std::max<std::size_t>(1, length));
    const bool whole =
        length > 0 && part.size() == length && std::ranges::all_of(part.substr(1), [](char x) { return (x & 0xc0) == 0x80; });
    const bool control = c < 0x20 || c == 0x7f;
    if (whole && !control) {
      plain += part;
    } else {
      plain += control ? ' ' : '?';
    }
    at += whole ? length : 1;
  }
  return plain;
}

/// A text with ASCII letters in lower case.
inline std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace mpm
