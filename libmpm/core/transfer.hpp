#pragma once
/// The two transfers of the Material Point Method on quadratic B-splines, in the affine (moving-least-squares) form
/// of APIC: Jiang et al. 2015; Hu et al. 2018.
///
///   particle_to_grid   m_i = sum_p w_ip m_p
///                      p_i = sum_p w_ip ( m_p v_p + A_p (x_i - x_p) ),   A_p = m_p C_p - dt V_p^0 (4/dx^2) tau_p
///   grid_to_particle   v_p = sum_i w_ip v_i,   C_p = (4/dx^2) sum_i w_ip v_i (x_i - x_p)^T,   x_p += dt sum_i w_ip v_i
///
/// The second term of A_p is the internal force -V_p^0 tau_p grad w_ip times dt, with grad w_ip = (4/dx^2) w_ip (x_i - x_p).
///
/// Where material is compressed, d = tr C_p < 0, the force also has the viscous pressure of von Neumann & Richtmyer (1950), quadratic in d:
///   tau_p - q I,   q = rho_0 dx^2 |d| min(c_2 |d|, shock_stability/dt)
/// Without it nothing dissipates the energy that a shock must lose: the stress overshoots and rings behind it, and the overshoot compacts
/// snow for good, to another state than that of the jump conditions, on any grid. It acts where the material bears no stress, too: before a
/// shock in fresh snow, and in torn snow that closes up. In a smooth flow q falls with dx^2; a linear term would
/// lower the order of waves. Strong smooth waves lose accuracy nevertheless (manufactured_solution: order 1 in place of 2), so that step()
/// uses it only for laws that keep compaction: others forget an overshoot. The second bound keeps the step stable: a viscosity nu damps the
/// roughest field that C sees, k <= 1.3/dx, without overshoot while nu k^2 dt <= 1/2.
///
/// How it is computed (both transfers):
/// - Per block, on the contiguous 6x6x6 halo of its nodes; blocks of one colour in parallel, colour after colour.
/// - Per cell, two particles at a time: a Lanes holds {a_x, a_y, a_z, a_m | b_x, b_y, b_z, b_m} for particles a and b of one cell,
///   so that one fused multiply-add updates a whole node for both, with no transposition of the 192-byte records; one particle if
///   registers are shorter. Single records go four at a time, with velocities, momenta and nodes relative to RecordFrame::velocity.
/// - The 27-node sums are factored axis by axis (spline_sums.hpp).

#include <cstdint>

#include "libmpm/core/grid.hpp"

namespace mpm {

/// Options of a transfer. With v^0 the grid's velocity before forces, a particle retains a fraction of the part of its velocity
/// that is not representable on the grid:
///   v_p <- S v + retained (v_p - S v^0)
/// APIC: retained = 0. FLIP: flip_ratio. AFLIP: 1 - min(1, dt/t_ref). The same for C_p was tried: it costs a
/// sixth of a step, and the force on a plate then changes by 3 % over CFL numbers from 0.1 to 0.8 in place of 5 %.
struct TransferOptions {
  double dt = 0.0;               ///< s
  double density = 0.0;          ///< rho_0, kg/m^3
  bool affine = true;            ///< particles give C_p to the grid, too
  double retained = 0.0;         ///< 0 .. 1; above 0 it needs Grid::keep_forces_apart
  double shock_viscosity = 0.0;  ///< c_2 of the viscosity of shocks
};

/// m_i and p_i on all nodes; overwrites Grid::momenta. If forces are kept apart, the momentum of the internal forces over dt is not part of
/// p_i; it goes to Grid::force_impulses.
void particle_to_grid(Grid& grid, const TransferOptions& options);

/// Outcome of moving the particles of one block.
struct BlockMotion {
  double max_speed_squared = 0.0;  ///< m^2/s^2
  bool finite = true;              ///< false: update_stress found a non-finite value (a non-finite velocity spreads to C and to the stress)
  bool within_reach = true;        ///< false: a particle left its block by more than a block in one step
};

/// New velocity, affine matrix and position of one block's particles, and their new cells (with single records, a new velocity of the
/// block, too); a particle that left the block has ParticleBin::left_block as its cell.
/// @param next block that the same thread moves next: its first particles are prefetched
BlockMotion grid_to_particle(Grid& grid, std::int32_t block, const TransferOptions& options, std::int32_t next = no_block);

inline constexpr double shock_stability = 0.25;     ///< bound of the viscosity of shocks, in dx^2/dt
inline constexpr std::size_t blocks_at_a_time = 4;  ///< blocks that a thread takes at once: schedule(dynamic, blocks_at_a_time)
/// The block that the thread of blocks[i] moves next; no_block behind the last of its chunk.
inline std::int32_t moved_next(std::span<const std::int32_t> blocks, std::size_t i) {
  return (i + 1) % blocks_at_a_time == 0 || i + 1 == blocks.size() ? no_block : blocks[i + 1];
}

/// Replaces the particle in a slot, and its cell. Before collect_migrants it may be anywhere within reach of a step.
void relocate(Grid& grid, std::int32_t block, int slot, const Particle& particle);

/// Moves the particles marked left_block into the block's outbox. @returns false if one crossed more than a block: the rest stays
bool collect_migrants(Grid& grid, std::int32_t block);

}  // namespace mpm
