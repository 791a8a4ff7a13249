#pragma once
/// A campaign: many runs of a plan in one folder, resumable, with one table of everything.
///
///   OUT/plan.toml       the plan as resolved: base and every run
///   OUT/runs/NAME/      what `mpm run` leaves, and attempts.json: who ran it when, and how that ended
///   OUT/results.csv     a row a run in the order of the plan: inputs that vary, derived figures, figures of results.json. The same bytes
///                       whatever the order of completion, the executor or the interruptions
///   OUT/runs.csv        what differs from one execution to the next: times, speed, memory, attempts
///
/// What is there is judged by the folders alone, so that any process on any machine sees the same: done is a results.json of the same case
/// hash and duration, running is a folder whose lock is held.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mpm/case.hpp"
#include "mpm/estimate.hpp"
#include "mpm/io/campaign_plan.hpp"

namespace mpm {

/// A run of the plan with what it computes and what it will cost.
struct CampaignRun {
  std::string name;
  std::vector<Setting> settings;
  Case spec;
  std::string case_hash;
  Estimate cost;
};

struct Campaign {
  CampaignPlan plan;
  std::vector<CampaignRun> runs;  ///< in the order of the plan, each case once
  std::size_t duplicates = 0;     ///< rows of the plan left out because an earlier one is the same case over the same time
};

/// The cases of a plan. @throws ConfigError with every fault of every case, and for names that two cases share
[[nodiscard]] Campaign make_campaign(CampaignPlan plan);

/// Folder of a run.
[[nodiscard]] std::filesystem::path run_directory(const std::filesystem::path& out, const CampaignRun& run);

/// One go at a run, as attempts.json keeps it.
struct Attempt {
  std::string started, ended;  ///< UTC; ended is empty while it lasts, and where it was cut off
  std::string host;
  std::string outcome;           ///< done, failed, stopped; empty while it lasts, and where it was cut off
  std::optional<int> exit_code;  ///< of the process, if it ended by itself
  std::optional<int> signal;     ///< that ended it
  std::string cause;             ///< of a failure: what the run said last
  bool final = false;            ///< a failure that would repeat itself: the case is at fault, or unstable
};

/// attempts.json of a folder, if it belongs to this run (hash and duration); empty otherwise.
[[nodiscard]] std::vector<Attempt> read_attempts(const std::filesystem::path& directory, const CampaignRun& run);
void write_attempts(const std::filesystem::path& directory, const CampaignRun& run, const std::vector<Attempt>& attempts);

enum class RunState { to_do, running, done, failed };
std::string to_string(RunState);

/// What the folder of a run says.
struct RunStatus {
  RunState state = RunState::to_do;
  double progress = 0.0;  ///< share of the duration that is computed and kept: 1 where done
  std::string results;    ///< content of results.json where done
  std::vector<Attempt> attempts;

  /// What the last attempt said; empty unless the run failed.
  [[nodiscard]] std::string cause() const;
};

[[nodiscard]] RunStatus status_of(const std::filesystem::path& out, const CampaignRun& run);
[[nodiscard]] std::vector<RunStatus> status_of(const std::filesystem::path& out, const Campaign& campaign);

/// Content of plan.toml: the rows that are run, under the names they have.
[[nodiscard]] std::string resolved_plan(const Campaign& campaign);

/// What a plan has in common with a folder that another plan was run in.
struct Preparation {
  std::vector<std::string> adopted;   ///< runs whose finished folder had another name, which the plan no longer has
  std::vector<std::string> replaced;  ///< runs that are in the folder as another case: to be run again
  std::vector<std::string> dropped;   ///< folders that the plan does not name: left alone, not in the table
};

/// Compares, and changes nothing.
[[nodiscard]] Preparation compare_with_folder(const std::filesystem::path& out, const Campaign& campaign);
/// Makes the folder ready: writes plan.toml, and renames what can be adopted.
Preparation prepare(const std::filesystem::path& out, const Campaign& campaign);

/// Makes the folder of one run ready to be run with --resume: empties it of what another case, or a longer run, left there, and writes
/// case.toml. Call with nobody working in it.
void prepare_run(const std::filesystem::path& out, const CampaignRun& run);
/// Removes from the folder of a finished run what the plan does not keep.
void tidy_run(const std::filesystem::path& out, const CampaignPlan& plan, const CampaignRun& run);

/// Writes results.csv and runs.csv.
void write_campaign_tables(const std::filesystem::path& out, const Campaign& campaign, const std::vector<RunStatus>& status);

/// Work and time of a campaign.
struct CampaignCost {
  double particle_steps = 0.0, left = 0.0;  ///< estimated: of all runs, and of what is not done
  double particle_steps_per_s = 0.0;        ///< of one run: measured on those that are done, else assumed
  bool measured = false;
};
[[nodiscard]] CampaignCost cost_of(const Campaign& campaign, const std::vector<RunStatus>& status);

}  // namespace mpm
