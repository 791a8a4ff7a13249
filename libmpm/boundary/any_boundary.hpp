#pragma once
/// The list of boundaries.
///
/// A boundary is a struct with the functions that `Wall` has: `reaches` (may it act within a box of nodes), `covers` (does it act on
/// this node), `constrain` (the velocity after contact), `surface_velocity` (for the work it does), `reference_point` (of its moment) and
/// `translate` (moves it in space). A solid also has `section` (the part of a line y = const along x that lies in it) and `height` (its
/// vertical extent), from which pictures draw it. grid_update.hpp records the impulses, not the boundary. To add one, name it in the
/// variant.
///
/// Three kinds act on several nodes together and have a file of their own in the core: walls whose rule is ContactRule::surface
/// (core/folded_wall.hpp), Terrain of that rule (core/folded_terrain.hpp), and SurfaceSolid (core/surface_contact.hpp), which has neither
/// `constrain` nor `reaches`.

#include <concepts>
#include <variant>

#include "libmpm/boundary/rigid_box.hpp"
#include "libmpm/boundary/surface_solid.hpp"
#include "libmpm/boundary/terrain.hpp"
#include "libmpm/boundary/vertical_solid.hpp"
#include "libmpm/boundary/wall.hpp"

namespace mpm {

/// A boundary that acts on each node by itself.
template <class B>
concept ActsOnNodes = requires(const B boundary, const Vec3 v) {
  { boundary.constrain(v, v, 0.0) } -> std::same_as<Vec3>;
};

/// One boundary of the list.
using Boundary = std::variant<Wall, RigidBox, RigidPrism, RigidCylinder, MovingWall, SurfaceSolid, Terrain>;

/// Whether it can act on each node by itself; a wall or the ground may be folded nevertheless.
inline bool acts_on_nodes(const Boundary& boundary) {
  return std::visit([]<class B>(const B&) { return ActsOnNodes<B>; }, boundary);
}

/// The plane of a wall, moving or not; null for another boundary.
inline const Wall* plane_of(const Boundary& boundary) {
  if (const auto* moving = std::get_if<MovingWall>(&boundary)) return &moving->plane;
  return std::get_if<Wall>(&boundary);
}

}  // namespace mpm
