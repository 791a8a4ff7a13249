#pragma once
/// Runs the runs of a campaign, each in a process of its own: one that crashes takes no other with it.
///
/// A child is `PROGRAM run OUT/runs/NAME/case.toml --out OUT/runs/NAME --threads N --resume`, or for several ranks the launcher of that. It
/// has a process group of its own, so that a Ctrl-C reaches it through this process alone, and gets SIGTERM (a launcher: SIGUSR2) when this
/// process dies, however it dies: it writes its checkpoint and ends. Until then it holds the lock of its folder, and the run is not started
/// a second time.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"
#include "libmpm/driver/run.hpp"

namespace mpm {

/// How the runs of a campaign are executed.
struct ExecutionOptions {
  std::filesystem::path out;      ///< folder of the campaign
  std::filesystem::path program;  ///< the `mpm` that is called
  int jobs = 1;                   ///< runs at a time
  bool retry_failed = false;      ///< also those whose failure would repeat itself
  /// Asked some times a second: checkpoint and stop are handed on to the children.
  std::function<Request()> poll;
  std::function<void(const std::string&)> say;  ///< a line for the user
  std::function<void()> on_change;              ///< after a run has ended
};

/// What one call did.
struct ExecutionReport {
  bool finished = false;   ///< false: stopped on request
  std::size_t done = 0;    ///< in this call
  std::size_t failed = 0;  ///< in this call, after all retries
};

/// Runs what is not done, in the plan's order or the longest first by its estimate, at most `jobs` at a time. A folder in which another
/// process works is left for later. A run that failed is tried again up to plan.retries times, unless its failure would repeat itself (exit
/// code 2: the case is invalid; 3: unstable); the cause of every failure is kept in attempts.json.
/// @param runs  of the campaign, by index
/// @throws IoError if a folder cannot be written or a process cannot be started; ConfigError if the launcher is not there
ExecutionReport execute(const Campaign& campaign, const std::vector<std::size_t>& runs, const ExecutionOptions& options);

/// Runs at a time that fill the cores of this machine with the plan's ranks and threads; at least 1.
[[nodiscard]] int default_jobs(const CampaignPlan& plan);

/// @throws ConfigError if the `jobs` largest runs together do not fit into limit_bytes
void require_memory(const Campaign& campaign, int jobs, double limit_bytes);

}  // namespace mpm
