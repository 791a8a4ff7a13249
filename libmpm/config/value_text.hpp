#pragma once
/// Values of keys as TOML.

#include <string>

#include "libmpm/base/parameter_info.hpp"

namespace mpm::config {

/// A value as TOML; numbers with enough digits to read back to the same bits.
[[nodiscard]] std::string to_toml(const ParameterValue& value);

/// "text" in quotes, as TOML
[[nodiscard]] std::string quoted(const std::string& text);

}  // namespace mpm::config
