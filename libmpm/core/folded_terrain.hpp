#pragma once
/// Second-order contact with uneven ground: the nodes of each column along z are coupled as those at a wall.

#include <span>
#include <vector>

#include "libmpm/boundary/impulse.hpp"
#include "libmpm/boundary/terrain.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"

namespace mpm {

/// Lets uneven ground act on the columns of nodes along z.
///
/// Each column has a plane of its own: the height h and the unit normal n of the ground at its x and y. The velocity along n goes linearly
/// through zero at z = h (node_column.hpp); friction acts in the plane. Where the ground is level this is apply_folded_wall, to the last
/// bit. On a slope material touches nodes up to 3/2 dx (|h_x| + |h_y|) further below the ground, and the column has as many more slaves.
///
/// A field that is zero on a plane and linear before it is not touched, and a flow along curved ground is changed by O(dx^2). Between two
/// columns, however, the velocity on a slope is interpolated from nodes at different heights above the ground, of which some are not held:
/// the condition is met there to second order only, and the pressure in the first cells alternates with the places of the nodes, by some
/// per cent at 30 degrees (tests/core/test_motion_on_slopes.cpp). The force on the ground is whole, because each impulse is recorded.
/// Masters that are higher on a slope, by half a cell for a slope of one, lower that error by a tenth to a third: not worth their lines.
///
/// Limits: |grad h| up to Terrain::steepest; radii of curvature of several cells.
/// @param blocks  of Grid::own_blocks(), all or some: the ground acts on the columns whose masters are in them
/// @returns the impulse on the ground for each of them; a column counts in the block of its master
std::vector<Impulse> apply_folded_terrain(Grid& grid, const Terrain& terrain, const MirrorPlanes& mirror,
                                          std::span<const std::int32_t> blocks);

/// A range that holds the layers of blocks that the columns reach into, within the raster of the ground and two cells beyond.
/// @param cell_size  m
LayerRange layers_of_columns(const Terrain& terrain, double cell_size);

}  // namespace mpm
