#pragma once
/// The main quantities of a finished run in a few lines, for a person.

#include <string>

#include "libmpm/observe/column.hpp"

namespace mpm {

/// One line for each of run-up, pressure height, force and overturning moment: mean, and what each +- contains; then the peaks of the
/// force. Empty for a run that is no impact. Without a steady interval it says so. @param results  of results.json
[[nodiscard]] std::string summary_text(const Results& results);

}  // namespace mpm
