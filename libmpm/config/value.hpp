#pragma once
/// Conversion of a TOML value to the value of a key.

#include <toml++/toml.h>

#include <optional>
#include <string>

#include "libmpm/config/schema.hpp"

namespace mpm::config {

/// The value, if it has the type of the key and is permitted.
/// @param problem  otherwise the error: "is a string", "is out of range"
[[nodiscard]] std::optional<Value> to_value(const KeyInfo& key, const toml::node& node, std::string& problem);

}  // namespace mpm::config
