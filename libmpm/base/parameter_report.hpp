#pragma once
/// Interface with which components report errors of their parameters.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace mpm {

/// Receives the errors that a component finds in its parameters. Names are those of one table ("cfl"), or paths ("numerics.cfl", or a whole
/// table "numerics") where a check spans several tables.
class ParameterReport {
 public:
  virtual ~ParameterReport() = default;
  /// Whether a parameter was given, as opposed to left at its default.
  [[nodiscard]] virtual bool given(const std::string& name) const = 0;
  /// Whether no error is known of a parameter. A check that combines parameters needs all of them to be valid.
  [[nodiscard]] virtual bool sound(const std::string& name) const = 0;
  /// @param text  continues a sentence that begins with the name: "= 3 is above ..., give at most 2"; of a table: with its brackets, and of
  ///              the whole file (an empty name): a sentence of its own
  virtual void problem(const std::string& name, const std::string& text) = 0;

  /// Whether no error is known of any of these parameters.
  [[nodiscard]] bool all_sound(const std::vector<std::string>& names) const {
    return std::all_of(names.begin(), names.end(), [&](const std::string& name) { return sound(name); });
  }
};

/// The report of one table (or of one entry of a repeated table) as a part of a larger one.
class TableReport final : public ParameterReport {
 public:
  /// @param all    report of the whole file; must outlive this one @param table  path of the table or entry
  /// ("body[0]"); empty: none
  TableReport(ParameterReport& all, std::string table) : all_(all), table_(std::move(table)) {}
  [[nodiscard]] bool given(const std::string& name) const override { return all_.given(path(name)); }
  [[nodiscard]] bool sound(const std::string& name) const override { return all_.sound(path(name)); }
  void problem(const std::string& name, const std::string& text) override { all_.problem(path(name), text); }

 private:
  [[nodiscard]] std::string path(const std::string& name) const {
    return table_.empty() ? name : name.empty() ? table_ : table_ + "." + name;
  }
  ParameterReport& all_;
  std::string table_;
};

}  // namespace mpm
