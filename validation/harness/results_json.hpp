#pragma once
/// results.json: the results for the report script and for other programs.

#include <string>
#include <vector>

#include "validation/harness/case.hpp"
#include "validation/harness/run_info.hpp"

namespace mpm::validation {

/// Everything, for the report script and for other programs. NaN and infinity are written as null.
std::string results_json(const std::vector<CaseResult>& results, const RunInfo& info);

}  // namespace mpm::validation
