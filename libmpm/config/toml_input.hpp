#pragma once
/// The TOML text of a file after the overrides of --set, with the origin of each entry.

#include <toml++/toml.h>

#include <string>
#include <string_view>
#include <vector>

#include "libmpm/config/file_problems.hpp"
#include "libmpm/config/schema.hpp"

namespace mpm::config {

/// A TOML file with its overrides.
class TomlInput {
 public:
  /// @param overrides  "table.key=value"; invalid ones are reported to the problems
  /// @param prefix     of an override in messages
  /// @throws ConfigError if the text is not TOML
  TomlInput(const Schema& schema, std::string_view text, std::string_view file, const std::vector<std::string>& overrides,
            std::string_view prefix, FileProblems& problems);

  [[nodiscard]] const toml::table& root() const { return root_; }  ///< with the overrides
  /// Position of a key or table: at `source` in the file, or in an override.
  [[nodiscard]] FilePosition position_of(const std::string& path, const toml::source_region& source) const;

 private:
  struct Override {
    std::string path;  ///< "body[0].velocity_m_s"; empty if invalid
    std::string text;  ///< as given
  };
  /// @param number  from 1
  [[nodiscard]] FilePosition position_of(const Override& change, std::size_t number) const;
  /// @returns the error; empty if there is none
  std::string apply(Override& change);
  /// The table that holds the key of a path; created if missing. @param problem  the reason if that fails
  toml::table* table_for(const std::string& path, std::string& problem);
  /// Removes the file's value of the same quantity. A value from another override stays, so that the conflict of the two is reported.
  void remove_rivals(const std::string& path, toml::table& table);

  const Schema& schema_;
  const FileProblems& problems_;
  std::string prefix_;
  toml::table root_;
  std::vector<Override> overrides_;
};

}  // namespace mpm::config
