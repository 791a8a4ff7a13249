#pragma once
/// Tables of checks and cases for the terminal.

#include <string>
#include <vector>

#include "validation/harness/case.hpp"
#include "validation/harness/run_info.hpp"

namespace mpm::validation {

/// case | label | quantity | reference | result | error | order | tolerance | verdict | time, a row a check. Failing cases first, and in
/// them failing checks.
std::string check_table(const std::vector<CaseResult>& results);
/// case | label | checks | the check that uses most of its tolerance | used | verdict | time | part of the total. Failing cases first,
/// then the time against the budget, the failing cases by name, and as last line 'N passed, N failed': checks, a case that threw counting
/// as one.
std::string case_table(const std::vector<CaseResult>& results, const RunInfo& info);

}  // namespace mpm::validation
