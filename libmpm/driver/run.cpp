#include "libmpm/driver/run.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>

#include <cerrno>
#include <chrono>
#include <ctime>
#include <optional>

#include "libmpm/base/error.hpp"
#include "libmpm/base/process.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/driver/advice.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/pieces.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/driver/threads.hpp"
#include "libmpm/driver/worker.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/snapshot.hpp"
#include "libmpm/io/xdmf.hpp"
#include "libmpm/observe/observer_list.hpp"
#include "libmpm/parallel/block_exchange.hpp"

namespace mpm {

namespace {

using Clock = std::chrono::steady_clock;

/// The run.log of a run, open until it ends or stops: its messages, with times.
class RunLog {
 public:
  /// @param append  whether to keep the lines from before a resume. @throws IoError
  RunLog(const std::filesystem::path& path, bool append)
      : file_(open(path.c_str(), O_CREAT | O_WRONLY | O_NOFOLLOW | O_CLOEXEC | (append ? O_APPEND : O_TRUNC), 0666)) {
    if (!file_) throw file_error("cannot write", path, errno);
  }

  /// Adds one line with the time. A log that cannot be written must not end a run that can; the loss shows in the series, which is checked.
  void write(const std::string& text) const {
    (void)file_.write(fmt::format("{:%Y-%m-%d %H:%M:%S} {}\n", fmt::localtime(std::time(nullptr)), text));
  }

 private:
  Descriptor file_;
};

/// One run in its directory.
class Run {
 public:
  Run(const Case& c, const RunOptions& options);
  RunResult go();

 private:
  // start, new or from a checkpoint
  void start_or_resume();
  [[nodiscard]] bool may_start_over() const;
  void start();
  void resume();
  void remove_results(std::initializer_list<const char*> names) const;
  // from sample to sample
  RunResult loop();
  [[nodiscard]] bool at_end() const;
  void advance_to_next_sample();
  void record_sample();
  void report_progress();
  // what is written
  void say(const std::string& text, bool to_caller = true);
  void checkpoint(const char* why);
  RunResult finish(bool complete);
  void write_results(RunResult& result);

  [[nodiscard]] std::string workforce() const;
  [[nodiscard]] static std::string program();
  [[nodiscard]] Progress progress_now() const;
  [[nodiscard]] SnapshotInfo snapshot_info() const;

  Case case_;
  RunOptions options_;
  std::string hash_;
  Sampling sampling_;
  CaseScene scene_;
  State state_;
  RunProgress progress_;
  ObserverList observers_;

  DirectoryLock lock_;
  std::optional<RunLog> log_;
  std::optional<SeriesWriter> table_;
  std::optional<FrameSeries> frames_;

