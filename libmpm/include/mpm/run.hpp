#pragma once
/// A case from start to end into a directory: the driver behind `mpm run`, for programs that want the whole product.
/// Programs that want the solver alone use scene.hpp and solver.hpp.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "mpm/case.hpp"
#include "mpm/impact/results.hpp"
#include "mpm/solver.hpp"

namespace mpm {

struct Progress {
  double time = 0.0, duration = 0.0;  ///< s
  std::uint64_t step = 0;
  double dt = 0.0;  ///< s, of the last step
  std::size_t particles = 0;
  double wall_s = 0.0, eta_s = 0.0;
  double million_particle_steps_per_s = 0.0;  ///< since the start of this stretch
  std::string message;                        ///< not empty: a line for the log; the figures above are then those of the moment
};

/// What the caller wants at the next sample.
enum class Request { none, checkpoint, stop };

struct RunOptions {
  std::filesystem::path out;
  int threads = 0;      ///< 0: as many as OpenMP offers
  bool resume = false;  ///< go on from the newest good checkpoint in `out`; a longer duration than before extends a finished run
  std::function<void(const Progress&)> on_progress;  ///< after every sample, and for messages
  /// Called at every sample of this stretch, t = 0 included, with force (N) and moment (N m) of the interval before it: for measurements
  /// of the caller's own.
  std::function<void(const State&, const Scene&, const Vec3& force, const Vec3& moment)> on_sample;
  std::function<Request()> poll;  ///< asked after every sample, e.g. whether a signal arrived
};

struct RunResult {
  bool finished = false;  ///< false: stopped on request; out/checkpoint.h5 is there to go on from
  double time = 0.0;      ///< s
  std::uint64_t steps = 0, particle_steps = 0;
  std::size_t particles = 0;
  double wall_time_s = 0.0, million_particle_steps_per_s = 0.0;
  std::optional<ImpactSummary> impact;  ///< cases with an obstacle and a conveyor
  std::string results_json;             ///< content of results.json
};

/// Number of the sample that a run ends with, counted from 0 at t = 0: the first at or after its duration.
std::uint64_t last_sample(const Case& c);
/// Frames are taken at every that many samples; 0: none are taken.
std::uint64_t samples_per_frame(const Case& c);

/// Runs a case and writes case.toml, series.csv, frames, profile.csv, results.json, final.h5, checkpoint.h5 and run.log to options.out.
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
