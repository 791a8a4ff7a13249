#pragma once
/// Executes the runs of a campaign, each in its own process, so that a crash of one does not affect the others.
///
/// A child is `PROGRAM run OUT/runs/NAME/case.toml --out OUT/runs/NAME --threads N --resume`, or for several ranks the launcher of that. It
/// has its own process group, so that a Ctrl-C reaches it only through this process. It gets SIGTERM (a launcher: SIGUSR2) when this
/// process ends, even by a kill; it then writes its checkpoint and ends. Until then it holds the lock of its folder, and the run is not
/// started a second time.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"
#include "libmpm/driver/run.hpp"

namespace mpm {

/// Options of the execution of a campaign.
struct ExecutionOptions {
  std::filesystem::path out;      ///< folder of the campaign
  std::filesystem::path program;  ///< path of `mpm`
  int jobs = 1;                   ///< runs at a time
  bool retry_failed = false;      ///< repeat also failures that will recur
  /// Called several times a second; requests for a checkpoint or a stop are passed on to the children.
  std::function<Request()> poll;
  std::function<void(const std::string&)> say;  ///< prints a message
  std::function<void()> on_change;              ///< called after a run has ended
};

/// Outcome of one call.
struct ExecutionReport {
  bool finished = false;   ///< false: stopped on request
  std::size_t done = 0;    ///< in this call
  std::size_t failed = 0;  ///< in this call, after all retries
};

/// Executes the incomplete runs, in the plan's order or the longest first by estimate, at most `jobs` at a time. A folder in which another
/// process works is postponed. A run that failed is tried again up to plan.retries times, unless it would fail again (exit
/// code 2: the case is invalid; 3: unstable); attempts.json records the cause of every failure.
/// @param runs  of the campaign, by index
/// @throws IoError if a folder cannot be written or a process cannot be started; ConfigError if the launcher does not exist
ExecutionReport execute(const Campaign& campaign, const std::vector<std::size_t>& runs, const ExecutionOptions& options);

/// Number of simultaneous runs that use all cores of this machine, given the plan's ranks and threads; at least 1.
[[nodiscard]] int default_jobs(const CampaignPlan& plan);

/// @throws ConfigError if the `jobs` largest runs together do not fit into limit_bytes
void require_memory(const Campaign& campaign, int jobs, double limit_bytes);

}  // namespace mpm
