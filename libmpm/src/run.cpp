#include "mpm/run.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <omp.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <latch>
#include <nlohmann/json.hpp>
#include <numeric>
#include <system_error>
#include <thread>
#include <vector>

#include "mpm/build_info.hpp"
#include "mpm/diagnostics.hpp"
#include "mpm/error.hpp"
#include "mpm/health.hpp"
#include "mpm/impact/measure.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/checkpoint.hpp"
#include "mpm/io/config.hpp"
#include "mpm/io/snapshot.hpp"
#include "mpm/io/table.hpp"
#include "mpm/io/xdmf.hpp"
#include "mpm/post.hpp"
#include "mpm/run_folder.hpp"
#include "mpm/scene.hpp"
#include "mpm/stress.hpp"

namespace mpm {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int results_format_version = 1;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// run.log: what was said, with times.
class RunLog {
 public:
  RunLog(const std::filesystem::path& path, bool append) {
    descriptor_ = open(path.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC | (append ? O_APPEND : O_TRUNC), 0644);
    if (descriptor_ < 0) throw file_error("cannot write", path, errno);
  }
  ~RunLog() { close(descriptor_); }
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;
  void say(const std::string& text) const {
    const std::string line = fmt::format("{:%Y-%m-%d %H:%M:%S} {}\n", fmt::localtime(std::time(nullptr)), text);
    // a log that cannot be written must not end a run that can; the loss shows in the series, which is checked
    [[maybe_unused]] const auto written = write(descriptor_, line.data(), line.size());
  }

 private:
  int descriptor_;
};

std::size_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

/// Adds layers to the sum of those before, which grows to hold them.
void add(LayerImpulses& sum, const LayerImpulses& more) {
  if (more.layer.empty()) return;
  if (sum.layer.empty()) sum.first = more.first;
  if (more.first < sum.first) {
    sum.layer.insert(sum.layer.begin(), static_cast<std::size_t>(sum.first - more.first), Vec3::Zero());
    sum.first = more.first;
  }
  const auto base = static_cast<std::size_t>(more.first - sum.first);
  if (sum.layer.size() < base + more.layer.size()) sum.layer.resize(base + more.layer.size(), Vec3::Zero());
  for (std::size_t k = 0; k < more.layer.size(); ++k) sum.layer[base + k] += more.layer[k];
}

/// Makes the threads of OpenMP. Its runtime ends the process, without a way to intervene, when it cannot: so we try first.
void start_threads() {
  const int wanted = omp_get_max_threads();
  std::vector<std::thread> trial;
  std::latch all(wanted);
  try {
    for (int i = 1; i < wanted; ++i) trial.emplace_back([&all] { all.arrive_and_wait(); });
    all.count_down();
  } catch (const std::system_error& error) {
    all.count_down(wanted - static_cast<std::ptrdiff_t>(trial.size()));
    for (std::thread& t : trial) t.join();
    throw Error(ExitCode::internal,
                fmt::format("cannot start {} threads: {}; take fewer with --threads, or raise the limits of memory (ulimit -v) and of "
                            "processes (ulimit -u)",
                            wanted, error.what()));
  }
  for (std::thread& t : trial) t.join();
#pragma omp parallel
  {}
}

/// One run in its directory.
class Run {
 public:
  Run(const Case& c, const RunOptions& options);
  RunResult go();

 private:
  [[nodiscard]] bool may_start_over() const;
  void start();
  void resume();
  void remove_results(std::initializer_list<const char*> names) const;
  void advance_to_next_sample();
  void record_sample();
  [[nodiscard]] ForceByHeight force_by_height(double interval) const;
  void write_frame();
  void checkpoint(const char* why);
  void say(const std::string& text, bool to_caller = true);
  [[nodiscard]] Progress figures() const;
  [[nodiscard]] SnapshotInfo snapshot_info() const;
  RunResult finish(bool complete);

  [[nodiscard]] double sample_time(std::uint64_t k) const { return static_cast<double>(k) / case_.output.series_per_second; }
  [[nodiscard]] std::vector<std::string> columns() const;

  Case case_;
  RunOptions options_;
  std::string hash_;
  Scene scene_;
  State state_;
  RunProgress progress_;
  ImpactSeries series_;
  std::optional<ImpactGeometry> geometry_;  // cases with a conveyor and an obstacle
  std::uint64_t last_sample_, samples_per_frame_;

  DirectoryLock lock_;
  std::optional<HealthWatch> health_;
  std::optional<RunLog> log_;
  std::optional<SeriesWriter> table_;
  std::optional<FrameSeries> frames_;

