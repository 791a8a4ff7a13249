#pragma once
/// Mirror planes x = 0 and y = 0: the results of a symmetric domain from half of it.

#include "libmpm/core/grid.hpp"

namespace mpm {

/// Adds the image of every particle to fields of momenta: to those of the grid between particle_to_grid and update_grid.
/// @param grid  knows where the blocks are. @param fields  are changed. @param blocks  of Grid::own_blocks(), all or some
void add_mirror_images(const Grid& grid, const MirrorPlanes& mirror, const NodeFields& fields, std::span<const std::int32_t> blocks);

/// Renews the images behind the planes after boundaries have changed the velocities before them. Velocities before forces need no renewal,
/// because no boundary changes them. @param blocks  of Grid::own_blocks(), all or some
void reflect_velocities(Grid& grid, const MirrorPlanes& mirror, std::span<const std::int32_t> blocks);

/// Fraction of a node that belongs to the computed part: 0 behind a mirror plane, a half on it.
inline double computed_fraction(const MirrorPlanes& mirror, const Index3& block, int node) {
  const Index3 at = node_index(block, node);
  const auto part = [](std::int32_t place) { return place < 0 ? 0.0 : place == 0 ? 0.5 : 1.0; };
  return (mirror.x ? part(at[0]) : 1.0) * (mirror.y ? part(at[1]) : 1.0);
}
/// Whether a block has nodes of which only a fraction belongs to the computed part.
inline bool is_cut(const MirrorPlanes& mirror, const Index3& block) { return (mirror.x && block[0] <= 0) || (mirror.y && block[1] <= 0); }

}  // namespace mpm
