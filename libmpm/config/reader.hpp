#pragma once
/// Reads a TOML file into the object that a schema describes.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/config/schema.hpp"

namespace mpm::config {

/// Fills `root`, whose values are the defaults, from a text.
/// @param overrides  "table.key=value" as given by --set, "body[0].velocity_m_s=[1,0,0]" in a repeated table; the value is TOML, a bare
///                   word is taken as a string. An override replaces the file's value, and the value of another key that sets the same
///                   quantity.
/// @param check      checks conditions between tables; may complete the root. Called after the tables are read and checked, even if they
///                   have errors; the report states which keys are valid
/// @param prefix     of an override in messages: where it was given
/// @throws ConfigError with all errors at once, one a line, in the order of the file: `file:line:column: [table] what, value, remedy`
///         (`prefix` and table.key=value in place of the position where an override is wrong)
void read(const Schema& schema, std::string_view text, std::string_view file, const std::vector<std::string>& overrides, void* root,
          const std::function<void(ParameterReport&)>& check, std::string_view prefix = "--set ");

/// The same, typed. @param check  (Root&, ParameterReport&)
template <class Root, class Check>
Root read(const SchemaOf<Root>& schema, std::string_view text, std::string_view file, const std::vector<std::string>& overrides,
          Check check, std::string_view prefix = "--set ") {
  Root root;
  read(
      schema, text, file, overrides, &root, [&](ParameterReport& report) { check(root, report); }, prefix);
  return root;
}

}  // namespace mpm::config
