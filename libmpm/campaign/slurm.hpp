#pragma once
/// A campaign through Slurm: an array job, one task a run. A task is `mpm campaign task OUT NAME`, which goes on where an earlier one was
/// stopped, so that jobs can be requeued, cancelled and submitted again.

#include <filesystem>
#include <span>
#include <string>

#include "libmpm/campaign/plan.hpp"

namespace mpm {

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
