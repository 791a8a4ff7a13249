#pragma once
/// The TOML text of a file with the overrides of --set put into it, and the place that everything in it came from.

#include <toml++/toml.h>

#include <string>
#include <string_view>
#include <vector>

#include "libmpm/config/findings.hpp"
#include "libmpm/config/schema.hpp"

namespace mpm::config {

/// A TOML file as it counts.
class Source {
 public:
  /// @param overrides  "table.key=value"; one that is not understood goes to the findings
  /// @throws ConfigError if the text is not TOML
  Source(const Schema& schema, std::string_view text, std::string_view file, const std::vector<std::string>& overrides, Findings& findings);

  [[nodiscard]] const toml::table& root() const { return root_; }  ///< with the overrides in it
  /// Of a key or table that is at `source` in the file, or that an override made.
  [[nodiscard]] Place place_of(const std::string& path, const toml::source_region& source) const;

 private:
  struct Override {
    std::string path;  ///< "body[0].velocity_m_s"; empty where it is not understood
    std::string text;  ///< as given
    [[nodiscard]] Place place(std::size_t number) const;
  };
  /// @returns what is wrong with it; empty if nothing is
  std::string apply(Override& change);
  /// The table that holds the key of a path, made where it is not there. @param problem  why there is none
  toml::table* table_for(const std::string& path, std::string& problem);
  /// Takes out what the file says of the same quantity; what another override says stays, so that the two are found to exclude each other.
  void remove_rivals(const std::string& path, toml::table& table);

  const Schema& schema_;
  const Findings& findings_;
  toml::table root_;
  std::vector<Override> overrides_;
};

}  // namespace mpm::config
