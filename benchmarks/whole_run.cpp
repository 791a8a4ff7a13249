#include "whole_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/run.hpp"

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

Case avalanche(std::size_t particles, Precision precision) {
  constexpr double volume = 12.0 * 10.5 * 1.75;  // m^3, of the half that is computed
  const double cell = std::cbrt(8.0 * volume / static_cast<double>(particles));
  return parse_case(fmt::format(R"([material]
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 5.0
[conveyor]
froude_number = 3.0
flow_height_m = 1.75
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
duration_s = 0.2
frames_per_second = 25
)",
                                cell, name_of(precision)),
                    "whole_run");
}

}  // namespace

WholeRun run_avalanche(std::size_t particles, int threads, Precision precision) {
  using Clock = std::chrono::steady_clock;
  const Folder folder;
  const Case c = avalanche(particles, precision);
  WholeRun whole;
  RunOptions options;
  options.out = folder.path();
  options.threads = threads;
  forget_peak();
  const double before = memory_line("VmRSS");
  const auto start = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  options.on_progress = [&](const Progress&) {
    if (whole.start_up == 0.0) whole.start_up = seconds();
  };
  const RunResult result = run_case(c, options);
  whole.seconds = seconds();
  whole.particle_steps = static_cast<double>(result.particle_steps);
  whole.step_seconds = result.results.number("solver_time_s");
  whole.particles = static_cast<double>(result.particles);
  whole.peak_bytes = memory_line("VmHWM") - before;
  return whole;
}

}  // namespace mpm::benchmarks
