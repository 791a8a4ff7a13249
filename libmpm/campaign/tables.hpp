#pragma once
/// results.csv and runs.csv of a campaign.

#include <filesystem>
#include <vector>

#include "libmpm/campaign/campaign.hpp"
#include "libmpm/campaign/status.hpp"

namespace mpm {

/// Writes results.csv and runs.csv.
void write_campaign_tables(const std::filesystem::path& out, const Campaign& campaign, const std::vector<RunStatus>& status);

}  // namespace mpm
