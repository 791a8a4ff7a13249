/// The benchmarks: single kernels and whole steps. Names: kernel/problem/particles/threads. Without --benchmark_filter a default set runs,
/// in a few minutes; --benchmark_filter=. runs all, --benchmark_list_tests shows them. Every timed result is checked, outside the
/// timed region.

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "ceilings.hpp"
#include "kernels.hpp"
#include "libmpm/base/process.hpp"
#include "libmpm/driver/build_info.hpp"
#include "plain_reference.hpp"
#include "reference_problem.hpp"
#include "whole_run.hpp"
#include "work_per_particle.hpp"

namespace mpm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int repetitions = 9;  ///< medians of at least nine
constexpr std::size_t steady_work =
    2 << 20;  ///< fewest particles of a repetition, so that its time is long compared with the clock's resolution

double seconds_of(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string size_name(std::size_t particles) {
  return particles >= 1'000'000 ? fmt::format("{}M", (particles + 500'000) / 1'000'000) : fmt::format("{}k", (particles + 500) / 1000);
}

/// Counters: bandwidth and arithmetic relative to the ceilings, and which of the two is the limit.
void report(benchmark::State& bench, double seconds_per_pass, std::size_t particles, int threads, const Work& work) {
  const Ceilings& top = ceilings(threads);
  const double count = static_cast<double>(particles), ns = 1e9 * seconds_per_pass / count;
  const double memory_ns = 1e9 * work.bytes / top.bytes_per_second, arithmetic_ns = 1e9 * work.flops / top.flops_per_second;
  auto& counters = bench.counters;
  counters["particles"] = count;
  counters["ns"] = ns;
  counters["M/s"] = 1e3 / ns;
  counters["bytes"] = work.bytes;
  counters["flops"] = work.flops;
  counters["of_stream"] = memory_ns / ns;
  counters["of_fma"] = arithmetic_ns / ns;
  counters["stream_GB/s"] = 1e-9 * top.bytes_per_second;
  counters["fma_GFLOP/s"] = 1e-9 * top.flops_per_second;
  bench.SetLabel(memory_ns > arithmetic_ns ? "memory binds" : "arithmetic binds");
}

/// A kernel that can be run any number of times on the same data.
struct Bench {
  std::size_t particles = 0;
  Work work;
  std::function<void()> prepare;  ///< before every pass, not timed
  std::function<void()> pass;
  std::function<void()> check;  ///< after the last pass; throws if the result is wrong
};

/// Google Benchmark calls a benchmark once for each repetition; the first call builds the problem.
class Cache {
 public:
  template <class Make>
  auto& get(const std::string& name, Make&& make) {
    using Value = decltype(make());
    if (name != name_) {
      value_.reset();  // before the next is built: the largest take gigabytes
      value_ = std::make_shared<Value>(make());
      name_ = name;
    }
    return *static_cast<Value*>(value_.get());
  }
  static Cache& instance() {
    static Cache cache;
    return cache;
  }

 private:
  std::string name_;
  std::shared_ptr<void> value_;
};

/// Runs only at its first repetition.
class Once {
 public:
  template <class F>
  void operator()(const std::string& name, F&& f) {
    if (done_.insert(name).second) f();
  }

 private:
  std::set<std::string> done_;
} check_once;

void run_kernel(benchmark::State& bench, const std::string& name, int threads, const std::function<std::shared_ptr<Bench>()>& make) {
  omp_set_num_threads(threads);
  try {
    ceilings(threads);
    Bench& kernel = *Cache::instance().get(name, make);
    kernel.prepare();
    kernel.pass();
    double sum = 0.0;
    for ([[maybe_unused]] auto _ : bench) {
      kernel.prepare();
      const double seconds = seconds_of(kernel.pass);
      bench.SetIterationTime(seconds);
      sum += seconds;
    }
    report(bench, sum / static_cast<double>(bench.iterations()), kernel.particles, threads, kernel.work);
    check_once(name, kernel.check);
  } catch (const std::exception& error) {
    bench.SkipWithError(error.what());
  }
}

// --- kernels ------------------------------------------------------------------------------------------------------------

/// A block and the result of the kernels.
struct Kernel : Bench {
  explicit Kernel(Problem p) : problem(std::move(p)), options(transfer_options(problem.scene, transfer_step)) {
    particles = problem.state.grid.particle_count();
  }
  Problem problem;
  TransferOptions options;
  std::vector<Particle> before;
};

std::shared_ptr<Kernel> kernel_on(Problem problem) {
  auto k = std::make_shared<Kernel>(std::move(problem));
  k->prepare = [] {};
  return k;
}

std::shared_ptr<Bench> scatter_bench(Problem problem, double per_cell) {
  auto k = kernel_on(std::move(problem));
  k->work = particle_to_grid_work(per_cell);
  k->pass = [k = k.get()] { particle_to_grid(k->problem.state.grid, k->options); };
  k->check = [k = k.get()] { check_scatter(k->problem.state.grid, k->options); };
  return k;
}

/// With dt = 0 the particles get the grid's velocities and do not move, so that all passes are equal.
std::shared_ptr<Bench> gather_bench(Problem problem, double per_cell) {
  auto k = kernel_on(std::move(problem));
  k->before = copy_particles(k->problem.state.grid);
  particle_to_grid(k->problem.state.grid, k->options);
  update_nodes(k->problem, k->options.dt);
  k->work = grid_to_particle_work(per_cell);
  k->pass = [k = k.get()] {
    TransferOptions still = k->options;
    still.dt = 0.0;
    gather(k->problem.state.grid, still);
  };
  k->check = [k = k.get()] { check_nodes_and_gather(k->problem, k->before, k->options); };
  return k;
}

std::shared_ptr<Bench> law_bench(std::size_t particles, LawRegime regime) {
  auto k = kernel_on(make_law_points(particles, regime));
  k->before = copy_particles(k->problem.state.grid);
  k->work = regime == LawRegime::elastic ? unyielding_law_work() : yielding_law_work();
  k->prepare = [k = k.get()] { put_back(k->before, k->problem.state.grid); };
  k->pass = [k = k.get()] { apply_law(k->problem.state.grid, k->problem.scene.material, law_step); };
  k->check = [k = k.get()] { check_law(k->problem, k->before, law_step); };
  return k;
}

/// A transfer restores the nodes' momenta before every pass.
std::shared_ptr<Bench> grid_bench(Problem problem, double per_cell) {
  auto k = kernel_on(std::move(problem));
  k->before = copy_particles(k->problem.state.grid);
  k->work = grid_update_work(per_cell);
  k->prepare = [k = k.get()] { particle_to_grid(k->problem.state.grid, k->options); };
  k->pass = [k = k.get()] { update_nodes(k->problem, k->options.dt); };
  k->check = [k = k.get()] {
    TransferOptions still = k->options;
    still.dt = 0.0;
    gather(k->problem.state.grid, still);
    check_nodes_and_gather(k->problem, k->before, k->options);
  };
  return k;
}

/// The block moves to and fro by 4 % of a cell along every axis: about 12 % of the particles change cell, 3 % change block.
std::shared_ptr<Bench> sort_bench(Problem problem) {
  auto k = kernel_on(std::move(problem));
  constexpr double shift = 0.04, changing_block = 0.03;
  k->work = sort_work(changing_block);
  k->prepare = [k = k.get(), forward = true]() mutable {
    Grid& grid = k->problem.state.grid;
    set_uniform_velocity(grid);
    TransferOptions options = k->options;
    options.dt = (forward ? 1.0 : -1.0) * shift * grid.cell_size();
    forward = !forward;
    gather(grid, options);
  };
  k->pass = [k = k.get()] { sort(k->problem.state.grid); };
  k->check = [k = k.get()] { check_order(k->problem.state.grid, k->particles); };
  return k;
}

// --- whole steps --------------------------------------------------------------------------------------------------------

constexpr std::array part_names{"p2g_ns", "grid_ns", "g2p_ns", "law_ns", "sort_ns"};

/// The times of the parts of a step, s, in the order of part_names.
std::array<double, 5> parts_of(const StepTimes& t) { return {t.particle_to_grid, t.grid_update, t.grid_to_particle, t.stress, t.sort}; }

double quantile(std::vector<double> v, double fraction) {
  std::sort(v.begin(), v.end());
  return v[static_cast<std::size_t>(std::lround(fraction * static_cast<double>(v.size() - 1)))];
}
double median(std::vector<double> v) { return quantile(std::move(v), 0.5); }

/// Steps are counted only if the required fractions of particles yield and change cell. Every other step is done in parts: their
/// nanoseconds (medians), and sum_over_step, the median of the sum of the parts over the median of the whole steps.
void run_step(benchmark::State& bench, const std::string& name, int threads, const std::function<SteppedProblem()>& make) {
  omp_set_num_threads(threads);
  try {
    ceilings(threads);
    SteppedProblem& problem = *Cache::instance().get(name, [&] { return std::make_shared<SteppedProblem>(make()); });
    Activity least{1.0, 1.0, 1.0}, sum;
    std::vector<double> whole, together;
    std::array<std::vector<double>, part_names.size()> parts;
    const auto note = [&](const Activity& s) {
      least = {std::min(least.yielding, s.yielding), std::min(least.changing_cell, s.changing_cell),
               std::min(least.changing_block, s.changing_block)};
      sum.yielding += s.yielding;
      sum.changing_block += s.changing_block;
    };
    double total = 0.0;
    for ([[maybe_unused]] auto _ : bench) {
      double seconds = 0.0;
      note(problem.counted_step([&](Problem& p, double dt) { seconds = seconds_of([&] { step(p.state, p.scene, dt); }); }));
      bench.SetIterationTime(seconds);
      whole.push_back(seconds);
      total += seconds;
      StepTimes t;
      problem.counted_step([&](Problem& p, double dt) { step(p.state, p.scene, dt, &t); });
      for (std::size_t i = 0; i < parts.size(); ++i) parts[i].push_back(parts_of(t)[i]);
      together.push_back(t.total());
    }
    const std::size_t particles = problem.problem().state.grid.particle_count();
    const auto count = static_cast<double>(whole.size());
    report(bench, total / count, particles, threads, step_work(8.0, sum.yielding / count, sum.changing_block / count));
    for (std::size_t i = 0; i < parts.size(); ++i) bench.counters[part_names[i]] = 1e9 * median(parts[i]) / static_cast<double>(particles);
    bench.counters["sum_over_step"] = median(together) / median(whole);
    bench.counters["memory_bytes"] = static_cast<double>(problem.problem().state.grid.bytes()) / static_cast<double>(particles);
    bench.counters["yielding"] = least.yielding;
    bench.counters["changing_cell"] = least.changing_cell;
    bench.counters["changing_block"] = least.changing_block;
    bench.counters["seedings"] = problem.seedings();
    check_once(name, [&] {
      const std::vector<Particle> before = copy_particles(problem.problem().state.grid);
      const double time = problem.problem().state.time, dt = stable_time_step(problem.problem().state, problem.problem().scene);
      step(problem.problem().state, problem.problem().scene, dt);
      check_step(problem.problem(), before, dt, time);
    });
  } catch (const std::exception& error) {
    bench.SkipWithError(error.what());
  }
}

/// Whole steps in double and in single precision in turns, on one thread: median nanoseconds of both, and the median of the ratios of the
/// pairs with its quartiles. The parts are those of further steps.
void run_both_precisions(benchmark::State& bench, const std::string& name, const std::function<SteppedProblem(Precision)>& make) {
  omp_set_num_threads(1);
  try {
    constexpr std::array precisions{Precision::double_precision, Precision::single_precision};
    using Problems = std::vector<SteppedProblem>;
    Problems& problems = *Cache::instance().get(name, [&] {
      Problems both;
      for (const Precision p : precisions) both.push_back(make(p));
      return std::make_shared<Problems>(std::move(both));
    });
    std::array<std::vector<double>, 2> ns;
    std::array<std::array<std::vector<double>, part_names.size()>, 2> parts;
    std::vector<double> ratios;
    const auto count = static_cast<double>(problems[0].problem().state.grid.particle_count());
    const auto timed_step = [&](std::size_t which) {
      double seconds = 0.0;
      problems[which].counted_step([&](Problem& p, double dt) {
        const double start = thread_seconds();
        step(p.state, p.scene, dt);
        seconds = thread_seconds() - start;
      });
      ns[which].push_back(1e9 * seconds / count);
    };
    const auto step_in_parts = [&](std::size_t which) {
      StepTimes t;
      problems[which].counted_step([&](Problem& p, double dt) { step(p.state, p.scene, dt, &t); });
      for (std::size_t i = 0; i < part_names.size(); ++i) parts[which][i].push_back(1e9 * parts_of(t)[i] / count);
    };
    for ([[maybe_unused]] auto _ : bench) {
      const std::size_t first = ratios.size() % 2;
      timed_step(first);
      timed_step(1 - first);
      ratios.push_back(ns[1].back() / ns[0].back());
      bench.SetIterationTime(1e-9 * count * ns[1].back());
      step_in_parts(first);
      step_in_parts(1 - first);
    }
    auto& counters = bench.counters;
    counters["particles"] = count;
    counters["ratio"] = median(ratios);
    counters["ratio_quartile_1"] = quantile(ratios, 0.25);
    counters["ratio_quartile_3"] = quantile(ratios, 0.75);
    for (std::size_t which = 0; which < 2; ++which) {
      const std::string prefix = fmt::format("{}_", name_of(precisions[which]));
      counters[prefix + "ns"] = median(ns[which]);
      for (std::size_t i = 0; i < part_names.size(); ++i) counters[prefix + part_names[i]] = median(parts[which][i]);
      counters[prefix + "memory_bytes"] = static_cast<double>(problems[which].problem().state.grid.bytes()) / count;
    }
    check_once(name, [&] {
      for (SteppedProblem& p : problems) check_order(p.problem().state.grid, p.problem().state.grid.particle_count());
      const double wide = problems[0].problem().state.max_speed, narrow = problems[1].problem().state.max_speed;
      if (!(std::abs(wide - narrow) <= 1e-2 * wide))
        throw std::runtime_error(fmt::format("fastest particles: {} and {} m/s", wide, narrow));
    });
  } catch (const std::exception& error) {
    bench.SkipWithError(error.what());
  }
}

// --- whole runs ---------------------------------------------------------------------------------------------------------

/// A run from start to end, and what it is compared with.
struct RunSize {
  std::size_t particles;
  double duration;        ///< of the flow, s
  bool compares_to_512k;  ///< also with the steps of a run of 512 k particles
  int repetitions;
};

/// A whole run and its steps alone in turns. `run_over_step`: the speed of the run over that of its steps; `run_over_512k`: over that of
/// the steps of 512 k particles.
void run_whole(benchmark::State& bench, const RunSize& size, int threads, Precision precision) {
  static unsigned turn = 0;
  try {
    constexpr std::size_t large = 512'000;
    constexpr double large_duration = 0.06;  // s
    const Case c = avalanche_case(size.particles, precision, size.duration);
    WholeRun run;
    Pace steps, of_large;
    for ([[maybe_unused]] auto _ : bench) {
      const bool steps_first = turn++ % 2 == 0;
      if (steps_first) steps = steps_alone(c, threads);
      run = whole_run(c, threads);
      if (!steps_first) steps = steps_alone(c, threads);
      if (size.compares_to_512k) of_large = steps_alone(avalanche_case(large, precision, large_duration), threads);
      bench.SetIterationTime(run.pace.seconds);
    }
    if (run.pace.particle_steps != steps.particle_steps) throw std::runtime_error("the run and its steps alone differ");
    auto& counters = bench.counters;
    counters["particles"] = run.particles;
    counters["M/s"] = 1e-6 * run.pace.speed();
    counters["run_over_step"] = run.pace.speed() / steps.speed();
    if (size.compares_to_512k) counters["run_over_512k"] = run.pace.speed() / of_large.speed();
    counters["start_up_s"] = run.start_up;
    counters["peak_bytes"] = run.peak_bytes / run.particles;
  } catch (const std::exception& error) {
    bench.SkipWithError(error.what());
  }
}

// --- the list -----------------------------------------------------------------------------------------------------------

struct Registry {
  bool all;  ///< false: only the default set

  template <class F>
  void add(bool by_default, const std::string& name, std::size_t particles, F&& run) const {
    if (!by_default && !all) return;
    const auto passes = static_cast<benchmark::IterationCount>(std::max<std::size_t>(1, steady_work / std::max<std::size_t>(1, particles)));
    benchmark::RegisterBenchmark(name.c_str(), std::forward<F>(run))
        ->UseManualTime()
        ->Iterations(passes)
        ->Repetitions(repetitions)
        ->ReportAggregatesOnly(true)
        ->Unit(benchmark::kMillisecond);
  }

  void add_kernel(bool by_default, const std::string& kernel, std::size_t particles,
                  const std::function<std::shared_ptr<Bench>()>& make) const {
    for (const int threads : {1, 2}) {
      const std::string name = fmt::format("{}/{}/threads:{}", kernel, size_name(particles), threads);
      add(by_default, name, particles, [=](benchmark::State& bench) { run_kernel(bench, name, threads, make); });
    }
  }

  void add_both_precisions(bool by_default, const std::string& problem, std::size_t particles,
                           const std::function<SteppedProblem(Precision)>& make) const {
    const std::string name = fmt::format("step_by_precision/{}/{}/threads:1", problem, size_name(particles));
    add(by_default, name, particles, [=](benchmark::State& bench) { run_both_precisions(bench, name, make); });
  }

  void add_step(bool by_default, const std::string& problem, std::size_t particles, const std::function<SteppedProblem()>& make) const {
    for (const int threads : {1, 2}) {
      const std::string name = fmt::format("step/{}/{}/threads:{}", problem, size_name(particles), threads);
      add(by_default, name, particles, [=](benchmark::State& bench) { run_step(bench, name, threads, make); });
    }
  }
};

void run_ceiling(benchmark::State& bench, int threads) {
  const Ceilings& top = ceilings(threads);
  for ([[maybe_unused]] auto _ : bench) bench.SetIterationTime(1.0);  // not timed: the counters are the result
  bench.counters["stream_GB/s"] = 1e-9 * top.bytes_per_second;
  bench.counters["fma_GFLOP/s"] = 1e-9 * top.flops_per_second;
}

void register_all(const Registry& registry) {
  for (const int threads : {1, 2}) {
    benchmark::RegisterBenchmark(fmt::format("ceilings/threads:{}", threads).c_str(),
                                 [=](benchmark::State& bench) { run_ceiling(bench, threads); })
        ->UseManualTime()
        ->Iterations(1);
  }
  constexpr std::size_t k64 = 64 << 10, k512 = 512'000, m1 = 1'000'000, m8 = 8'000'000;
  struct Transfer {
    const char* name;
    std::shared_ptr<Bench> (*make)(Problem, double);
  };
  for (const Transfer& transfer :
       {Transfer{"particle_to_grid", scatter_bench}, Transfer{"grid_to_particle", gather_bench}, Transfer{"grid_update", grid_bench}}) {
    for (const std::size_t particles : {k64, k512, m1, m8}) {
      for (const int per_cell : {1, 8, 27}) {
        for (const bool jitter : {true, false}) {
          registry.add_kernel(particles == k512 && per_cell == 8 && jitter,
                              fmt::format("{}/{}block:{}", transfer.name, jitter ? "jittered_" : "", per_cell), particles,
                              [=] { return transfer.make(make_block(particles, per_cell, jitter), per_cell); });
        }
      }
    }
    registry.add_kernel(false, fmt::format("{}/avalanche", transfer.name), k512, [=] { return transfer.make(make_avalanche(k512), 8.0); });
  }
  struct Law {
    const char* name;
    LawRegime regime;
  };
  for (const Law& law : {Law{"elastic", LawRegime::elastic}, Law{"yielding", LawRegime::yielding}, Law{"apexes", LawRegime::apexes},
                         Law{"zero_slope", LawRegime::zero_slope}}) {
    for (const std::size_t particles : {k64, k512, m8}) {
      registry.add_kernel(particles == k512, fmt::format("law/{}", law.name), particles, [=] { return law_bench(particles, law.regime); });
    }
  }
  for (const std::size_t particles : {k64, k512, m1, m8}) {
    for (const int per_cell : {1, 8, 27}) {
      registry.add_kernel(particles == k512 && per_cell == 8, fmt::format("sort/jittered_block:{}", per_cell), particles,
                          [=] { return sort_bench(make_block(particles, per_cell, true)); });
    }
  }
  // the default set holds the shortest only: the others take minutes
  for (const RunSize& size : {RunSize{25'000, 2.0, true, 5}, RunSize{113'000, 1.0, false, 5}, RunSize{k512, 0.1, false, 3}}) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      for (const int threads : {1, 2}) {
        const std::string name =
            fmt::format("whole_run/avalanche_{}/{}/threads:{}", name_of(precision), size_name(size.particles), threads);
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& bench) { run_whole(bench, size, threads, precision); })
            ->UseManualTime()
            ->Iterations(1)
            ->Repetitions(size.repetitions)
            ->ReportAggregatesOnly(true)
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
  constexpr double reference_volume = 8.0;  // m^3
  for (const std::size_t particles : {k64, k512, m1, m8}) {
    const double dx = std::cbrt(8.0 * reference_volume / static_cast<double>(particles));
    const double cell = 1.0 / std::round(1.0 / dx);  // a whole number of cells along every edge
    registry.add_step(particles == k512, "reference", particles, [=] { return reference_problem(cell); });
    registry.add_step(false, "reference_partly_yielding", particles, [=] { return reference_problem(cell, Regime::partly_yielding); });
    registry.add_step(false, "reference_elastic", particles, [=] { return reference_problem(cell, Regime::elastic); });
    registry.add_step(particles == k512, "avalanche", particles, [=] { return avalanche_problem(particles); });
    registry.add_both_precisions(particles == k512, "reference", particles,
                                 [=](Precision p) { return reference_problem(cell, Regime::fully_yielding, p); });
    registry.add_both_precisions(particles == k512, "avalanche", particles, [=](Precision p) { return avalanche_problem(particles, p); });
  }
}

}  // namespace
}  // namespace mpm::benchmarks

int main(int argc, char** argv) {
  const auto asks = [&](std::string_view option) {
    return std::any_of(argv + 1, argv + argc, [=](const char* a) { return std::string_view(a).substr(0, option.size()) == option; });
  };
  mpm::benchmarks::register_all({asks("--benchmark_filter") || asks("--benchmark_list_tests")});
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const mpm::BuildInfo info = mpm::build_info();
  benchmark::AddCustomContext("commit", std::string(info.commit));
  benchmark::AddCustomContext("compiler", std::string(info.compiler));
  benchmark::AddCustomContext("instruction_set", std::string(info.instruction_set));
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
