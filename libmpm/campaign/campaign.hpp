#pragma once
/// A campaign: many runs of a plan in one folder, resumable, with one table of everything.
///
///   OUT/plan.toml       the plan as resolved: base and every run
///   OUT/runs/NAME/      files of `mpm run`, and attempts.json: machine, time and outcome of each attempt
///   OUT/results.csv     a row a run in the order of the plan: inputs that vary, derived quantities, metrics of results.json. The bytes
///                       do not depend on order of completion, executor or interruptions
///   OUT/runs.csv        values that differ between executions: times, speed, memory, attempts
///
/// The state follows from the folders and the plan alone, so that it is the same for any process on any machine: a run is complete if it
/// has a results.json of the same case hash and duration, or a row in a table of the plan's stored results; it is running if the lock of
/// its folder is held.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/campaign/plan.hpp"
#include "libmpm/driver/case.hpp"
#include "libmpm/driver/estimate.hpp"
#include "libmpm/observe/results.hpp"

namespace mpm {

/// A run of the plan with its case and its estimated cost.
struct CampaignRun : PlannedRun {
  Case spec;                              ///< resolved
  std::string case_hash;                  ///< case_hash_text of driver/case_file.hpp
  Estimate cost;                          ///< estimated
  std::optional<Results> stored_results;  ///< from a table of an earlier campaign
};

/// An input of a run, whether it varies in the campaign or not: a column of every table of impacts.
struct RunInput {
  const char* column;  ///< its heading
  const char* key;     ///< of the case file, if the column shows one
  double value;        ///< NaN if the case has no such input
};
/// The inputs in the order of the table.
[[nodiscard]] std::vector<RunInput> inputs_of(const Case& c);

/// A plan whose runs are valid cases.
struct Campaign {
  CampaignPlan plan;              ///< as it was read
  std::vector<CampaignRun> runs;  ///< in the order of the plan, each case once
  std::size_t duplicates = 0;     ///< rows of the plan left out because an earlier one is the same case over the same time
  std::size_t unused_rows = 0;    ///< finished runs in the tables of stored results that are of no run of the plan
};

/// The cases of a plan. @throws ConfigError with every error of every case, and if two cases have one name; IoError for a faulty table of
/// stored results
[[nodiscard]] Campaign make_campaign(CampaignPlan plan);

/// The runs as JSON: {"title", "base": the tables of the base case, "runs": [{"name", "case_hash", "stored", "settings": {"table.key":
/// value}}], "unused_rows"}. A run is its settings over the base; it is stored if it has a row of stored results.
[[nodiscard]] std::string expansion_json(const Campaign& campaign);

/// Folder of a run.
[[nodiscard]] std::filesystem::path run_directory(const std::filesystem::path& out, const CampaignRun& run);

}  // namespace mpm
