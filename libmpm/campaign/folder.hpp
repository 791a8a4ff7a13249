#pragma once
/// The folder of a campaign: comparison with a plan, and preparation of it and of the folders of its runs.

#include <filesystem>
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

/// Time of the last complete row of a series, s; 0 without one.
[[nodiscard]] double last_time(const std::filesystem::path& series);

/// Whether the content of a folder, finished or not, belongs to this case and is not longer than it.
[[nodiscard]] bool can_go_on(const std::filesystem::path& directory, const CampaignRun& run);

}  // namespace mpm
