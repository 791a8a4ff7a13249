#pragma once
/// TOML values as text, in messages and in files.

#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace mpm::config {

/// "a table", "an integer"
[[nodiscard]] std::string kind_of(const toml::node& node);

/// Replaces control characters by spaces; messages of the parser quote them unchanged.
[[nodiscard]] std::string printable(std::string_view text);

/// Without line breaks, cut to a length that fits a message.
[[nodiscard]] std::string one_line(std::string text);

/// What the parser refuses: "case.toml:3:1: not valid TOML: ...". @param file  name in the message
[[nodiscard]] std::string syntax_error(const toml::parse_error& error, std::string_view file);

/// A value as TOML; numbers read back to the same bits.
[[nodiscard]] std::string toml_text(const toml::node& node);

/// The value in a message: one line, cut to a limited length.
[[nodiscard]] std::string shown(const toml::node& node);

}  // namespace mpm::config
