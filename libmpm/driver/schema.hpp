#pragma once
/// Reference of the keys of case files and point paths. The components declare their keys (base/parameter.hpp); reading, range
/// checks, suggestions, writing and this reference all follow from these declarations.

#include <string>
#include <vector>

#include "libmpm/config/reference.hpp"
#include "libmpm/config/schema.hpp"

namespace mpm {

/// The tables, keys and laws, in the order in which they are written.
[[nodiscard]] const std::vector<TableInfo>& schema_tables();
/// All keys, table by table.
[[nodiscard]] const std::vector<KeyInfo>& schema_keys();
/// All laws.
[[nodiscard]] const std::vector<ModelInfo>& schema_models();

/// The reference that `mpm schema` prints: readable text, or one JSON object {format_version, tables, models}.
[[nodiscard]] std::string schema_text();
/// The same as JSON, for scripts.
[[nodiscard]] std::string schema_json();

}  // namespace mpm
