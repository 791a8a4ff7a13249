#pragma once
/// Repeats the measurements of a run from its stored frames: after a kill, with a newer version, or as a check.
///
/// The observers are those of the run. A frame holds the data for those of MeasuredFrom::frames, in double precision except for velocities,
/// so their values at the times of frames equal those of the run except for the order of the sums. Other columns are taken from the run's
/// series.csv: at the times of frames, or, for columns that are means over intervals, averaged over the interval between two frames.

#include <filesystem>
#include <memory>
#include <vector>

#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Result of a replay.
struct PostResult {
  std::size_t frames = 0;                      ///< number of frames read
  Results results;                             ///< the entries of results.json
  std::vector<std::filesystem::path> written;  ///< files, in the order in which they were written
};

/// Measures the frames of a result folder again (case.toml, frames; series.csv if there is one) and writes results.json, series.csv
/// and, for impacts, profile.csv and profiles.h5 to `out`. Nothing is written to the result folder itself: a results.json there means that
/// the run finished.
///
/// results.json is the run's own, if it finished, with the entries measured from frames replaced; `measured_from` is "frames" and `frames`
/// their number.
/// @param observers  observers of the caller's own, as in RunOptions
/// @throws IoError without frames, for damaged ones, if they belong to another case than case.toml, or if results.json or series.csv of the
/// run is damaged; ConfigError if `out` is the folder of a run, such as this one
PostResult post_process(const std::filesystem::path& directory, const std::filesystem::path& out,
                        const std::vector<std::shared_ptr<Observer>>& observers = {});

}  // namespace mpm
