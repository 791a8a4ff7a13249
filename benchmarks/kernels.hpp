#pragma once
/// The parts of step() as separate calls, in step()'s order, each to be timed alone. The one place that follows solver.cpp: whoever changes
/// how step() composes its kernels changes this too; bench_step checks that the parts take as long as the whole and leave the same
/// particles.

#include "problems.hpp"

namespace mpm::benchmarks {

TransferOptions transfer_options(const Scene& scene, double dt);

/// grid_to_particle on all blocks.
void gather(Grid& grid, const TransferOptions& options);
/// The law on all blocks. @throws std::runtime_error if a stress is not finite
void apply_law(Grid& grid, const AnyMaterial& material, double dt);
/// collect_migrants on all blocks, then Grid::migrate.
void sort(Grid& grid);
/// Folding, v_i = p_i / m_i + dt g, boundaries.
void update_nodes(Problem& problem, double dt);

/// Wall-clock seconds of the parts of one step.
struct StepTimes {
  double particle_to_grid = 0.0, grid_update = 0.0, grid_to_particle = 0.0, law = 0.0, sort = 0.0;
  [[nodiscard]] double sum() const { return particle_to_grid + grid_update + grid_to_particle + law + sort; }
};

/// One step as step() does it, watched by clocks. The transfer back, the law and the collection of migrants are done block by block
/// as there; the wall time of that loop is shared out in proportion to the threads' time in each. Particles are not removed at the domain's
/// end (step() tests every block for that), so the problem must stay inside it.
StepTimes step_in_parts(Problem& problem, double dt);

}  // namespace mpm::benchmarks
