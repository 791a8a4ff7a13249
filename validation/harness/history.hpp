#pragma once
/// Results of all recordings of the suite in their order: the rows that scripts/validation_history.py draws.

#include <filesystem>
#include <vector>

#include "validation/harness/case.hpp"
#include "validation/harness/run_info.hpp"

namespace mpm::validation {

/// Appends the rows of one recording to DIR/history.csv: date, commit, version, machine, threads, level, case, kind, quantity, value,
/// error, verdict. `kind` is
/// - check: `value` is the used fraction of the tolerance (check_text.hpp), `error` the error in the check's own measure, `verdict` "ok",
///   "not met" (a target that is known not to be met) or "FAILED";
/// - order: `value` is the observed order of a check that has one;
/// - time: `value` is the wall time of the case, s;
/// - bias, spread: of a quantity of the summary (`quantity` is "force, verification"), over all cases; `case` is empty. Only a recording of
///   all cases has them: those of a selection cannot be compared.
/// @throws IoError if the file has other columns
void append_history(const std::filesystem::path& directory, const std::vector<CaseResult>& results, const RunInfo& info);

}  // namespace mpm::validation
