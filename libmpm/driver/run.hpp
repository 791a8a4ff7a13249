#pragma once
/// A case from start to end into a directory: the driver behind `mpm run`, for programs that want the whole product.
/// Programs that want the solver alone use scene.hpp and core/step.hpp.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Where a run is, for a display.
struct Progress {
  double time = 0.0, duration = 0.0;          ///< s
  std::uint64_t step = 0;                     ///< steps done since t = 0
  double dt = 0.0;                            ///< s, of the last step
  std::size_t particles = 0;                  ///< at this moment
  double wall_s = 0.0, eta_s = 0.0;           ///< s: used by this stretch, and expected until the end
  double million_particle_steps_per_s = 0.0;  ///< since the start of this stretch
  std::string message;                        ///< not empty: a line for the log; the numbers above are then those of the moment
};

/// What the caller wants at the next sample.
enum class Request { none, checkpoint, stop };

/// How and where a case is run.
struct RunOptions {
  std::filesystem::path out;  ///< folder of the run; made where it is missing
  int threads = 0;            ///< 0: as many as OpenMP offers
  bool resume = false;        ///< go on from the newest good checkpoint in `out`; a longer duration than before extends a finished run
  std::function<void(const Progress&)> on_progress;  ///< after every sample, and for messages
  /// Observers of the caller's own, after those of driver/observers.cpp: their columns and results are written like all others.
  std::vector<std::shared_ptr<Observer>> observers;
  Ranks* ranks = nullptr;         ///< not null: other ranks take part (driver/worker.hpp), and this is the first; outlives the run
  std::function<Request()> poll;  ///< asked after every sample, e.g. whether a signal arrived
};

/// How far a run came, and what it measured.
struct RunResult {
  bool finished = false;                                         ///< false: stopped on request; out/checkpoint.h5 is there to go on from
  double time = 0.0;                                             ///< s
  std::uint64_t steps = 0, particle_steps = 0;                   ///< since t = 0, of all stretches
  std::size_t particles = 0;                                     ///< at the end
  double wall_time_s = 0.0, million_particle_steps_per_s = 0.0;  ///< of all stretches
  Results results;                                               ///< the entries of results.json
  std::string results_json;                                      ///< its content
};

/// Runs a case and writes case.toml, series.csv, frames, profile.csv, profiles.h5, results.json, final.h5, checkpoint.h5 and run.log to
/// options.out.
///
/// Samples are taken at whole multiples of 1/series_per_second, and the run ends at the first of them at or after duration_s; frames are
/// taken every round(series_per_second / frames_per_second) samples. Steps are cut so that they meet these instants, which makes a resumed
/// or extended run go through the same steps.
///
/// Two checkpoints are kept, checkpoint.h5 and checkpoint.previous.h5. A resumed run takes the newest that is whole, of this case, and up
/// to which series.csv has its rows; it says so if that is not the newest, and never starts from the beginning over one that it refuses.
/// @throws ConfigError, IoError, UnstableError (what was written before stays)
RunResult run_case(const Case& c, const RunOptions& options);

}  // namespace mpm
