/// One kernel on a small problem, run on demand: the regression tracker holds two of these, built from two source trees, and runs
/// them in turn, a few milliseconds each, so that disturbances affect both equally.
///
///   bench_paired KERNEL PARTICLES          serves stdin: each line "N" runs N passes and answers "NANOSECONDS" of thread time, a particle
///   and pass bench_paired KERNEL PARTICLES --once   runs one pass inside measured_pass() and ends: for callgrind --toggle-collect
///   bench_paired --list                    the kernels
///
/// It uses one thread and measures its processor time, which excludes the time of other programs on the core.

#include <fmt/format.h>
#include <omp.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <string>

#include "kernels.hpp"
#include "reference_problem.hpp"

namespace mpm::benchmarks {
namespace {

struct Task {
  std::function<void()> prepare;  ///< not timed
  std::function<void()> pass;
};

constexpr Precision wide = Precision::double_precision, narrow = Precision::single_precision;

Task scatter_task(std::size_t particles, Precision precision) {
  auto p = std::make_shared<Problem>(make_block(particles, 8, true, precision));
  const TransferOptions options = transfer_options(p->scene, transfer_step);
  return {[] {}, [=] { particle_to_grid(p->state.grid, options); }};
}

Task grid_task(std::size_t particles) {
  auto p = std::make_shared<Problem>(make_block(particles, 8, true));
  const TransferOptions options = transfer_options(p->scene, transfer_step);
  return {[=] { particle_to_grid(p->state.grid, options); }, [=] { update_nodes(*p, transfer_step); }};
}

Task gather_task(std::size_t particles, Precision precision) {
  auto p = std::make_shared<Problem>(make_block(particles, 8, true, precision));
  TransferOptions options = transfer_options(p->scene, transfer_step);
  particle_to_grid(p->state.grid, options);
  update_nodes(*p, transfer_step);
  options.dt = 0.0;  // nothing moves: every pass is the same
  return {[] {}, [=] { gather(p->state.grid, options); }};
}

Task law_task(std::size_t particles, LawRegime regime, Precision precision = wide) {
  auto p = std::make_shared<Problem>(make_law_points(particles, regime, precision));
  const std::vector<Particle> before = copy_particles(p->state.grid);
  return {[=] { put_back(before, p->state.grid); }, [=] { apply_law(p->state.grid, p->scene.material, law_step); }};
}

/// Uniform motion to and fro by 4 % of a cell.
Task sort_task(std::size_t particles) {
  auto p = std::make_shared<Problem>(make_block(particles, 8, true));
  TransferOptions options = transfer_options(p->scene, 0.04 * p->state.grid.cell_size());
  return {[=]() mutable {
            set_uniform_velocity(p->state.grid);
            gather(p->state.grid, options);
            options.dt = -options.dt;
          },
          [=] { sort(p->state.grid); }};
}

/// The reference problem with larger cells. A step changes the state, so both programs of a pair do the same number of them.
Task step_task(std::size_t particles, Precision precision) {
  constexpr double volume = 8.0;  // m^3
  const double cell = 1.0 / std::round(1.0 / std::cbrt(8.0 * volume / static_cast<double>(particles)));
  auto p = std::make_shared<SteppedProblem>(reference_problem(cell, Regime::fully_yielding, precision));
  return {[=, steps = 0]() mutable {
            constexpr int reseed_after = 150;  // the reference problem keeps its fractions for twice as many
            if (++steps % reseed_after == 0) p->seed();
          },
          [=] {
            Problem& problem = p->problem();
            step(problem.state, problem.scene, stable_time_step(problem.state, problem.scene));
          }};
}

const std::map<std::string, std::function<Task(std::size_t)>>& tasks() {
  static const std::map<std::string, std::function<Task(std::size_t)>> list = {
      {"particle_to_grid", [](std::size_t n) { return scatter_task(n, wide); }},
      {"particle_to_grid_single", [](std::size_t n) { return scatter_task(n, narrow); }},
      {"grid_update", grid_task},
      {"grid_to_particle", [](std::size_t n) { return gather_task(n, wide); }},
      {"grid_to_particle_single", [](std::size_t n) { return gather_task(n, narrow); }},
      {"law_elastic", [](std::size_t n) { return law_task(n, LawRegime::elastic); }},
      {"law_yielding", [](std::size_t n) { return law_task(n, LawRegime::yielding); }},
      {"law_yielding_single", [](std::size_t n) { return law_task(n, LawRegime::yielding, narrow); }},
      {"law_apexes", [](std::size_t n) { return law_task(n, LawRegime::apexes); }},
      {"sort", sort_task},
      {"step", [](std::size_t n) { return step_task(n, wide); }},
      {"step_single", [](std::size_t n) { return step_task(n, narrow); }},
  };
  return list;
}

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

/// callgrind starts and stops counting at this function.
__attribute__((noinline)) void measured_pass(const std::function<void()>& pass) { pass(); }

namespace {

int run(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--list") {
    for (const auto& [name, make] : tasks()) std::puts(name.c_str());
    return 0;
  }
  const bool once = argc == 4 && std::string(argv[3]) == "--once";
  const auto found = argc >= 3 ? tasks().find(argv[1]) : tasks().end();
  const long particles = argc >= 3 ? std::atol(argv[2]) : 0;
  if (found == tasks().end() || particles < 1 || (argc > 3 && !once)) {
    std::fputs("usage: bench_paired --list | bench_paired KERNEL PARTICLES [--once]\n", stderr);
    return 2;
  }
  omp_set_num_threads(1);
  const Task task = found->second(static_cast<std::size_t>(particles));
  task.prepare();
  task.pass();
  if (once) {
    task.prepare();
    measured_pass(task.pass);
    return 0;
  }
  int passes = 0;
  while (std::cin >> passes) {
    double seconds = 0.0;
    for (int i = 0; i < passes; ++i) {
      task.prepare();
      const double start = thread_seconds();
      task.pass();
      seconds += thread_seconds() - start;
    }
    fmt::print("{:.6g}\n", 1e9 * seconds / (static_cast<double>(passes) * static_cast<double>(particles)));
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace mpm::benchmarks

int main(int argc, char** argv) {
  try {
    return mpm::benchmarks::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_paired: %s\n", error.what());
    return 1;
  }
}
