#include "kernels.hpp"

#include <stdexcept>

#include "libmpm/core/stress_update.hpp"

namespace mpm::benchmarks {

TransferOptions transfer_options(const Scene& scene, double dt) {
  return {.dt = dt,
          .density = density(scene),
          .affine = scene.numerics.transfer != Transfer::flip,
          .retained = scene.numerics.transfer == Transfer::flip ? scene.numerics.flip_ratio : 0.0,
          .shock_viscosity = keeps_compaction(scene.material) ? scene.numerics.shock_viscosity : 0.0};
}

void gather(Grid& grid, const TransferOptions& options) {
  const auto blocks = grid.occupied_blocks();
#pragma omp parallel for schedule(dynamic, blocks_at_a_time)
  for (std::size_t i = 0; i < blocks.size(); ++i) grid_to_particle(grid, blocks[i], options, moved_next(blocks, i));
}

void apply_law(Grid& grid, const AnyMaterial& material, double dt) {
  const auto blocks = grid.occupied_blocks();
  int failures = 0;
#pragma omp parallel for schedule(dynamic, 2) reduction(+ : failures)
  for (std::size_t i = 0; i < blocks.size(); ++i) failures += update_stress(grid, blocks[i], material, dt) ? 0 : 1;
  if (failures > 0) throw std::runtime_error("the law gave a stress that is not finite");
}

void sort(Grid& grid) {
  const auto blocks = grid.occupied_blocks();
#pragma omp parallel for schedule(dynamic, 2)
  for (std::size_t i = 0; i < blocks.size(); ++i) collect_migrants(grid, blocks[i]);
  grid.migrate();
}

void update_nodes(Problem& problem, double dt) {
  const Scene& scene = problem.scene;
  Grid& grid = problem.state.grid;
  add_mirror_images(grid, scene.mirror, NodeFields(grid), grid.own_blocks());
  const GridConditions conditions{.boundaries = scene.boundaries,
                                  .layered = scene.layered,
                                  .gravity = scene.gravity,
                                  .mirror = scene.mirror,
                                  .density = density(scene)};
  (void)update_grid(grid, conditions, dt, problem.state.time).total(one_rank());
}

void set_uniform_velocity(Grid& grid) {
  for (const auto b : grid.own_blocks()) {
    for (Node& n : grid.velocities(b).node) n = Node{1.0, 1.0, 1.0, 1.0};
  }
}

}  // namespace mpm::benchmarks
