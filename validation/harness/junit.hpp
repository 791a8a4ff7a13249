#pragma once
/// The results as JUnit XML.

#include <string>
#include <vector>

#include "validation/harness/case.hpp"
#include "validation/harness/run_info.hpp"

namespace mpm::validation {

/// JUnit XML as Ant writes it and Jenkins, GitLab and GitHub read it: a test suite a case, a test case a check (its time: an equal part of
/// the case's). Names are unique within a suite.
std::string junit_xml(const std::vector<CaseResult>& results, const RunInfo& info);

}  // namespace mpm::validation
