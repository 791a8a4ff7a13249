#pragma once
/// Executes the runs of a campaign: on this machine, or through Slurm.
///
/// On this machine each run has its own process, so that a crash of one does not affect the others.
/// A child is `PROGRAM run OUT/runs/NAME/case.toml --out OUT/runs/NAME --threads N --resume`, or for several ranks the launcher of that. It
/// has its own process group, so that a Ctrl-C reaches it only through this process. It gets SIGTERM (a launcher: SIGUSR2) when this
/// process ends, even by a kill; it then writes its checkpoint and ends. Until then it holds the lock of its folder, and the run is not
/// started a second time.
///
/// Through Slurm they are an array job, one task a run. A task is `mpm campaign task OUT NAME`, which goes on where an earlier one was
/// stopped, so that jobs can be requeued, cancelled and submitted again.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"
#include "libmpm/campaign/plan.hpp"
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
  std::size_t failed = 0;  ///< in this call, after all retries
};

/// Executes the incomplete runs, in the plan's order or the longest first by estimate, at most `jobs` at a time. A folder in which another
/// process works is postponed. A run that failed is tried again up to plan.retries times, unless it would fail again (exit
/// code 2: the program refused it here and now; 3: unstable, which would repeat itself); attempts.json records the cause of every failure.
/// @param runs  of the campaign, by index
/// @throws IoError if a folder cannot be written or a process cannot be started; ConfigError if the launcher does not exist
ExecutionReport execute(const Campaign& campaign, const std::vector<std::size_t>& runs, const ExecutionOptions& options);

/// Number of simultaneous runs that use all cores of this machine, given the plan's ranks and threads; at least 1.
[[nodiscard]] int default_jobs(const CampaignPlan& plan);

/// @throws ConfigError if the `jobs` largest runs together do not fit into limit_bytes
void require_memory(const Campaign& campaign, int jobs, double limit_bytes);

/// Files of one array job, in OUT/slurm.
struct SlurmJob {
  std::filesystem::path script;  ///< what sbatch is given
  std::filesystem::path tasks;   ///< names of the runs, one a line: line k is task k
};

/// Writes script and list under names that no job before had. @param at_once  tasks that run at the same time at most; 0: no limit
/// @throws IoError, ConfigError for a control character in a name, path or option
[[nodiscard]] SlurmJob write_slurm_job(const CampaignPlan& plan, const std::string& job_name, std::span<const std::string> names,
                                       const std::filesystem::path& out, const std::filesystem::path& program, int at_once);

/// Calls sbatch. @param wait return when the job has ended. @return the job's number
/// @throws IoError if there is no sbatch, or it refuses the job: its message
std::string submit_slurm_job(const SlurmJob& job, bool wait);

}  // namespace mpm
