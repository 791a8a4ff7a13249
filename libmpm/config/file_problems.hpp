#pragma once
/// The errors of a file with their positions: collected while it is read, reported together.

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "libmpm/base/parameter.hpp"

namespace mpm::config {

/// Number of errors after which reading stops, and number of errors that are shown.
/// @{
inline constexpr std::size_t most_problems = 1000, problems_shown = 200;
/// @}

/// A position in the file, or in what comes after it: the overrides, or the files that it includes.
struct FilePosition {
  std::size_t source_number = 0;       ///< 0: the file; 1, 2, ... for --set, or for included files
  std::uint32_t line = 1, column = 1;  ///< from 1
  std::string text;                    ///< "case.toml:3:1", "--set numerics.cfl=2"
};

/// Names are paths: "numerics.cfl", "body[0].min_m"; of an entry of a table "body[0]"; of the whole file "".
class FileProblems final : public ParameterReport {
 public:
  /// @param file  its name in messages
  explicit FileProblems(std::string file);

  [[nodiscard]] bool given(const std::string& path) const override { return places_.contains(path); }
  /// Whether neither the name nor a table that contains it has an error.
  [[nodiscard]] bool valid(const std::string& path) const override;
  /// Reports an error at the key; if it is left out, at its table; if that is left out, at the top of the file.
  void problem(const std::string& path, const std::string& text) override;

  /// Reports an error at a known position.
  void add(const FilePosition& place, const std::string& text);
  /// Records that the file has a table, or an entry of a repeated one.
  void enter_table(const std::string& path, const FilePosition& place);
  /// Records that a key is given.
  void give_key(const std::string& path, const FilePosition& place) { places_[path] = place; }
  /// Records that a name has an error that was reported under another name.
  void mark_invalid(const std::string& path) { invalid_.insert(path); }

  /// Both from 1.
  [[nodiscard]] FilePosition in_file(std::uint32_t line, std::uint32_t column) const;
  /// Whether there are errors.
  [[nodiscard]] bool any() const { return !problems_.empty(); }
  /// Whether there are so many errors that reading should stop.
  [[nodiscard]] bool given_up() const;
  /// @throws ConfigError with all errors in the order of the file, one on each line, if there are any
  void throw_if_any();

 private:
  struct Problem {
    FilePosition place;
    std::string text;
  };
  [[nodiscard]] const FilePosition& position_of(const std::string& path) const;

  std::string file_;
  std::vector<Problem> problems_;
  std::map<std::string, FilePosition> places_;  ///< of every table entry and key given
  std::set<std::string> tables_, invalid_;
};

}  // namespace mpm::config
