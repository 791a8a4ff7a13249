#pragma once
/// How a program is started as several ranks: the words before its own command line.

#include <csignal>
#include <string>
#include <vector>

namespace mpm {

inline constexpr const char* ranks_placeholder = "{ranks}";  ///< in a launcher: their number

/// Sent to a launcher, it asks the ranks for a checkpoint and an end: mpirun and srun pass it on. SIGTERM makes mpirun kill them a moment
/// later, and a longer moment (odls_base_sigkill_timeout) would be waited for as well where a rank has failed.
inline constexpr int stop_through_launcher = SIGUSR2;

/// Open MPI's, for ranks that share the cores of this machine or of this Slurm job. The ranks are not bound to cores, because several runs
/// may share a machine.
[[nodiscard]] std::vector<std::string> default_launcher();

/// The words that start `ranks` ranks; none for one rank. @param launcher  empty: default_launcher()
/// @throws ConfigError if its program is not there
[[nodiscard]] std::vector<std::string> launcher_words(int ranks, const std::vector<std::string>& launcher = {});

}  // namespace mpm
