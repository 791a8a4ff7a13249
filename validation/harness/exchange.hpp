#pragma once
/// Validation cases for other solvers: a case is written as plain data, and the case's own checks evaluate the results of a solver.
/// The format is described in docs/other-solvers.md.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "validation/harness/case.hpp"
#include "validation/harness/setup.hpp"

namespace mpm::validation {

/// Version of the format of case.json.
inline constexpr int exchange_format_version = 1;

/// Whether the case has set-ups, so that it can be exported and graded.
bool can_be_exported(const CaseEntry& entry);

/// Writes all runs of a case below `directory`: case.json, and for each run its folder with particles.csv, particles.h5 (the same numbers)
/// and case.toml (for `mpm run`; without what the case does beyond a case file).
/// @throws ConfigError if the case has no set-ups, IoError
void export_case(const CaseEntry& entry, const CaseContext& context, const std::filesystem::path& directory);

/// Makes the runs of a case with this program and writes their results as another solver would: an example of the input of grade, and a
/// test that the exchange loses nothing.
/// @throws as export_case
void export_results(const CaseEntry& entry, const CaseContext& context, const std::filesystem::path& directory);

/// Description of another solver in solver.json; all entries are optional.
struct ForeignSolver {
  std::string name = "another solver", version, remark;
};

/// The results that another solver wrote.
class ForeignResults : public RunSource {
 public:
  /// Checks which files exist, before anything is evaluated.
  /// @throws IoError naming every file and column that is missing, one a line; ConfigError if they belong to another level or case
  ForeignResults(std::filesystem::path directory, const CaseEntry& entry, const CaseContext& context);

  RunCost play(const Setup& setup, const Visitor& visit) const override;

  [[nodiscard]] const ForeignSolver& solver() const { return solver_; }
  /// Missing or damaged parts of the results; empty if there were none.
  [[nodiscard]] const std::string& damage() const { return damage_; }
  /// How many numbers that a case read were NaN or infinite: it fails, even where its checks see the other numbers only.
  [[nodiscard]] std::size_t not_finite() const { return not_finite_; }

 private:
  void read_solver();
  std::filesystem::path directory_;
  ForeignSolver solver_;
  mutable std::string damage_;
  mutable std::size_t not_finite_ = 0;
};

}  // namespace mpm::validation
