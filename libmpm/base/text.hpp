#pragma once
/// Numbers as text for messages. The core links no formatting library.

#include <charconv>
#include <concepts>
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

}  // namespace mpm
