#pragma once
/// The plan of a campaign: TOML in, one row a run out, each with its differences from the base case; and the names of runs, which are names
/// of folders. campaign.hpp makes cases from the rows.
///
///   include = ["shared.toml"]                     # files whose content is part of the plan, relative to it; the plan's own keys win
///   title = "Run-up on a mast"
///   base = "../examples/avalanche_fr3.toml"       # a case file, relative to the plan; or [base.material], [base.conveyor] ...
///   ranks = 1                                     # processes of each run, by MPI
///   launcher = ["mpirun", "-np", "{ranks}"]       # command that starts them; by default Open MPI's mpirun with suitable options
///   threads = 1                                   # of each rank
///   retries = 1                                   # of a run whose failure may not recur
///   keep = ["frames", "final", "checkpoint"]      # files that are kept of a finished run besides its results; none by default
///   order = "longest_first"                       # or "plan": in which order runs are started
///   table = "rows.csv"                            # explicit runs: a column for each key, and perhaps `name`
///   stored_results = ["earlier/results.csv"]      # tables of earlier campaigns: runs that they hold are not computed again
///   [set]                                         # keys as of --set, for all runs
///   "numerics.cell_size_m" = 0.35
///   [[when]]                                      # keys for the runs that have certain values
///   match = { "conveyor.froude_number" = [0.1, 0.3] }
///   set = { "output.duration_s" = 60 }
///   [parameters]                                  # lists to cross, the last varies fastest; keys joined by commas go together
///   "conveyor.froude_number" = [1, 3]
///   "material.critical_state_slope, material.cohesion_beta" = [[0.4, 0], [0.8, 0.3]]
///   "numerics.cell_size_m" = "grids"              # the values of a list
///   [lists]                                       # lists of values, or tables of groups of settings, which give runs their name
///   grids = [0.35, 0.25]
///   [[grid]]                                      # further crossings, with their own set, when, and a name that begins their runs' names
///   [[run]]                                       # explicit runs: set, and perhaps a name
///   [labels]                                      # how keys are called in the names of runs
///   "conveyor.froude_number" = "fr"
///   [slurm]                                       # partition, account, qos, time_limit, memory, options = ["--constraint=..."]
///
/// Later ones override earlier ones: base, set, when, the block's set, its when, its parameters. Frames are written only if they are kept.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace mpm {

/// Key format_version of a plan; another version is refused.
inline constexpr int plan_format_version = 1;

inline constexpr const char* ranks_placeholder = "{ranks}";  ///< in a launcher: replaced by the number of ranks

inline constexpr std::size_t most_runs = 100'000;   ///< of a plan
inline constexpr std::size_t most_settings = 1000;  ///< keys that a table of a plan, or one run, sets

/// A key of a case with its value, as for --set.
struct Setting {
  std::string key;    ///< "conveyor.froude_number"
  std::string value;  ///< TOML
  bool operator==(const Setting&) const = default;
};

/// Settings with a name.
struct NamedSettings {
  std::string name;               ///< of a run: of its folder
  std::vector<Setting> settings;  ///< each key once
  bool operator==(const NamedSettings&) const = default;
};
using PlannedRun = NamedSettings;  ///< a run of the plan

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
  std::vector<std::string> launcher;  ///< command that starts them, with ranks_placeholder; empty: Open MPI's mpirun
  int threads = 1, retries = 1;       ///< of each rank; further attempts after a failure
  bool longest_first = true;          ///< order in which runs are started: by their estimated cost, or as in the plan
  bool keep_frames = false, keep_final = false, keep_checkpoint = false;  ///< files to keep of a finished run
  std::vector<std::filesystem::path> stored_results;  ///< results.csv of earlier campaigns, whose rows need not be computed again
  SlurmSpec slurm;                                    ///< of tasks that Slurm runs
};

/// Reads a plan and expands it. @throws ConfigError with all problems at once, `file:line:column: [table] what, value, remedy`; IoError
[[nodiscard]] CampaignPlan read_plan(const std::filesystem::path& file);
/// The same from memory. @param file its name in messages, and its folder, to which other files are relative
[[nodiscard]] CampaignPlan parse_plan(std::string_view text, const std::filesystem::path& file);

/// The plan with its base inside and one [[run]] a run: reads back to the same cases and names, in the same order.
[[nodiscard]] std::string write_plan(const CampaignPlan& plan);

// Names of runs, made from the keys that vary: fr3_m0.4.

/// Short names of the common keys: fr for conveyor.froude_number. An empty one leaves only the value.
[[nodiscard]] const std::map<std::string, std::string>& common_labels();

/// The text with other characters than letters, digits and . _ + - replaced by one '-'.
[[nodiscard]] std::string file_name_part(const std::string& text);

/// Every name of a run, given or made, is checked with this: names become folders, and words of a command line.
/// @return why a text names no folder, with the text and the remedy; empty for a name of at most 200 letters, digits and . _ + - that does
/// not begin with '.' or '-'
[[nodiscard]] std::string name_problem(const std::string& name);

}  // namespace mpm
