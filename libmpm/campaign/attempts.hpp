#pragma once
/// attempts.json in the folder of a run: who ran it when, and how that ended.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"

namespace mpm {

/// One go at a run, as attempts.json keeps it.
struct Attempt {
  std::string started, ended;    ///< UTC; ended is empty while it lasts, and where it was cut off
  std::string host;              ///< name of the machine
  std::string outcome;           ///< done, failed, stopped; empty while it lasts, and where it was cut off
  std::optional<int> exit_code;  ///< of the process, if it ended by itself
  std::optional<int> signal;     ///< that ended it
  std::string cause;             ///< of a failure: the last line that the run printed
  bool final = false;            ///< a failure that would repeat itself: the case is invalid, or unstable
};

/// attempts.json of a folder, if it belongs to this run (hash and duration); empty otherwise.
[[nodiscard]] std::vector<Attempt> read_attempts(const std::filesystem::path& directory, const CampaignRun& run);
/// Writes attempts.json whole (io/atomic_file.hpp). @throws IoError
void write_attempts(const std::filesystem::path& directory, const CampaignRun& run, const std::vector<Attempt>& attempts);

}  // namespace mpm
