#pragma once
/// TOML from text, and TOML values as text, in messages and in files.

#include <toml++/toml.h>

#include <string>
#include <string_view>

#include "libmpm/base/parameter.hpp"

namespace mpm::config {

/// "a table", "an integer"
[[nodiscard]] std::string kind_of(const toml::node& node);

/// Without line breaks, cut to a length that fits a message.
[[nodiscard]] std::string one_line(std::string text);

/// The content of a file. @param file  its name in messages. @throws ConfigError as check_text (guard.hpp), and for what is not TOML
[[nodiscard]] toml::table parsed(std::string_view text, std::string_view file);

/// What the parser refuses: "case.toml:3:1: not valid TOML: ...". @param file  name in the message
[[nodiscard]] std::string syntax_error(const toml::parse_error& error, std::string_view file);

/// A value as TOML, a table on one line; numbers read back to the same bits.
[[nodiscard]] std::string toml_text(const toml::node& node);
/// The tables and keys of a file as TOML.
[[nodiscard]] std::string document_text(const toml::node& node);

/// A value of a key as TOML; numbers with enough digits to read back to the same bits.
[[nodiscard]] std::string to_toml(const ParameterValue& value);

/// The value in a message: one line, cut to a limited length.
[[nodiscard]] std::string shown(const toml::node& node);

}  // namespace mpm::config
