#pragma once
/// The folder that a run of the suite leaves. The verdicts are those of the cases; validation/README.md describes each file.

#include <filesystem>
#include <vector>

#include "validation/harness/case.hpp"
#include "validation/harness/run_info.hpp"

namespace mpm::validation {

/// Writes DIR/results.json, DIR/junit.xml, DIR/orders.csv and DIR/data/<case>-<plot>.csv (columns series, x, y).
void write_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, RunInfo info);

}  // namespace mpm::validation
