#pragma once
/// What a run of the suite leaves: the table, results.json, JUnit XML, plot data. The verdicts are those of the cases.

#include <filesystem>
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

/// case | label | quantity | reference | result | error | order | tolerance | verdict | time. Failing cases first; last line 'N passed, N
/// failed' counts checks, a case that threw counting as one failed check.
std::string summary_table(const std::vector<CaseResult>& results);

/// JUnit XML: a test suite a case, a test case a check.
std::string junit_xml(const std::vector<CaseResult>& results, const RunInfo& info);

/// Everything, for the report script and for other programs. NaN and infinity are written as null.
std::string results_json(const std::vector<CaseResult>& results, const RunInfo& info);

/// Writes DIR/results.json, DIR/junit.xml and DIR/data/<case>-<plot>.csv (columns series, x, y).
void write_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, RunInfo info);

/// Processor model and number of threads of this machine.
std::string describe_machine();

}  // namespace mpm::validation
