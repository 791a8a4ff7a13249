#pragma once
/// The folder of a campaign: what a plan finds in it, and making it and the folders of its runs ready.

#include <filesystem>
#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"

namespace mpm {

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
/// case.toml. Call it while no process works there.
void prepare_run(const std::filesystem::path& out, const CampaignRun& run);
/// Removes from the folder of a finished run what the plan does not keep.
void tidy_run(const std::filesystem::path& out, const CampaignPlan& plan, const CampaignRun& run);

/// Time of the last whole row of a series, s; 0 without one.
[[nodiscard]] double last_time(const std::filesystem::path& series);

/// Whether the content of a folder, finished or not, belongs to this case and is not longer than it.
[[nodiscard]] bool can_go_on(const std::filesystem::path& directory, const CampaignRun& run);

}  // namespace mpm
