#pragma once
/// The main quantities of a finished run in a few lines of text.

#include <string>
#include <vector>

#include "libmpm/observe/results.hpp"

namespace mpm {

/// One line for each of run-up (and its highest particle), pressure height, force and overturning moment: mean, and what each +- contains;
/// then the peaks of the force. A run without a steady interval is flagged; it has no means. Empty for a run without an impact. @param
/// results  of results.json
[[nodiscard]] std::string summary_text(const Results& results);

/// What the results of a finished run warn of; each is one line. @param results  of results.json
[[nodiscard]] std::vector<std::string> result_warnings(const Results& results);

}  // namespace mpm