  double last_dt_ = 0.0;
  Clock::time_point started_ = Clock::now(), checkpointed_ = Clock::now();
  RunProgress before_;  // at the start or resume of this process
};

const std::filesystem::path& made(const std::filesystem::path& directory) {
  make_directory(directory);
  return directory;
}

Run::Run(const Case& c, const RunOptions& options)
    : case_(c),
      options_(options),
      hash_(case_hash_text(c)),
      sampling_(c),
      scene_(make_scene(c)),
      state_(c.numerics.cell_size),
      observers_(make_observers(c, scene_, options.observers)),
      lock_(made(options.out)) {
  start_threads(options_.threads);
}

// ---- The start --------------------------------------------------------------------------------------------------------------------------

void Run::start_or_resume() {
  remove_leftovers(options_.out);
  if (options_.resume && has_checkpoint(options_.out)) return resume();
  if (options_.resume && !may_start_over()) {
    throw IoError(
        fmt::format("{}: holds finished results but no checkpoint to go on from; choose another --out, or compute the "
                    "case again with --force instead of --resume",
                    options_.out.string()));
  }
  if (const auto file = options_.out / "case.toml"; options_.resume && std::filesystem::exists(file)) {
    if (const auto changed = case_differences(read_case(file), case_); !changed.empty()) {
      throw ConfigError(fmt::format("{}: holds a run of another case ({}); choose another --out, or --force instead of --resume",
                                    options_.out.string(), fmt::join(changed, "; ")));
    }
  }
  start();
  if (options_.resume) say("no checkpoint here: started from the beginning");
}

/// Without a checkpoint: --resume does not repeat a finished run, unless it is this case up to an earlier time, or its results are damaged.
bool Run::may_start_over() const {
  const ResultsFile file(options_.out);
  if (!file.exists()) return true;
  if (!file.results()) return holds_case(options_.out, hash_);
  if (file.results()->text("case_hash") != hash_) return false;
  if (!file.damage().empty() || file.results()->has("measured_from")) return true;
  return !file.is_finished(case_) && file.results()->number_or_nan("duration_s") < sampling_.end();
}

void Run::start() {
  state_ = make_state(case_, scene_, options_.ranks);
  if (state_.grid.particle_count() == 0) throw ConfigError("the case holds no particles: add a [[body]] or a [conveyor]");
  progress_.initial_particles = state_.grid.particle_count();
  log_.emplace(options_.out / "run.log", false);
  // The newest checkpoint last: after a kill the remaining files belong to the old run, and a resumed run detects that.
  remove_results(
      {"results.json", "profile.csv", "profiles.h5", "final.h5", refused_checkpoint_file, previous_checkpoint_file, checkpoint_file});
  write_case_files(options_.out, case_);
  const std::vector<std::string>& columns = observers_.series().names();
  table_.emplace(options_.out / "series.csv", columns.size(), csv_line(columns));
  frames_.emplace(FrameSeries::create(options_.out));
  if (const std::string note = lock_.note(); !note.empty()) say(note);
  say(fmt::format("start: {} particles, {}, {} precision, {}", progress_.initial_particles, workforce(), name_of(state_.grid.precision()),
                  program()));
  for (const Advice& advice : advise(case_)) say("warning: " + advice.text(), false);
  observers_.begin(state_, scene_);
  record_sample();
  for (const std::string& warning : particles_inside_boundaries(state_, scene_)) say(warning);
}

void Run::resume() {
  const auto acceptable = [&](const State&, const RunProgress& progress, const Arrays& observed) {
    observers_.load(observed, progress.samples);
  };
  const std::string older = resume_from_checkpoint(options_.out, case_, state_, progress_, acceptable, options_.ranks);
  if (progress_.samples > sampling_.last() + 1) {
    throw ConfigError(
        fmt::format("{}: the run there has reached t = {:.6g} s, beyond the output.duration_s = {:g} s of this case; give a duration of at "
                    "least that, or compute the shorter run in another --out directory",
                    options_.out.string(), state_.time, case_.output.duration));
  }
  before_ = progress_;
  const auto series_file = options_.out / "series.csv";
  const std::string rows = table_text(observers_.series().names(), observers_.series().values());
  const bool rows_are_there = std::filesystem::exists(series_file) && read_file(series_file).starts_with(rows);
  log_.emplace(options_.out / "run.log", true);
  remove_results({"results.json", "profile.csv", "profiles.h5", "final.h5"});  // of the shorter run that is extended
  write_case_files(options_.out, case_);
  table_.emplace(series_file, observers_.series().names().size(), rows);
  if (!older.empty()) say(older);
  if (!rows_are_there) say("series.csv was missing or damaged: its rows are written again from the checkpoint");
  frames_.emplace(FrameSeries::resume(options_.out, static_cast<int>(sampling_.frames(progress_.samples)),
                                      [this](const std::string& why) { say(why + "; left out of frames.xdmf"); }));
  if (const std::string note = lock_.note(); !note.empty()) say(note);
  say(fmt::format("resumed at t = {:.6g} s, step {}: {} particles, {}, {}", state_.time, state_.step, state_.grid.particle_count(),
                  workforce(), program()));
  observers_.begin(state_, scene_);
}

/// In run.log of every process of a run: results.json names the last one.
std::string Run::program() { return fmt::format("mpm {} (commit {})", build_info().version, build_info().commit); }

std::string Run::workforce() const {
  const std::string threads = counted(omp_get_max_threads(), "thread");
  return options_.ranks == nullptr ? threads : fmt::format("{}, {} each", counted(options_.ranks->size(), "rank"), threads);
}

void Run::remove_results(std::initializer_list<const char*> names) const {
  for (const char* name : names) remove_file(options_.out / name);
}

// ---- From sample to sample --------------------------------------------------------------------------------------------------------------

RunResult Run::go() {
  try {
    start_or_resume();
    return loop();
  } catch (const UnstableError& error) {  // the core names quantities; add their keys
    const std::string text = fmt::format("{}. Keys: [numerics] cfl, cell_size_m", error.what());
    if (log_) log_->write(text);
    throw UnstableError(text);
  } catch (const Error& error) {
    if (log_) log_->write(error.what());
    throw;
  }
}

/// Follows from the series, so that a resumed run ends at the same sample.
bool Run::at_end() const { return progress_.samples > sampling_.last() || observers_.may_end(); }

RunResult Run::loop() {
  while (!at_end()) {
    advance_to_next_sample();
    record_sample();
    report_progress();
    const Request request = options_.poll ? options_.poll() : Request::none;
    if (request == Request::stop && !at_end()) return finish(false);
    if (request == Request::checkpoint || seconds_since(checkpointed_) > 60.0 * case_.output.checkpoint_minutes) {
      checkpoint(request == Request::checkpoint ? "asked for" : "periodic");
    }
  }
  return finish(true);
}

void Run::advance_to_next_sample() {
  const auto start = Clock::now();
  advance(state_, scene_, sampling_.time(progress_.samples), [&](const StepReport& report) {
    progress_.particle_steps += state_.grid.particle_count();
    last_dt_ = report.dt;
    observers_.after_step(report, state_);
  });
  progress_.step_time += seconds_since(start);
}

void Run::record_sample() {
  const LiveState live{state_, scene_, totals(state_, scene_)};
  const double interval = progress_.samples == 0 ? 0.0 : state_.time - sampling_.time(progress_.samples - 1);
  const Instant now{state_.time, interval, &live};
  table_->append(observers_.sample(now));
  if (sampling_.has_frame(progress_.samples))
    frames_->append(snapshot_info(), [this](SnapshotWriter& file) { write_particles(file, state_, scene_); });
  ++progress_.samples;
  for (const std::string& warning : observers_.check(now)) say(warning);
}

Progress Run::progress_now() const {
  Progress p;
  p.time = state_.time;
  p.duration = sampling_.end();
  p.step = state_.step;
  p.dt = last_dt_;
  p.particles = state_.grid.particle_count();
  p.wall_s = seconds_since(started_);
  const double step_time = progress_.step_time - before_.step_time;
  if (step_time > 0.0)
    p.million_particle_steps_per_s = 1e-6 * static_cast<double>(progress_.particle_steps - before_.particle_steps) / step_time;
  return p;
}

void Run::report_progress() {
  if (!options_.on_progress) return;
  Progress p = progress_now();
  const double done = static_cast<double>(progress_.samples - 1), all = static_cast<double>(sampling_.last());
  p.eta_s = done > 0.0 ? (before_.wall_time + p.wall_s) * (all - done) / done : 0.0;
  options_.on_progress(p);
}

// ---- What is written --------------------------------------------------------------------------------------------------------------------

void Run::say(const std::string& text, bool to_caller) {
  log_->write(text);
  if (!to_caller || !options_.on_progress) return;
  Progress p = progress_now();
  p.message = text;
  options_.on_progress(p);
}

SnapshotInfo Run::snapshot_info() const {
  return {state_.time,
          static_cast<std::int64_t>(state_.step),
          hash_,
          std::string(build_info().version),
          case_.material.density(),
          scene_.mirror.x,
          scene_.mirror.y,
          state_.grid.precision()};
}

void Run::checkpoint(const char* why) {
  progress_.wall_time = before_.wall_time + seconds_since(started_);
  table_->sync();  // first, so that a checkpoint never exists without the rows before it
  write_checkpoint(options_.out / checkpoint_file, case_, state_, progress_, observers_.save(), options_.out / previous_checkpoint_file);
  checkpointed_ = Clock::now();
  say(fmt::format("checkpoint at t = {:.6g} s, step {} ({})", state_.time, state_.step, why), false);
}

RunResult Run::finish(bool complete) {
  checkpoint(complete ? "end" : "stopped");
  if (options_.ranks != nullptr) write_file(options_.out / "ranks.json", report_of_ranks(state_, *options_.ranks));
  RunResult result;
  result.finished = complete;
  result.time = state_.time;
  result.steps = state_.step;
  result.particle_steps = progress_.particle_steps;
  result.particles = state_.grid.particle_count();
  result.wall_time_s = progress_.wall_time;
  result.million_particle_steps_per_s = progress_.speed();
  if (complete) {
    write_results(result);
    for (const std::string& warning : result_warnings(result.results)) say("warning: " + warning);
    if (std::filesystem::exists(options_.out / "post/results.json"))
      say("post/ is from before this run went on: make it again with mpm post");
    if (progress_.samples <= sampling_.last()) {
      say(fmt::format("ended at t = {:.6g} s of {:.6g} s: the means are known to {:.3g} % (output.stop_when_steady)", state_.time,
                      sampling_.end(), 100.0 * case_.output.stop_when_steady));
    }
    say(fmt::format("done: {} steps, {:.4g} million particle-steps/s over {:.1f} s of wall time", state_.step, progress_.speed(),
                    progress_.wall_time),
        false);
  } else {
    say(fmt::format("stopped at t = {:.6g} s of {:.6g} s; go on with --resume", state_.time, sampling_.end()));
  }
  return result;
}

/// results.json last: if it exists, the run is complete.
void Run::write_results(RunResult& result) {
  const Summary end = observers_.summary(&state_, &progress_);
  result.results = observers_.results(end);
  if (!end.profiles.empty()) {
    write_file(options_.out / "profile.csv", end.profile);
    write_profiles_over_time(options_.out / "profiles.h5", end.series.time(), end.profiles);
  }
  SnapshotWriter final_state(SnapshotKind::final, options_.out / "final.h5", snapshot_info());
  write_particles(final_state, state_, scene_);
  write_file(options_.out / "results.json", result.results.to_json());
}

}  // namespace

RunResult run_case(const Case& c, const RunOptions& options) { return Run(c, options).go(); }

}  // namespace mpm
