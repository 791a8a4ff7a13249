#pragma once
/// Writes an object as TOML by its schema; compares and hashes objects in that form.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/config/schema.hpp"

namespace mpm::config {

/// Every key that applies, as a file that reads back to the same object. @param skip  keys that are left out ("table.name")
[[nodiscard]] std::string write(const Schema& schema, const void* root, const std::vector<std::string>& skip = {});

/// One key, "table.key" or "body[0].key", as text: a number as in `write`, a string without its quotes. Empty if it is not written.
[[nodiscard]] std::optional<std::string> value_of(const Schema& schema, const void* root, const std::string& path);

/// The keys in which two objects differ: "numerics.cfl was 0.4, is 0.3", "body[1].shape was "box", is (none)".
[[nodiscard]] std::vector<std::string> differences(const Schema& schema, const void* before, const void* now,
                                                   const std::vector<std::string>& skip);

/// FNV-1a, 64 bit.
[[nodiscard]] std::uint64_t hash(std::string_view text);

}  // namespace mpm::config
