#pragma once
/// Second-order walls: the nodes of each column across the plane are coupled so that the normal velocity is linear and zero on the plane.

#include <optional>
#include <span>
#include <vector>

#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/boundary/impulse.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"
#include "libmpm/core/surface_contact.hpp"

namespace mpm {

/// Lets a wall normal to an axis act on the columns of nodes along that axis.
///
/// Of each column the first node at least half a cell before the plane is the master, the next two are its slaves: the normal velocity
/// relative to the surface goes linearly through zero on the plane, v_k.n = c_k v_m.n with c_k = d_k/d_m, d the distance before the plane
/// (negative behind). v_m = sum c_k m_k v_k / sum c_k^2 m_k is the projection of the node velocities onto that form, orthogonal in the
/// kinetic-energy norm. On a plane of nodes this is the exact mirror image. no_slip: all components;
/// separable: only where the column as a whole is pushed against the wall. Coulomb friction takes from the tangential
/// velocities v_t the same share s of the way to sticking (v_t = c_k w), s <= 1 and s |J_stick| <= mu |J_n|. Nodes further behind act
/// each for itself, as all do in a column whose master has no mass.
/// @param boundary  a wall, moving or not, that folds()
/// @returns what the wall took in each block of Grid::all_blocks(), that of a column in the block of its master
std::vector<Impulse> apply_folded_wall(Grid& grid, const Boundary& boundary, const MirrorPlanes& mirror, double time);

/// Lets the top of a solid act, as a separable wall folds, on the columns of nodes that stand on it.
/// @param impulse  what it took is added to this
void apply_folded_top(Grid& grid, const SurfaceSolid& solid, const MirrorPlanes& mirror, ContactImpulse& impulse);

/// True if the wall has ContactRule::surface, is normal to an axis, and no parallel wall constrains, or is also coupled to, the master
/// node of a column. The image of the wall beyond a mirror plane is such a wall.
bool folds(const Wall& wall, std::span<const Boundary> boundaries, const MirrorPlanes& mirror, double cell_size, double time);

/// Two layers of blocks across an axis: `lower`, and the one next to it.
struct JoinedLayers {
  int axis = 0;            ///< 0, 1, 2
  std::int32_t lower = 0;  ///< coordinate of its blocks
};
/// The layers of blocks that the columns of a wall that folds() reach into; empty if it is a single one. @param cell_size  m. @param time s
std::optional<JoinedLayers> layers_of_columns(const Wall& wall, double cell_size, double time);
/// The same for the columns of apply_folded_top.
std::optional<JoinedLayers> layers_of_top(const SurfaceSolid& solid, double cell_size);

}  // namespace mpm
