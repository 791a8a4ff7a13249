#pragma once
/// Contact of single particles with solids that act at their surface, and with walls and ground beside them.
///
/// The conditions on the grid (boundary/contact_stencil.hpp) hold at points of the surface. Between the points, and beside the end points
/// of a side, a flow can pass through it: at rest and in slow flow, where the pressure does not vanish at an edge, up to half of a mast
/// would fill with snow. So a particle that is behind the surface goes back to it, and loses the velocity that points into the solid, as in
/// a plastic impact with Coulomb friction. In the next step its nodes feel the loss: the pressure behind the particle then rises until the
/// flow passes the edge outside. It goes back to the surface itself: left at the depth where it is found, it is found there in every step,
/// swells there without end, and the pressure before the solid is lost (by a third in 12 s at Fr 7).
///
/// Beside such a solid the same holds for walls and ground that act at their surface: the solid's friction changes nodes that they have
/// just set, so at the foot of a mast a few particles of 100,000 would be pulled up to two cells below the floor.

#include <cstdint>
#include <span>
#include <vector>

#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/boundary/impulse.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

/// Cells behind the surface up to which a particle is left where it is: round-off moves a particle that slides along the surface to either
/// side, and the points let the flow through a circle between them by less.
inline constexpr double deepest_particle = 0.05;

/// What a boundary took from particles near one layer of nodes.
struct ParticleImpulse {
  std::size_t boundary = 0;  ///< index in the list
  std::int32_t layer = 0;    ///< number of the layer, one of the block
  Impulse impulse;           ///< of these particles
};

/// Moves the particles of one block that are too deep behind a surface back to it, by at most a cell; only in blocks beside a
/// SurfaceSolid. Call it between grid_to_particle and collect_migrants. @param time  at the end of the step, s
/// @param density  of the material at rest, kg/m^3. @returns nothing for most blocks
[[nodiscard]] std::vector<ParticleImpulse> return_to_surface(Grid& grid, std::int32_t block, std::span<const Boundary> boundaries,
                                                             double time, double density);

}  // namespace mpm
