#pragma once
/// Everything that is wrong with a file, with the place of each: collected while it is read, reported together.

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "libmpm/base/parameter_report.hpp"

namespace mpm::config {

/// Where something is; overrides come after the file.
struct Place {
  std::size_t override_number = 0;     ///< 1, 2, ... for --set
  std::uint32_t line = 1, column = 1;  ///< from 1
  std::string text;                    ///< "case.toml:3:1", "--set numerics.cfl=2"
};

/// Names are paths: "numerics.cfl", "body[0].min_m"; of an entry of a table "body[0]"; of the whole file "".
class Findings final : public ParameterReport {
 public:
  /// @param file  its name, as messages give it
  explicit Findings(std::string file);

  [[nodiscard]] bool given(const std::string& path) const override { return places_.contains(path); }
  /// Neither it nor a table that it is in has a problem of its own.
  [[nodiscard]] bool sound(const std::string& path) const override;
  /// At the place of the key; of its table, where the key is left out; at the top of the file, where the table is left out as well.
  void problem(const std::string& path, const std::string& text) override;

  /// A problem at a place that is known.
  void add(const Place& place, const std::string& text);
  /// There is such a table, or entry of a repeated one.
  void enter_table(const std::string& path, const Place& place);
  /// A key is given.
  void give_key(const std::string& path, const Place& place) { places_[path] = place; }
  /// Something is wrong with it that was reported under another name.
  void mark_unsound(const std::string& path) { unsound_.insert(path); }

  /// Both from 1.
  [[nodiscard]] Place in_file(std::uint32_t line, std::uint32_t column) const;
  /// After so many problems there is no use in reading on.
  [[nodiscard]] bool given_up() const;
  /// @throws ConfigError with all problems in the order of the file, one a line, if there is one.
  void throw_if_any();

 private:
  struct Finding {
    Place place;
    std::string text;
  };
  [[nodiscard]] const Place& place_of(const std::string& path) const;

  std::string file_;
  std::vector<Finding> findings_;
  std::map<std::string, Place> places_;  ///< of every table entry and key given
  std::set<std::string> tables_, unsound_;
};

}  // namespace mpm::config
