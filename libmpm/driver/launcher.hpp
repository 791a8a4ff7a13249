#pragma once
/// The command that starts a program as several ranks, to be put before the program's own command line.

#include <csignal>
#include <string>
#include <vector>

namespace mpm {

inline constexpr const char* ranks_placeholder = "{ranks}";  ///< in a launcher: replaced by the number of ranks

/// Sent to a launcher, it asks the ranks for a checkpoint and an end: mpirun and srun pass it on. After SIGTERM mpirun kills them soon;
/// a longer delay (odls_base_sigkill_timeout) would also delay the end after a rank has failed.
inline constexpr int stop_through_launcher = SIGUSR2;

/// Launcher of Open MPI, for ranks that share the cores of this machine or of this Slurm job. The ranks are not bound to cores, because
/// several runs may share a machine.
[[nodiscard]] std::vector<std::string> default_launcher();

/// The command that starts `ranks` ranks; empty for one rank. @param launcher  empty: default_launcher()
/// @throws ConfigError if its program does not exist
[[nodiscard]] std::vector<std::string> launcher_words(int ranks, const std::vector<std::string>& launcher = {});

}  // namespace mpm
