#pragma once
/// How a program is started as several ranks: the words before its own command line.

#include <string>
#include <vector>

namespace mpm {

inline constexpr const char* ranks_placeholder = "{ranks}";  ///< in a launcher: their number

/// Open MPI's, for ranks that share the cores of this machine or of this Slurm job. The ranks are not bound to cores, because several runs
/// may share a machine. A rank that is asked to end has as long as it needs for its checkpoint.
[[nodiscard]] std::vector<std::string> default_launcher();

/// The words that start `ranks` ranks; none for one rank. @param launcher  empty: default_launcher()
/// @throws ConfigError if its program is not there
[[nodiscard]] std::vector<std::string> launcher_words(int ranks, const std::vector<std::string>& launcher = {});

}  // namespace mpm
