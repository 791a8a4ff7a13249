#pragma once
/// The kernels of step() on all blocks, to be timed separately. The step itself reports the time of its own phases (StepTimes).

#include "libmpm/core/transfer.hpp"
#include "problems.hpp"

namespace mpm::benchmarks {

inline constexpr double transfer_step = 2e-4;  ///< s, of transfers that are timed alone

TransferOptions transfer_options(const Scene& scene, double dt);

/// grid_to_particle on all blocks.
void gather(Grid& grid, const TransferOptions& options);
/// The law on all blocks. @throws std::runtime_error if a stress is not finite
void apply_law(Grid& grid, const AnyMaterial& material, double dt);
/// collect_migrants on all blocks, then Grid::migrate.
void sort(Grid& grid);
/// Mirror images, v_i = p_i / m_i + dt g, boundaries.
void update_nodes(Problem& problem, double dt);
/// Gives all nodes the velocity (1, 1, 1) m/s.
void set_uniform_velocity(Grid& grid);

}  // namespace mpm::benchmarks
