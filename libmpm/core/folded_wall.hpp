#pragma once
/// Second-order walls: the nodes of each column across the plane are coupled so that the normal velocity is linear and zero on the plane.

#include <span>
#include <vector>

#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/core/boundary_impulses.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"

namespace mpm {

/// Lets a wall normal to an axis act on the columns of nodes along that axis.
///
/// Of each column the first node at least half a cell before the plane is the master, the next two are its slaves; node_column.hpp gives
/// the rule. On a plane of nodes this is the exact mirror image. Nodes further behind act alone, and so do all nodes of a column whose
/// master has no mass.
/// @param wall  one that folds()
/// @param blocks  of Grid::own_blocks(), all or some: the wall acts on the columns whose masters are in them
/// @returns the impulse on the wall for each of them; a column counts in the block of its master
std::vector<Impulse> apply_folded_wall(Grid& grid, const Wall& wall, const MirrorPlanes& mirror, double time,
                                       std::span<const std::int32_t> blocks);

/// Lets top and underside of a solid act, as separable walls fold, on the columns of nodes that stand on them. Those at an edge are bounded
/// by EdgeBound. @param density  of the material at rest, kg/m^3. @param dt  s. @param impulse  the impulse on them is added to it
void apply_folded_faces(Grid& grid, const SurfaceSolid& solid, const MirrorPlanes& mirror, double density, double dt,
                        ContactImpulse& impulse);

/// True if the wall has ContactRule::surface, is normal to an axis, and no parallel wall constrains, or is also coupled to, the master
/// node of a column. The image of the wall beyond a mirror plane is such a wall.
bool folds(const Wall& wall, std::span<const Boundary> boundaries, const MirrorPlanes& mirror, double cell_size, double time);

/// The one or two layers of blocks that the columns of a wall that folds() reach into. @param cell_size  m. @param time  s
LayerRange layers_of_columns(const Wall& wall, double cell_size, double time);
/// The same for the columns of apply_folded_faces.
std::vector<LayerRange> layers_of_faces(const SurfaceSolid& solid, double cell_size);

}  // namespace mpm
