#pragma once
/// Result tables of many runs (results.csv of a campaign), as the evaluations of the study need them.

#include <cstddef>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace mpm {

/// One run of a table. Heights are steady means, NaN where there is none.
struct StudyRun {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::filesystem::path folder;  ///< of the run; empty where the table names none
  double froude = none;
  double critical_state_slope = none, cohesion_beta = none;  ///< M, beta; NaN where the table gives M' alone
  double effective_friction = none;                          ///< M'
  double hardening_xi = none;
  double flow_height = none, obstacle_width = none;  ///< H, w, m
  double velocity = none, gravity = none;            ///< v, m/s; g, m/s^2
  /// Over H.
  double runup = none, runup_error = none, runup_peak = none;
  double pressure_height = none, pressure_height_error = none, pressure_height_peak = none;
  double compaction = none;  ///< density at the mast's front face over rho_0, steady mean

  [[nodiscard]] double relative_width() const { return obstacle_width / flow_height; }
  /// w = H, the set-up of Eqs. 7-10.
  [[nodiscard]] bool reference_width() const;
};

/// Equality of inputs that passed through decimal text or another quantity: to 1e-6 of themselves, or of 1.
[[nodiscard]] bool same_input(double a, double b);

/// A condition on a column, `column OP value[,value...]` with OP one of = != < <= > >=: hardening_xi=0.5,5 keeps rows with either. Cells
/// are compared as numbers where both are numbers, else as text (= and != only).
class RowFilter {
 public:
  /// @throws ConfigError for text that is no condition
  explicit RowFilter(std::string text);
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] const std::string& column() const { return column_; }
  /// @throws ConfigError for an order (< or >) of what is no number
  [[nodiscard]] bool keeps(const std::string& cell) const;

 private:
  std::string text_, column_, operator_;
  std::vector<std::string> values_;
};

struct StudyTable {
  std::vector<StudyRun> runs;                                 ///< with a steady mean of the run-up
  std::size_t rows = 0;                                       ///< of the files
  std::vector<std::pair<std::string, std::size_t>> left_out;  ///< reason, rows
  std::vector<std::string> cautions;                          ///< what varies and should not, for one equation to be fitted to all
  std::vector<std::string> files;                             ///< the tables, as they were named
  /// Comment lines of the files without their '#'; which program computed the runs, and how (runs.csv of a campaign beside the table).
  std::vector<std::string> provenance;
};

/// Reads tables and puts their rows together. A column is found by its name (`hardening_xi`), else by the one name that ends in it
/// (`material.hardening_xi`). Needed: froude_number or velocity_m_s; effective_friction, or critical_state_slope and cohesion_beta;
/// hardening_xi; flow_height_m; runup_mean_m; pressure_height_mean_m. Used where there: run or name (folder beside the table),
/// obstacle.width_m or obstacle_width_m (without it w = H is taken), gravity_m_s2, the heights' standard errors and peaks, compaction_mean,
/// steady, status.
/// @throws IoError for a file that cannot be read or lacks a column, ConfigError for a filter on a column that is not there
[[nodiscard]] StudyTable read_study_table(std::span<const std::filesystem::path> files, std::span<const RowFilter> filters = {});

}  // namespace mpm
