#pragma once
/// Correction of accelerations around an obstacle for the error of the lumped mass matrix.
///
/// A node's acceleration is its force over its own mass. So it is the mean of the field over the part of its kernel where there is
/// material. A wall cuts kernels off, and the mean is then that of a place up to half a cell before the wall. Along an endless plane the
/// pressure gradient does not change across the layer, and there is nothing to correct. Along a curved wall it falls like (R/r)^3 with the
/// distance r from the axis: the flow at the wall is accelerated too little (21 % in the first cell at R = 4 dx). At the edge of a side it
/// is steeper still.
///
/// The consistent mass matrix M_ij = sum_p m_p w_ip w_jp (Burgess, Sulsky & Brackbill 1992) does not have this error. One step of the
/// iteration towards it, from the lumped masses m_i (the second-order FMPM of Nairn & Hammerquist 2021, for accelerations):
///   v_i += (1/m_i) sum_p m_p w_ip (a_i - a_p - S_p (x_i - x_p)) dt,     a_p = sum_j w_jp a_j
/// S_p is the skew part of the gradient of a at the particle (of APIC's C_p, made of a), with APIC: without this term angular momentum,
/// which APIC conserves, would change. The other transfers do not conserve it, and S_p = 0: at an edge, where the wall pushes the nodes
/// before it and not those beside it, S_p takes a part of the correction away (force on a plate of six cells in a jet 1.02 of the exact one
/// without it, 1.04 with it).
/// The part of the motion that relaxes to the grid's velocity (transfer.hpp) is smoothed in the same way, beyond its linear part:
///   v_i += (r/m_i) sum_p m_p w_ip (u_i - u_p - C_p (x_i - x_p)),       u before forces, r the fraction relaxed in the step
/// Each particle's terms have no sum and with APIC no moment, so that momentum, and there angular momentum, are conserved exactly.
/// Particles within full_reach of the wall take part fully, those beyond to a part that falls to zero over `fade`: an abrupt end would
/// leave an error of its own (5 % of the acceleration there).

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"

namespace mpm {

/// Whether one of the boundaries needs the correction.
[[nodiscard]] bool need_lumped_mass_correction(std::span<const Boundary> boundaries);

/// Correction of lumped masses around solids.
class LumpedMassCorrection {
 public:
  static constexpr double full_reach = 2.5;  ///< cells from the surface
  static constexpr double fade = 3.0;        ///< cells

  /// @param solids  they must outlive this. @param density  of the material at rest, kg/m^3. @param relaxed  r, 0 .. 1; 1 for APIC
  LumpedMassCorrection(std::vector<const UprightSolid*> solids, double cell_size, double density, double relaxed)
      : solids_(std::move(solids)), dx_(cell_size), density_(density), relaxed_(relaxed) {}

  /// Weight of the correction for a particle at x (m), 0 .. 1, by its distance from the nearest solid.
  [[nodiscard]] double weight(const Vec3& x) const;
  /// Whether particles of a column of blocks may take part. @param x,y  of its blocks' coordinates
  [[nodiscard]] bool reaches(std::int32_t x, std::int32_t y) const;
  /// A rectangle that holds all these columns: coordinates x, y of their blocks. It is the same on all ranks.
  [[nodiscard]] Eigen::AlignedBox2i columns() const;

  /// Adds m_i times the change of v_i to `correction`, kg m/s, by index of block, as particle_to_grid adds to nodes. Reads velocities and
  /// those before forces, both with their images behind mirror planes. Outer blocks (ranks.hpp) come last, because they read those of
  /// ghosts, which arrive meanwhile. Sums in the order of colours: the same bits on any number of threads.
  /// @{
  void add_inner(const Grid& grid, std::span<NodeBlock> correction) const;
  void add_outer(const Grid& grid, std::span<NodeBlock> correction) const;
  /// @}

 private:
  /// How the particles of a cell take part: weight 0, 0 to 1, or 1. It saves the distances of most particles.
  enum class Part : std::uint8_t { none, fading, full };
  /// Of the cells of a block; none also where there are no particles.
  [[nodiscard]] std::array<Part, block_nodes> parts_of(const Block& block) const;
  void add_of_blocks(const Grid& grid, std::span<const std::int32_t> blocks, bool outer, std::span<NodeBlock> correction) const;
  void add_of_block(const Grid& grid, const Block& block, std::span<NodeBlock> correction) const;

  std::vector<const UprightSolid*> solids_;
  double dx_, density_, relaxed_;
};

/// Corrects the velocities near all boundaries that need it. The accelerations that are corrected are those with contact, so the boundaries
/// act once on trial; the velocities of before are then restored and corrected. The grid must keep forces apart.
/// @param density, relaxed  as in LumpedMassCorrection. @param try_boundaries  lets the boundaries act on the columns of nodes that begin
/// in the given blocks
void correct_lumped_mass(Grid& grid, std::span<const Boundary> boundaries, double density, double relaxed, const MirrorPlanes& mirror,
                         const std::function<void(std::span<const std::int32_t>)>& try_boundaries);

}  // namespace mpm
