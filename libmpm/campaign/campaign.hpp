#pragma once
/// A campaign: many runs of a plan in one folder, resumable, with one table of everything.
///
///   OUT/plan.toml       the plan as resolved: base and every run
///   OUT/runs/NAME/      what `mpm run` leaves, and attempts.json: who ran it when, and how that ended
///   OUT/results.csv     a row a run in the order of the plan: inputs that vary, derived quantities, metrics of results.json. The same
///   bytes
///                       whatever the order of completion, the executor or the interruptions
///   OUT/runs.csv        what differs from one execution to the next: times, speed, memory, attempts
///
/// The folders alone decide what is done, so that any process on any machine sees the same: done is a results.json of the same case hash
/// and duration, running is a folder whose lock is held.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "libmpm/campaign/plan.hpp"
#include "libmpm/driver/case.hpp"
#include "libmpm/driver/estimate.hpp"

namespace mpm {

/// A run of the plan with what it computes and what it will cost.
struct CampaignRun {
  std::string name;               ///< of its folder
  std::vector<Setting> settings;  ///< by which it differs from the base case
  Case spec;                      ///< resolved
  std::string case_hash;          ///< case_hash_text of driver/case_file.hpp
  Estimate cost;                  ///< before it is run
};

/// A plan whose runs are valid cases.
struct Campaign {
  CampaignPlan plan;              ///< as it was read
  std::vector<CampaignRun> runs;  ///< in the order of the plan, each case once
  std::size_t duplicates = 0;     ///< rows of the plan left out because an earlier one is the same case over the same time
};

/// The cases of a plan. @throws ConfigError with every problem of every case, and for names that two cases share
[[nodiscard]] Campaign make_campaign(CampaignPlan plan);

/// Folder of a run.
[[nodiscard]] std::filesystem::path run_directory(const std::filesystem::path& out, const CampaignRun& run);

}  // namespace mpm
