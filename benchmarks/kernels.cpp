#include "kernels.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "mpm/stress.hpp"

namespace mpm::benchmarks {

namespace {

using Clock = std::chrono::steady_clock;
double seconds(Clock::time_point from, Clock::time_point to) { return std::chrono::duration<double>(to - from).count(); }

}  // namespace

TransferOptions transfer_options(const Scene& scene, double dt) {
  return {dt, density(scene), scene.transfer == Transfer::apic, scene.flip_ratio};
}

void gather(Grid& grid, const TransferOptions& options) {
  const auto blocks = grid.occupied_blocks();
#pragma omp parallel for schedule(dynamic, blocks_at_a_time)
  for (std::size_t i = 0; i < blocks.size(); ++i) grid_to_particle(grid, blocks[i], options, moved_next(blocks, i));
}

void apply_law(Grid& grid, const AnyMaterial& material, double dt) {
  const auto blocks = grid.occupied_blocks();
  int faults = 0;
#pragma omp parallel for schedule(dynamic, 2) reduction(+ : faults)
  for (std::size_t i = 0; i < blocks.size(); ++i) faults += update_stress(grid, blocks[i], material, dt) ? 0 : 1;
  if (faults > 0) throw std::runtime_error("the law gave a stress that is not finite");
}

void sort(Grid& grid) {
  const auto blocks = grid.occupied_blocks();
#pragma omp parallel for schedule(dynamic, 2)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    BlockMotion motion;
    collect_migrants(grid, blocks[i], motion);
  }
  grid.migrate();
}

void update_nodes(Problem& problem, double dt) {
  const Scene& scene = problem.scene;
  std::vector<Impulse> impulses;
  fold_mirror_planes(problem.state.grid, scene.mirror_x, scene.mirror_y);
  update_grid(problem.state.grid, scene.boundaries, scene.gravity, dt, problem.state.time, scene.mirror_x, scene.mirror_y, impulses);
}

StepTimes step_in_parts(Problem& problem, double dt) {
  Grid& grid = problem.state.grid;
  const TransferOptions options = transfer_options(problem.scene, dt);
  StepTimes times;
  const auto start = Clock::now();
  particle_to_grid(grid, options);
  const auto scattered = Clock::now();
  update_nodes(problem, dt);
  const auto updated = Clock::now();
  const auto blocks = grid.occupied_blocks();
  double gather_time = 0.0, law_time = 0.0, collect_time = 0.0, max_speed_squared = 0.0;
  int faults = 0;
#pragma omp parallel for schedule(dynamic, blocks_at_a_time) reduction(+ : gather_time, law_time, collect_time, faults) \
    reduction(max : max_speed_squared)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto a = Clock::now();
    BlockMotion motion = grid_to_particle(grid, blocks[i], options, moved_next(blocks, i));
    const auto b = Clock::now();
    motion.finite = update_stress(grid, blocks[i], problem.scene.material, dt) && motion.finite;
    const auto c = Clock::now();
    if (!motion.finite || !motion.within_reach) {
      ++faults;
      continue;
    }
    collect_migrants(grid, blocks[i], motion);
    max_speed_squared = std::max(max_speed_squared, motion.max_speed_squared);
    gather_time += seconds(a, b);
    law_time += seconds(b, c);
    collect_time += seconds(c, Clock::now());
  }
  if (faults > 0) throw std::runtime_error("the step is unstable");
  const auto moved = Clock::now();
  grid.migrate();
  const auto sorted = Clock::now();
  problem.state.max_speed = std::sqrt(max_speed_squared);
  problem.state.time += dt;
  ++problem.state.step;
  times.particle_to_grid = seconds(start, scattered);
  times.grid_update = seconds(scattered, updated);
  const double wall_per_thread_time = seconds(updated, moved) / (gather_time + law_time + collect_time);
  times.grid_to_particle = gather_time * wall_per_thread_time;
  times.law = law_time * wall_per_thread_time;
  times.sort = collect_time * wall_per_thread_time + seconds(moved, sorted);
  return times;
}

}  // namespace mpm::benchmarks
