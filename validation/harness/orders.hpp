#pragma once
/// The table of orders and errors: of one run, and as stored in reference_data.

#include <filesystem>
#include <string>
#include <vector>

#include "validation/harness/case.hpp"
#include "validation/harness/run_info.hpp"

namespace mpm::validation {

/// The table of orders and errors: case, quantity, label, reference, result, error, order, tolerance, verdict, measure, unit, bound and
/// cause of a known miss; a row a check, cases by name.
std::string orders_csv(const std::vector<CaseResult>& results);

/// Stores the table of orders and errors in a directory of reference_data: data.csv (orders_csv and the level in front), runs.csv (level,
/// case, checks, time, commit, machine of each) and SOURCE.md. Rows of the same level and case are replaced, others stay. history.csv gets
/// the rows of this recording after those of earlier ones (harness/history.hpp).
/// @throws IoError
void record_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, const RunInfo& info);

/// Labels and time of a case, as stored by record_results.
struct RecordedCase {
  std::string level, name, labels;
  double wall_time_s = 0.0;
};
/// Rows of DIR/runs.csv; none if there is no such file. @throws IoError if it is damaged
std::vector<RecordedCase> recorded_cases(const std::filesystem::path& directory);

}  // namespace mpm::validation
