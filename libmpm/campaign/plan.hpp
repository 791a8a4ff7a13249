#pragma once
/// The plan of a campaign: its runs, each with its differences from the base case. plan_file.hpp reads it.

#include <filesystem>
#include <string>
#include <vector>

namespace mpm {

/// Key format_version of a plan; another version is refused.
inline constexpr int plan_format_version = 1;

inline constexpr std::size_t most_runs = 100'000;   ///< of a plan
inline constexpr std::size_t most_settings = 1000;  ///< keys that a table of a plan, or one run, sets

/// A key of a case with its value, as for --set.
struct Setting {
  std::string key;    ///< "conveyor.froude_number"
  std::string value;  ///< TOML
  bool operator==(const Setting&) const = default;
};

/// A run of the plan.
struct PlannedRun {
  std::string name;               ///< of its folder: letters, digits, '.', '_', '+', '-'
  std::vector<Setting> settings;  ///< each key once
  bool operator==(const PlannedRun&) const = default;
};

/// Resources of a Slurm task; the cluster's defaults apply to empty values.
struct SlurmSpec {
  std::string partition, account, qos;  ///< options of sbatch with these names
  std::string time_limit;               ///< in the format of sbatch: "02:00:00"
  std::string memory;                   ///< "2G"
  std::vector<std::string> options;     ///< further options of sbatch
  bool operator==(const SlurmSpec&) const = default;
};

/// A plan with its runs.
struct CampaignPlan {
  std::string file;                   ///< of the plan, for messages
  std::string title;                  ///< heading of the campaign
  std::string base_text;              ///< the base case as TOML
  std::string base_name;              ///< its place, for messages
  std::vector<PlannedRun> runs;       ///< in the order of the plan
  int ranks = 1;                      ///< of each run
  std::vector<std::string> launcher;  ///< command that starts them, with ranks_placeholder (driver/launcher.hpp); empty: the default
  int threads = 1, retries = 1;       ///< of each rank; further attempts after a failure
  bool longest_first = true;          ///< order in which runs are started: by their estimated cost, or as in the plan
  bool keep_frames = false, keep_final = false, keep_checkpoint = false;  ///< files to keep of a finished run
  std::vector<std::filesystem::path> stored_results;  ///< results.csv of earlier campaigns, whose rows need not be computed again
  SlurmSpec slurm;                                    ///< of tasks that Slurm runs
};

}  // namespace mpm