  Vec3 obstacle_impulse_ = Vec3::Zero(), obstacle_angular_ = Vec3::Zero();  // since the last sample
  LayerImpulses obstacle_layers_;                                           // likewise
  double last_dt_ = 0.0;
  Clock::time_point started_ = Clock::now(), checkpointed_ = Clock::now();
  double wall_before_ = 0.0, step_before_ = 0.0;
  std::uint64_t particle_steps_before_ = 0;
};

const std::filesystem::path& made(const std::filesystem::path& directory) {
  make_directory(directory);
  return directory;
}

Run::Run(const Case& c, const RunOptions& options)
    : case_(c),
      options_(options),
      hash_(case_hash_text(c)),
      scene_(make_scene(c)),
      state_(c.numerics.cell_size),
      geometry_(impact_geometry(c)),
      last_sample_(last_sample(c)),
      samples_per_frame_(samples_per_frame(c)),
      lock_(made(options.out)) {
  if (options_.threads > 0) omp_set_num_threads(options_.threads);
  start_threads();
}

std::vector<std::string> Run::columns() const {
  std::vector<std::string> names = {"time_s"};
  if (geometry_) names.insert(names.end(), {"runup_m", "runup_p99_m", "pressure_height_m", "impact_pressure_pa", "compaction"});
  if (scene_.obstacle) names.insert(names.end(), {"force_x_n", "force_y_n", "force_z_n", "moment_x_n_m", "moment_y_n_m", "moment_z_n_m"});
  names.insert(names.end(), {"particles", "mass_kg", "momentum_x_kg_m_s", "momentum_y_kg_m_s", "momentum_z_kg_m_s", "kinetic_energy_j",
                             "elastic_energy_j", "potential_energy_j", "max_speed_m_s"});
  return names;
}

void Run::say(const std::string& text, bool to_caller) {
  log_->say(text);
  if (!to_caller || !options_.on_progress) return;
  Progress p = figures();
  p.message = text;
  options_.on_progress(p);
}

Progress Run::figures() const {
  Progress p;
  p.time = state_.time;
  p.duration = sample_time(last_sample_);
  p.step = state_.step;
  p.dt = last_dt_;
  p.particles = state_.grid.particle_count();
  p.wall_s = seconds_since(started_);
  const double step_time = progress_.step_time - step_before_;
  if (step_time > 0.0)
    p.million_particle_steps_per_s = 1e-6 * static_cast<double>(progress_.particle_steps - particle_steps_before_) / step_time;
  return p;
}

void Run::remove_results(std::initializer_list<const char*> names) const {
  for (const char* name : names) remove_file(options_.out / name);
}

/// Without a checkpoint: a finished run is not computed again under --resume, unless it is this case up to another time.
bool Run::may_start_over() const {
  if (!std::filesystem::exists(options_.out / "results.json")) return true;
  if (finished_results(options_.out, case_)) return false;
  const auto json = nlohmann::json::parse(read_file(options_.out / "results.json"), nullptr, false);
  return json.is_object() && json.value("case_hash", "") == hash_;
}

void Run::start() {
  state_ = make_state(case_, scene_);
  if (state_.grid.particle_count() == 0) throw ConfigError("the case holds no particles: add a [[body]] or a [conveyor]");
  progress_.initial_particles = state_.grid.particle_count();
  log_.emplace(options_.out / "run.log", false);
  // The newest checkpoint last: whatever a kill leaves of them belongs to the old run, and a resumed run can tell.
  remove_results({"results.json", "profile.csv", "final.h5", refused_checkpoint_file, previous_checkpoint_file, checkpoint_file});
  write_file(options_.out / "case.toml", write_case(case_));
  table_.emplace(options_.out / "series.csv", columns());
  frames_.emplace(FrameSeries::create(options_.out));
  say(fmt::format("start: {} particles, {} threads", progress_.initial_particles, omp_get_max_threads()));
  record_sample();
}

void Run::resume() {
  const auto rows_are_there = [&](const State& state, const RunProgress& progress) {
    (void)SeriesWriter::kept(options_.out / "series.csv", columns(), progress.samples, state.time);
  };
  const std::string older = resume_from_checkpoint(options_.out, case_, state_, progress_, series_, rows_are_there);
  state_.grid.keep_old_nodes(case_.numerics.transfer == Transfer::flip);
  log_.emplace(options_.out / "run.log", true);
  remove_results({"results.json", "profile.csv", "final.h5"});  // of the shorter run that is extended
  wall_before_ = progress_.wall_time;
  step_before_ = progress_.step_time;
  particle_steps_before_ = progress_.particle_steps;
  write_file(options_.out / "case.toml", write_case(case_));
  table_.emplace(SeriesWriter::resume(options_.out / "series.csv", columns(), progress_.samples, state_.time));
  if (!older.empty()) say(older);
  const std::uint64_t frames = samples_per_frame_ > 0 ? (progress_.samples - 1) / samples_per_frame_ + 1 : 0;
  frames_.emplace(FrameSeries::resume(options_.out, static_cast<int>(frames),
                                      [this](const std::string& why) { say(why + "; left out of frames.xdmf"); }));
  say(fmt::format("resumed at t = {:.6g} s, step {}: {} particles, {} threads", state_.time, state_.step, state_.grid.particle_count(),
                  omp_get_max_threads()));
}

void Run::advance_to_next_sample() {
  const auto start = Clock::now();
  obstacle_impulse_ = obstacle_angular_ = Vec3::Zero();
  obstacle_layers_ = {};
  advance(state_, scene_, sample_time(progress_.samples), [&](const StepReport& report) {
    progress_.particle_steps += state_.grid.particle_count();
    last_dt_ = report.dt;
    health_->book(report);
    if (!scene_.obstacle) return;
    obstacle_impulse_ += report.impulses[*scene_.obstacle].linear;
    obstacle_angular_ += report.impulses[*scene_.obstacle].angular;
    add(obstacle_layers_, report.obstacle_layers);
  });
  progress_.step_time += seconds_since(start);
}

ForceByHeight Run::force_by_height(double interval) const {
  const double dx = state_.grid.cell_size(), whole = scene_.mirror_y ? 2.0 : 1.0;
  std::vector<double> force;
  for (const Vec3& impulse : obstacle_layers_.layer) force.push_back(interval > 0.0 ? whole * impulse.x() / interval : 0.0);
  ForceByHeight result = mpm::force_by_height(force, dx * obstacle_layers_.first - scene_.offset.z(), dx, *geometry_);
  if (interval > 0.0) return result;
  std::ranges::fill(result.bins, std::nan(""));
  result.first_moment = std::nan("");
  return result;
}

void Run::record_sample() {
  const double interval = progress_.samples == 0 ? 0.0 : state_.time - sample_time(progress_.samples - 1);
  const double unknown = std::nan("");
  const Vec3 nothing = Vec3::Constant(unknown);
  const Vec3 force = interval > 0.0 ? whole_force(obstacle_impulse_ / interval, scene_.mirror_x, scene_.mirror_y) : nothing;
  const Vec3 moment = interval > 0.0 ? whole_moment(obstacle_angular_ / interval, scene_.mirror_x, scene_.mirror_y) : nothing;
  std::vector<double> row = {state_.time};
  if (geometry_) {
    const ImpactFrame frame = measure_impact(state_, scene_, *geometry_);
    row.insert(row.end(), {frame.runup, frame.runup_p99, frame.pressure_height.value_or(unknown), frame.impact_pressure, frame.compaction});
    series_.append(state_.time, frame, force, moment, force_by_height(interval));
  }
  if (scene_.obstacle) row.insert(row.end(), {force.x(), force.y(), force.z(), moment.x(), moment.y(), moment.z()});
  const Totals computed = totals(state_, scene_);
  const Totals t = whole_of_mirrored(computed, scene_.mirror_x, scene_.mirror_y);
  row.insert(row.end(), {static_cast<double>(t.particles), t.mass, t.momentum.x(), t.momentum.y(), t.momentum.z(), t.kinetic_energy,
                         t.elastic_energy, t.potential_energy, state_.max_speed});
  table_->append(row);
  if (samples_per_frame_ > 0 && progress_.samples % samples_per_frame_ == 0) write_frame();
  ++progress_.samples;
  if (options_.on_sample) options_.on_sample(state_, scene_, force, moment);
  if (!health_) return;
  for (const std::string& warning : health_->check(state_, scene_, computed)) say(warning);
}

SnapshotInfo Run::snapshot_info() const {
  return {state_.time,
          static_cast<std::int64_t>(state_.step),
          hash_,
          std::string(build_info().version),
          case_.material.density,
          scene_.mirror_x,
          scene_.mirror_y};
}

void Run::write_frame() { frames_->append(particle_table(state_, scene_), snapshot_info()); }

void Run::checkpoint(const char* why) {
  progress_.wall_time = wall_before_ + seconds_since(started_);
  table_->sync();  // first, so that the rows up to a checkpoint are there whenever the checkpoint is
  write_checkpoint(options_.out / checkpoint_file, case_, state_, progress_, series_, options_.out / previous_checkpoint_file);
  checkpointed_ = Clock::now();
  say(fmt::format("checkpoint at t = {:.6g} s, step {} ({})", state_.time, state_.step, why), false);
}

RunResult Run::finish(bool complete) {
  checkpoint(complete ? "end" : "stopped");
  RunResult result;
  result.finished = complete;
  result.time = state_.time;
  result.steps = state_.step;
  result.particle_steps = progress_.particle_steps;
  result.particles = state_.grid.particle_count();
  result.wall_time_s = progress_.wall_time;
  result.million_particle_steps_per_s =
      progress_.wall_time > 0.0 ? 1e-6 * static_cast<double>(progress_.particle_steps) / progress_.wall_time : 0.0;
  if (!complete) {
    say(fmt::format("stopped at t = {:.6g} s of {:.6g} s; go on with --resume", state_.time, sample_time(last_sample_)));
    return result;
  }
  const BuildInfo build = build_info();
  nlohmann::ordered_json json;
  json["format_version"] = results_format_version;
  json["title"] = case_.title;
  json["case_hash"] = hash_;
  json["version"] = build.version;
  json["commit"] = build.commit;
  json["compiler"] = build.compiler;
  json["instruction_set"] = build.instruction_set;
  json["threads"] = omp_get_max_threads();
  json["duration_s"] = state_.time;
  json["wall_time_s"] = progress_.wall_time;
  json["solver_time_s"] = progress_.step_time;
  json["steps"] = state_.step;
  json["particle_steps"] = progress_.particle_steps;
  json["million_particle_steps_per_s"] = result.million_particle_steps_per_s;
  json["peak_memory_bytes"] = peak_memory_bytes();
  json["particles_initial"] = progress_.initial_particles;
  json["particles_entered"] = state_.entered.count;
  json["particles_final"] = result.particles;
  json["particles_left"] = state_.left.count;  // all of them: initial + entered = final + left
  json["particles_left_downstream"] = case_.conveyor ? state_.left.downstream : 0;
  json["particles_lost"] = state_.left.count - (case_.conveyor ? state_.left.downstream : 0);
  const double parts = (scene_.mirror_x ? 2.0 : 1.0) * (scene_.mirror_y ? 2.0 : 1.0);
  json["mass_entered_kg"] = parts * state_.entered.mass;
  json["mass_left_kg"] = parts * state_.left.mass;
  if (geometry_) {
    result.impact = summarise(series_, *geometry_, impact_flow(case_));
    json.update(nlohmann::ordered_json::parse(to_json(*result.impact)));
    write_profile(options_.out / "profile.csv", mean_profile(series_, result.impact->span, *geometry_));
  }
  result.results_json = json.dump(2) + "\n";
  write_final(options_.out / "final.h5", particle_table(state_, scene_), snapshot_info());
  write_file(options_.out / "results.json", result.results_json);
  say(fmt::format("done: {} steps, {:.4g} million particle-steps/s over {:.1f} s of wall time", state_.step,
                  result.million_particle_steps_per_s, progress_.wall_time),
      false);
  return result;
}

RunResult Run::go() {
  remove_leftovers(options_.out);
  if (options_.resume && has_checkpoint(options_.out)) {
    resume();
  } else {
    if (options_.resume && !may_start_over()) {
      throw IoError(
          fmt::format("{}: holds finished results but no checkpoint to go on from; choose another --out, or run without --resume "
                      "to compute the case again",
                      options_.out.string()));
    }
    start();
    if (options_.resume) say("no checkpoint here: started from the beginning");
  }
  try {
    if (state_.step == 0) {
      for (const std::string& warning : particles_inside_boundaries(state_, scene_)) say(warning);
    }
    health_.emplace(state_, scene_);
    while (progress_.samples <= last_sample_) {
      advance_to_next_sample();
      record_sample();
      if (options_.on_progress) {
        Progress p = figures();
        const double done = static_cast<double>(progress_.samples - 1), all = static_cast<double>(last_sample_);
        p.eta_s = done > 0.0 ? (wall_before_ + p.wall_s) * (all - done) / done : 0.0;
        options_.on_progress(p);
      }
      const Request request = options_.poll ? options_.poll() : Request::none;
      if (request == Request::stop && progress_.samples <= last_sample_) return finish(false);
      if (request == Request::checkpoint || seconds_since(checkpointed_) > 60.0 * case_.output.checkpoint_minutes) {
        checkpoint(request == Request::checkpoint ? "asked for" : "periodic");
      }
    }
  } catch (const Error& error) {
    say(error.what(), false);
    throw;
  }
  return finish(true);
}

}  // namespace

std::uint64_t last_sample(const Case& c) {
  return static_cast<std::uint64_t>(std::ceil(c.output.duration * c.output.series_per_second - 1e-9));
}

std::uint64_t samples_per_frame(const Case& c) {
  if (!(c.output.frames_per_second > 0.0)) return 0;
  constexpr double longest = 1e18;  // samples; fits the integer however few frames are wanted
  return static_cast<std::uint64_t>(std::clamp(std::round(c.output.series_per_second / c.output.frames_per_second), 1.0, longest));
}

RunResult run_case(const Case& c, const RunOptions& options) { return Run(c, options).go(); }

}  // namespace mpm
