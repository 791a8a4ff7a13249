#pragma once
/// Runs a case from start to end into a directory, as `mpm run` does. Programs that need only the solver use scene.hpp and core/step.hpp.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

class BlockExchange;

/// Progress of a run, for a display.
struct Progress {
  double time = 0.0, duration = 0.0;          ///< s
  std::uint64_t step = 0;                     ///< steps done since t = 0
  double dt = 0.0;                            ///< s, of the last step
  std::size_t particles = 0;                  ///< present number
  double wall_s = 0.0, eta_s = 0.0;           ///< s: since the start or resume of this process, and expected until the end
  double million_particle_steps_per_s = 0.0;  ///< since the start or resume of this process
  std::string message;                        ///< if not empty: a line for the log
};

/// Request of the caller at the next sample.
enum class Request { none, checkpoint, stop };

/// Options of run_case().
struct RunOptions {
  std::filesystem::path out;  ///< folder of the run; created if missing
  int threads = 0;            ///< 0: as many as OpenMP offers
  bool resume = false;        ///< continue from the newest valid checkpoint in `out`; a longer duration than before extends a finished run
  std::function<void(const Progress&)> on_progress;  ///< after every sample, and for messages
  /// Additional observers, after those of driver/observers.cpp; their columns and results are written like all others.
  std::vector<std::shared_ptr<Observer>> observers;
  /// If not null: the run has several ranks (driver/worker.hpp), and this is the first. It must outlive the run.
  BlockExchange* ranks = nullptr;
  std::function<Request()> poll;  ///< called after every sample, for example to report a signal
};

/// Outcome of a run.
struct RunResult {
  bool finished = false;                                         ///< false: stopped on request; out/checkpoint.h5 serves to resume
  double time = 0.0;                                             ///< s
  std::uint64_t steps = 0, particle_steps = 0;                   ///< since t = 0, including the time before a resume
  std::size_t particles = 0;                                     ///< at the end
  double wall_time_s = 0.0, million_particle_steps_per_s = 0.0;  ///< including the time before a resume
  Results results;                                               ///< the entries of results.json
};

/// Runs a case and writes case.toml, series.csv, frames, profile.csv, profiles.h5, results.json, final.h5, checkpoint.h5 and run.log to
/// options.out.
///
/// Sampling (sampling.hpp) says when samples and frames are taken and when the run ends. Steps are shortened to meet these instants, so
/// that a resumed or extended run takes the same steps.
///
/// Two checkpoints are kept, checkpoint.h5 and checkpoint.previous.h5. A resumed run uses the newest that is undamaged and belongs to this
/// case; it holds the rows of series.csv, which are written again if they are missing there. A message reports if an older one is used. If
/// every checkpoint is refused, the run does not start again from t = 0.
/// @throws ConfigError, IoError, UnstableError (files written before remain)
RunResult run_case(const Case& c, const RunOptions& options);

/// One line for each of run-up (and its highest particle), pressure height, force and overturning moment: mean, and what each +- contains;
/// then the peaks of the force. A run without a steady interval is flagged; it has no means. Empty for a run without an impact.
[[nodiscard]] std::string summary_text(const Results& results);

/// What the results of a finished run warn of; each is one line.
[[nodiscard]] std::vector<std::string> result_warnings(const Results& results);

}  // namespace mpm
