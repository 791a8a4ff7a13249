#include "libmpm/config/toml_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "libmpm/config/words.hpp"

namespace mpm::config {

std::string kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table: return "a table";
    case toml::node_type::array: return "a list";
    case toml::node_type::string: return "a string";
    case toml::node_type::integer: return "an integer";
    case toml::node_type::floating_point: return "a float";
    case toml::node_type::boolean: return "a boolean";
    default: return "a date or time";
  }
}

std::string printable(std::string_view text) {
  std::string line(text);
  std::ranges::replace_if(
      line, [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return line;
}

std::string one_line(std::string text) {
  text = printable(text);
  constexpr std::size_t longest = 80;
  if (text.size() > longest) {
    std::size_t cut = longest;
    while (cut > 0 && (static_cast<unsigned char>(text[cut]) & 0xc0u) == 0x80u) --cut;  // not within a UTF-8 character
    text = text.substr(0, cut) + "...";
  }
  return text;
}

std::string syntax_error(const toml::parse_error& error, std::string_view file) {
  const auto& at = error.source().begin;
  return fmt::format("{}:{}:{}: not valid TOML: {}", file, at.line, at.column, printable(error.description()));
}

std::string toml_text(const toml::node& node) {
  if (const auto x = node.value_exact<double>()) return to_toml(*x);
  if (const toml::array* list = node.as_array()) {
    std::string inside;
    for (const toml::node& element : *list) inside += (inside.empty() ? "" : ", ") + toml_text(element);
    return "[" + inside + "]";
  }
  constexpr auto flags = toml::toml_formatter::default_flags & ~toml::format_flags::allow_literal_strings;
  std::ostringstream out;
  node.visit([&](const auto& value) { out << toml::toml_formatter{value, flags}; });
  return out.str();
}

std::string shown(const toml::node& node) { return one_line(toml_text(node)); }

}  // namespace mpm::config
