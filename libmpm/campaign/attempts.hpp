#pragma once
/// attempts.json in the folder of a run: machine, time and outcome of each attempt.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"

namespace mpm {

/// One attempt at a run, as in attempts.json.
struct Attempt {
  std::string started, ended;    ///< UTC; ended is empty during the attempt, and if it was interrupted
  std::string host;              ///< name of the machine
  std::string outcome;           ///< done, failed, stopped; empty during the attempt, and if it was interrupted
  std::optional<int> exit_code;  ///< of the process, if it exited
  std::optional<int> signal;     ///< signal that ended the process
  std::string cause;             ///< of a failure: the last line that the run printed
  bool final = false;            ///< a failure that would repeat itself: the case is invalid, or unstable
};

/// The attempts of this run (hash and duration) in attempts.json of a folder; empty if there are none.
/// @throws IoError if the file cannot be read, or is not one of this program
[[nodiscard]] std::vector<Attempt> read_attempts(const std::filesystem::path& directory, const CampaignRun& run);
/// Writes attempts.json as an atomic file (io/atomic_file.hpp). @throws IoError
void write_attempts(const std::filesystem::path& directory, const CampaignRun& run, const std::vector<Attempt>& attempts);

}  // namespace mpm
