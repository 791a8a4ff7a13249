#pragma once
/// Before a curved wall: what the lumped mass matrix does to accelerations, and its correction.
///
/// A node's acceleration is its force over its own mass. So it is the mean of the field over the part of its kernel where there is
/// material. A wall cuts kernels off, and the mean is then that of a place up to half a cell before the wall. Along a curved wall the
/// pressure gradient falls like (R/r)^3 with the distance r from the axis: the flow at the wall is accelerated too little (21 % in the
/// first cell at R = 4 dx). Along a plane the gradient does not change across the layer, and there is nothing to correct.
///
/// The consistent mass matrix M_ij = sum_p m_p w_ip w_jp (Burgess, Sulsky & Brackbill 1992) does not have this error. One step of the
/// iteration towards it, from the lumped masses m_i (the second-order FMPM of Nairn & Hammerquist 2021, for accelerations):
///   v_i += (1/m_i) sum_p m_p w_ip (a_i - a_p) dt,                      a_p = sum_j w_jp a_j
/// The part of the motion that relaxes to the grid's velocity (transfer.hpp) is smoothed in the same way, beyond its linear part:
///   v_i += (r/m_i) sum_p m_p w_ip (u_i - u_p - C_p (x_i - x_p)),       u before forces, r the relaxed share of the step
/// Each particle's terms sum to zero, so that momentum is conserved exactly. Particles within full_reach of the wall take part fully, those
/// beyond to a part that falls to zero over `fade`: an abrupt end would leave an error of its own (5 % of the acceleration there).

#include "libmpm/boundary/surface_solid.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"

namespace mpm {

/// Correction of lumped masses before the curved side of one solid.
class LumpedMassCorrection {
 public:
  static constexpr double full_reach = 2.5;  ///< cells from the surface
  static constexpr double fade = 3.0;        ///< cells

  /// Whether a solid has a curved side.
  [[nodiscard]] static bool concerns(const SurfaceSolid& solid) { return solid.outline().circle.has_value(); }

  /// @param density  of the material at rest, kg/m^3. @param relaxed  r, 0 .. 1
  LumpedMassCorrection(const SurfaceSolid& solid, double cell_size, double density, double relaxed)
      : distance_(solid.outline()), top_(solid.top()), dx_(cell_size), density_(density), relaxed_(relaxed) {}

  /// Share of a particle at x (m) that takes part.
  [[nodiscard]] double share(const Vec3& x) const;
  /// Whether particles of a column of blocks may take part. @param x,y  coordinate of its blocks
  [[nodiscard]] bool reaches(std::int32_t x, std::int32_t y) const;

  /// Adds m_i times the change of v_i to `change`, kg m/s, by number of block. Nodes must hold velocities, their old nodes those before
  /// forces, both with their images behind mirror planes. Sums in the order of colours: the same bits on any number of threads.
  void add(const Grid& grid, std::span<NodeBlock> change) const;

 private:
  void add_of_block(const Grid& grid, const Block& block, std::span<NodeBlock> change) const;

  OutlineDistance distance_;
  double top_, dx_, density_, relaxed_;
};

}  // namespace mpm
