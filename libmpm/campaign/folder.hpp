#pragma once
/// The folder of a campaign: comparison with a plan, and preparation of it and of the folders of its runs; how far the runs are, by their
/// folders, how much remains to be done, and the tables of that: results.csv and runs.csv.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"

namespace mpm {

/// Content of plan.toml: the rows that are run, with their names.
[[nodiscard]] std::string resolved_plan(const Campaign& campaign);

/// Comparison of a plan with a folder in which another plan was run.
struct Preparation {
  std::vector<std::string> adopted;   ///< runs whose finished folder has another name that is not in the plan
  std::vector<std::string> replaced;  ///< runs whose folder holds another case or duration: to be run again
  std::vector<std::string> damaged;   ///< finished runs whose results do not match their checksums: to be run again
  std::vector<std::string> dropped;   ///< folders that are not in the plan: unchanged, not in the table
};

/// Compares without changing anything.
[[nodiscard]] Preparation compare_with_folder(const std::filesystem::path& out, const Campaign& campaign);
/// Prepares the folder: writes plan.toml, removes what killed processes left, and renames the adopted folders. Results and checkpoints that
/// are in their way are kept as NAME.1.
Preparation prepare(const std::filesystem::path& out, const Campaign& campaign);

/// Prepares the folder of one run for --resume, and writes case.toml. Results and checkpoints of another case or duration are kept in the
/// folder NAME.1 (.2, ...); other files of it are removed. Call it while no process works there.
void prepare_run(const std::filesystem::path& out, const CampaignRun& run);
/// Removes the files that the plan does not keep from the folder of a finished run.
void tidy_run(const std::filesystem::path& out, const CampaignPlan& plan, const CampaignRun& run);

/// Whether the content of a folder, finished or not, belongs to this case and is not longer than it.
[[nodiscard]] bool can_go_on(const std::filesystem::path& directory, const CampaignRun& run);

/// One attempt at a run, as in attempts.json.
struct Attempt {
  std::string started, ended;    ///< UTC; ended is empty during the attempt, and if it was interrupted
  std::string host;              ///< name of the machine
  std::string outcome;           ///< done, failed, stopped; empty during the attempt, and if it was interrupted
  std::optional<int> exit_code;  ///< of the process, if it exited
  std::optional<int> signal;     ///< signal that ended the process
  std::string cause;             ///< of a failure: the last line that the run printed
  bool final = false;            ///< a failure that would repeat itself: the case is unstable
};

/// The attempts of this run (hash and duration) in attempts.json of a folder; empty if there are none.
/// @throws IoError if the file cannot be read, or is not one of this program
[[nodiscard]] std::vector<Attempt> read_attempts(const std::filesystem::path& directory, const CampaignRun& run);
/// Writes attempts.json as an atomic file (io/atomic_file.hpp). @throws IoError
void write_attempts(const std::filesystem::path& directory, const CampaignRun& run, const std::vector<Attempt>& attempts);

/// Running: the lock of the folder is held. Failed: the last attempt did, or a file is damaged.
enum class RunState { to_do, running, done, failed };
/// "to do", "running", "done", "failed"
std::string to_string(RunState);

/// The state of a run, from its folder and the tables of stored results.
struct RunStatus {
  RunState state = RunState::to_do;  ///< by its folder
  double progress = 0.0;             ///< fraction of the duration that is computed and kept: 1 where done
  bool stored = false;               ///< whether it is done by a table of stored results and has no results of its own in the folder
  Results results;                   ///< where done
  std::vector<Attempt> attempts;     ///< oldest first
  std::string damage;                ///< a file of the folder that cannot be used, and why: the run is failed, whatever its attempts were

  /// The damage, or the message of the last attempt; empty unless the run failed.
  [[nodiscard]] std::string cause() const;
  /// Whether the failure would repeat itself: the case is unstable, or a file is damaged.
  [[nodiscard]] bool hopeless() const { return state == RunState::failed && (!damage.empty() || attempts.back().final); }
};

/// Damaged files of a run are its failure, and throw nothing. @param out  folder of the campaign
[[nodiscard]] RunStatus status_of(const std::filesystem::path& out, const CampaignRun& run);
/// Of every run, in the order of the plan.
[[nodiscard]] std::vector<RunStatus> status_of(const std::filesystem::path& out, const Campaign& campaign);

/// Work and time of a campaign.
struct CampaignCost {
  double particle_steps = 0.0, left = 0.0;  ///< estimated: of all runs, and of what is not done
  double particle_steps_per_s = 0.0;        ///< of one run: measured on those that are done, else assumed
  bool measured = false;                    ///< whether the speed is
};
/// @param status  of every run, in the order of the plan
[[nodiscard]] CampaignCost cost_of(const Campaign& campaign, const std::vector<RunStatus>& status);

/// Writes results.csv and runs.csv. @param status  of every run, in the order of the plan
void write_campaign_tables(const std::filesystem::path& out, const Campaign& campaign, const std::vector<RunStatus>& status);

}  // namespace mpm
