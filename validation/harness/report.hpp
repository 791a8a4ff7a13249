#pragma once
/// What a run of the suite leaves: tables, results.json, JUnit XML, plot data, and the recorded table of orders and errors. The verdicts
/// are those of the cases. What each file holds is said in validation/README.md.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "validation/harness/case.hpp"

namespace mpm::validation {

/// Which run this was.
struct RunInfo {
  Level level = Level::quick;
  std::string command;  ///< as typed
  std::string machine;  ///< processor and number of threads the machine offers
  std::string started;  ///< ISO 8601, UTC
  int threads = 1;
  double wall_time_s = 0.0;
  std::filesystem::path directory;  ///< of the report; set by write_results
};

/// Numbers as the table prints them: four significant digits, short exponents.
std::string format_value(double value);
/// Error or tolerance of a check with its unit: '0.3 %' or '1.2e-4 m'.
std::string format_error(const Check& check, double error);

/// Share of its tolerance that a check uses: |error| / tolerance, and value / bound for a bound without slack. At most 1 for a check that
/// holds, above for one that does not; infinite where nothing is permitted and something is there, or where a number is NaN.
double tolerance_used(const Check& check);
/// The check that uses most of its tolerance; null if the case has none.
const Check* tightest_check(const CaseResult& result);

/// Wall time that all cases of a level together may take on two idle cores, s; none for full.
std::optional<double> time_budget(Level level);

/// case | label | quantity | reference | result | error | order | tolerance | verdict | time, a row a check. Failing cases first, and in
/// them failing checks.
std::string check_table(const std::vector<CaseResult>& results);
/// case | label | checks | the check that uses most of its tolerance | used | verdict | time | share of the total. Failing cases first,
/// then the time against the budget, the failing cases by name, and as last line 'N passed, N failed': checks, a case that threw counting
/// as one.
std::string case_table(const std::vector<CaseResult>& results, const RunInfo& info);

/// JUnit XML as Ant writes it and Jenkins, GitLab and GitHub read it: a test suite a case, a test case a check (its time: an equal share of
/// the case's). Names are unique within a suite.
std::string junit_xml(const std::vector<CaseResult>& results, const RunInfo& info);

/// Everything, for the report script and for other programs. NaN and infinity are written as null.
std::string results_json(const std::vector<CaseResult>& results, const RunInfo& info);

/// The table of orders and errors: case, quantity, label, reference, result, error, order, tolerance, verdict, measure, unit; a row a
/// check, cases by name.
std::string orders_csv(const std::vector<CaseResult>& results);

/// Writes DIR/results.json, DIR/junit.xml, DIR/orders.csv and DIR/data/<case>-<plot>.csv (columns series, x, y).
void write_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, RunInfo info);

/// Keeps the table of orders and errors in a directory of reference_data: data.csv (orders_csv and the level in front), runs.csv (level,
/// case, checks, time, commit, machine of each) and SOURCE.md. Rows of the same level and case are replaced, others stay.
/// @throws IoError
void record_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, const RunInfo& info);

/// What record_results kept about a case: its labels and the time it took.
struct RecordedCase {
  std::string level, name, labels;
  double wall_time_s = 0.0;
};
/// Rows of DIR/runs.csv; none if there is no such file. @throws IoError if it is damaged
std::vector<RecordedCase> recorded_cases(const std::filesystem::path& directory);

/// Processor model and number of threads of this machine.
std::string describe_machine();

}  // namespace mpm::validation
