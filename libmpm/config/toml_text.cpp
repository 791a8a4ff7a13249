#include "libmpm/config/toml_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>

#include "libmpm/base/error.hpp"
#include "libmpm/config/guard.hpp"

namespace mpm::config {

namespace {

/// Replaces control characters by spaces; messages of the parser quote them unchanged.
std::string printable(std::string_view text) {
  std::string line(text);
  std::ranges::replace_if(
      line, [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return line;
}

}  // namespace

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

toml::table parsed(std::string_view text, std::string_view file) try {
  check_text(text, file);
  return toml::parse(text, file);
} catch (const toml::parse_error& error) {
  throw ConfigError(syntax_error(error, file));
}

std::string syntax_error(const toml::parse_error& error, std::string_view file) {
  const auto& at = error.source().begin;
  return fmt::format("{}:{}:{}: not valid TOML: {}", file, at.line, at.column, printable(error.description()));
}

namespace {

/// "text" in quotes, as TOML
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

struct TomlWriter {
  std::string operator()(bool x) const { return x ? "true" : "false"; }
  std::string operator()(std::int64_t x) const { return fmt::format("{}", x); }
  std::string operator()(double x) const {
    std::string out = fmt::format("{}", x);
    if (out.find_first_of(".en") == std::string::npos) out += ".0";  // otherwise TOML reads an integer
    return out;
  }
  std::string operator()(const std::string& x) const { return quoted(x); }
  std::string operator()(const Vec3& x) const { return fmt::format("[{}, {}, {}]", (*this)(x[0]), (*this)(x[1]), (*this)(x[2])); }
  std::string operator()(const Mat3& x) const {
    return fmt::format("[{}, {}, {}]", (*this)(Vec3(x.row(0))), (*this)(Vec3(x.row(1))), (*this)(Vec3(x.row(2))));
  }
  std::string operator()(const std::vector<std::string>& x) const {
    std::vector<std::string> items;
    for (const std::string& item : x) items.push_back(quoted(item));
    return fmt::format("[{}]", fmt::join(items, ", "));
  }
};

}  // namespace

std::string to_toml(const ParameterValue& value) { return std::visit(TomlWriter{}, value); }

std::string document_text(const toml::node& node) {
  constexpr auto flags = toml::toml_formatter::default_flags & ~toml::format_flags::allow_literal_strings;
  std::ostringstream out;
  node.visit([&](const auto& value) { out << toml::toml_formatter{value, flags}; });
  return out.str();
}

std::string toml_text(const toml::node& node) {
  if (const auto x = node.value_exact<double>()) return to_toml(*x);
  if (const toml::array* list = node.as_array()) {
    std::string inside;
    for (const toml::node& element : *list) inside += (inside.empty() ? "" : ", ") + toml_text(element);
    return "[" + inside + "]";
  }
  if (const toml::table* table = node.as_table()) {
    toml::table in_line = *table;
    in_line.is_inline(true);
    return document_text(in_line);
  }
  return document_text(node);
}

std::string shown(const toml::node& node) { return one_line(toml_text(node)); }

}  // namespace mpm::config
