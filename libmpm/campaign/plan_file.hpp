#pragma once
/// Plan files of campaigns: TOML in, one row a run out. campaign.hpp makes cases from the rows.
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
#include <string>
#include <string_view>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/plan.hpp"

namespace mpm {

/// Reads a plan and expands it. @throws ConfigError with all problems at once, `file:line:column: [table] what, value, remedy`; IoError
[[nodiscard]] CampaignPlan read_plan(const std::filesystem::path& file);
/// The same from memory. @param file its name in messages, and its folder, to which other files are relative
[[nodiscard]] CampaignPlan parse_plan(std::string_view text, const std::filesystem::path& file);

/// The plan with its base inside and one [[run]] a run: reads back to the same cases and names, in the same order.
[[nodiscard]] std::string write_plan(const CampaignPlan& plan);

}  // namespace mpm
