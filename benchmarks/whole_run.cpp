#include "whole_run.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <omp.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "libmpm/core/step.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/run.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm::benchmarks {

namespace {

/// A line of /proc/self/status in bytes.
double memory_line(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(name + ":", 0) == 0) return 1024.0 * std::stod(line.substr(name.size() + 1));
  }
  return 0.0;
}

/// Resets the peak to the present memory of the process.
void forget_peak() { std::ofstream("/proc/self/clear_refs") << '5'; }

class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / fmt::format("mpm-whole-run-{}", getpid())) {}
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Notes when the first step has ended.
class FirstStep : public Observer {
 public:
  explicit FirstStep(std::function<double()> seconds) : seconds_(std::move(seconds)) {}
  [[nodiscard]] std::string name() const override { return "first_step"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }
  void after_step(const StepReport& /*report*/, const State& /*state*/) override {
    if (end_ == 0.0) end_ = seconds_();
  }
  [[nodiscard]] double end() const { return end_; }

 private:
  std::function<double()> seconds_;
  double end_ = 0.0;
};

}  // namespace

Case avalanche_case(std::size_t particles, Precision precision, double duration) {
  constexpr double volume = 12.0 * 10.5 * 1.75;  // m^3, of the half that is computed
  const double cell = std::cbrt(8.0 * volume / static_cast<double>(particles));
  return parse_case(fmt::format(R"([material]
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 5.0
[conveyor]
froude_number = 3.0
flow_height_m = 1.75
width_m = 21.0
upstream_length_m = 8.0
downstream_length_m = 4.0
mirror_y = true
[obstacle]
width_m = 1.75
depth_m = 1.75
friction = 0.0
[numerics]
cell_size_m = {}
precision = "{}"
[output]
duration_s = {}
)",
                                cell, name_of(precision), duration),
                    "whole_run");
}

WholeRun whole_run(const Case& c, int threads) {
  using Clock = std::chrono::steady_clock;
  const Folder folder;
  malloc_trim(0);  // memory that earlier runs gave back would hide a part of the peak
  forget_peak();
  const double before = memory_line("VmRSS");
  const auto start = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  const auto first_step = std::make_shared<FirstStep>(seconds);
  RunOptions options;
  options.out = folder.path();
  options.threads = threads;
  options.observers = {first_step};
  const RunResult result = run_case(c, options);
  WholeRun whole;
  whole.pace = {seconds(), static_cast<double>(result.particle_steps)};
  whole.start_up = first_step->end();
  whole.particles = static_cast<double>(result.particles);
  whole.peak_bytes = memory_line("VmHWM") - before;
  return whole;
}

Pace steps_alone(const Case& c, int threads) {
  using Clock = std::chrono::steady_clock;
  omp_set_num_threads(threads);
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const Sampling sampling(c);
  Pace pace;
  const auto start = Clock::now();
  for (std::uint64_t k = 1; k <= sampling.last(); ++k) {  // a step ends at each sample
    advance(state, scene, sampling.time(k),
            [&](const StepReport&) { pace.particle_steps += static_cast<double>(state.grid.particle_count()); });
  }
  pace.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return pace;
}

}  // namespace mpm::benchmarks
