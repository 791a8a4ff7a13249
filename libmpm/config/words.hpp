#pragma once
/// Words in messages and files: values of keys as TOML, and what a misspelt word may have meant.

#include <string>
#include <string_view>
#include <vector>

#include "libmpm/base/parameter.hpp"

namespace mpm {

/// The candidate most similar to a misspelt word; empty if none is similar. Similar means at most two edits (a third of the
/// longer word's length, if that is more; edits are insertion, deletion, substitution, swap of neighbours), or one word
/// beginning with the other (a forgotten unit).
[[nodiscard]] std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace mpm

namespace mpm::config {

/// A value as TOML; numbers with enough digits to read back to the same bits.
[[nodiscard]] std::string to_toml(const ParameterValue& value);

/// "text" in quotes, as TOML
[[nodiscard]] std::string quoted(const std::string& text);

}  // namespace mpm::config
