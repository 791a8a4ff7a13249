#pragma once
/// Measurements of a run again, from the frames that it stored: after a kill, with a newer version, or to check the run's own.
///
/// The observers are those of the run. A frame holds what those of Source::particles need, in double precision (but for velocities), so
/// their values at the times of frames are those of the run up to the order of the sums. What only the run knows is carried over from its
/// series.csv: at the times of frames, or, for columns that are means over intervals, averaged over the interval between two frames.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "libmpm/observe/observer.hpp"

namespace mpm {

/// What the frames of a run gave.
struct PostResult {
  std::size_t frames = 0;                      ///< that were read
  Results results;                             ///< what was measured from the frames
  std::string results_json;                    ///< content of results.json
  std::vector<std::filesystem::path> written;  ///< files, in the order in which they were written
};

/// Measures the frames of a result folder again (case.toml, frames; series.csv where there is one) and writes results.json, series.csv
/// and, for impacts, profile.csv and profiles.h5 to `out`. Those of them that the result folder itself lacks, because its run did not come
/// to its end, are written there, too; what is there is never touched.
///
/// results.json is the run's own, where there is one, with what frames give replaced; `measured_from` is "frames" and `frames` their
/// number.
/// @param observers  observers of the caller's own, as in RunOptions
/// @throws IoError without frames, for damaged ones, or if they belong to another case than case.toml; ConfigError if `out` is the folder
/// itself
PostResult post_process(const std::filesystem::path& directory, const std::filesystem::path& out,
                        const std::vector<std::shared_ptr<Observer>>& observers = {});

}  // namespace mpm
