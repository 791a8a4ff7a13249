#pragma once
/// Names of runs, which are names of folders, made from the keys that vary: fr3_m0.4.

#include <map>
#include <string>
#include <vector>

#include "libmpm/campaign/plan.hpp"

namespace mpm {

/// Short names of the common keys: fr for conveyor.froude_number. An empty one leaves only the value.
[[nodiscard]] const std::map<std::string, std::string>& common_labels();

/// The text with other characters than letters, digits and . _ + - replaced by one '-'.
[[nodiscard]] std::string file_name_part(const std::string& text);

/// Every name of a run, given or made, is checked with this: names become folders, and words of a command line.
/// @return why a text names no folder, with the text and the remedy; empty for a name of at most 200 letters, digits and . _ + - that does
/// not begin with '.' or '-'
[[nodiscard]] std::string name_problem(const std::string& name);

/// Name of a run, or its part that tells of these settings, in which the run differs from others.
[[nodiscard]] std::string run_name(const std::vector<Setting>& varied, const std::map<std::string, std::string>& labels);

}  // namespace mpm
