#pragma once
/// The list of boundaries.
///
/// A boundary is a struct with the functions that `Wall` has: `reaches` (may it act within a box of nodes), `covers` (does it act on
/// this node), `constrain` (the velocity after contact), `surface_velocity` (for the work it does), `reference_point` (of its moment) and
/// `translate` (moves it in space). grid_update.hpp records the impulses, not the boundary. To add one, name it in the variant.
///
/// A boundary that a table of the case file makes names this table, `Table`: its `name` and `description`, the member of the case that it
/// fills, and `of`, which finds that member in a case. Each of its entries declares keys (base/parameter.hpp) and makes its boundary
/// (`boundary`). Schema, reader, writer, hash and scene follow from the list.
///
/// Three kinds act on several nodes together and have a file of their own in the core: walls whose rule is ContactRule::surface
/// (core/folded_wall.hpp), Terrain of that rule (core/folded_terrain.hpp), and SurfaceSolid (core/surface_contact.hpp), which has neither
/// `constrain` nor `reaches`.

#include <concepts>
#include <tuple>
#include <type_traits>
#include <variant>

#include "libmpm/boundary/solid.hpp"
#include "libmpm/boundary/terrain.hpp"
#include "libmpm/boundary/wall.hpp"

namespace mpm {

/// A boundary that can act on each node by itself.
template <class B>
concept HasConstrain = requires(const B boundary, const Vec3 v) {
  { boundary.constrain(v, v, 0.0) } -> std::same_as<Vec3>;
};

/// One boundary of the list.
using Boundary = std::variant<Wall, NodalSolid, SurfaceSolid, Terrain>;

namespace detail {

template <class B>
auto table_of() {
  if constexpr (requires { typename B::Table; })
    return std::tuple<typename B::Table>();
  else
    return std::tuple<>();
}
template <class Boundaries>
struct TablesOf;
template <class... B>
struct TablesOf<std::variant<B...>> : TablesOf<decltype(std::tuple_cat(table_of<B>()...))> {};
template <class... T>
struct TablesOf<std::tuple<T...>> : T... {
  bool operator==(const TablesOf&) const = default;
  /// Calls f<T>() for every table, in the order of the list.
  static void for_each(auto&& f) { (f.template operator()<T>(), ...); }
};

}  // namespace detail

/// The tables of a case that make boundaries, as its members.
struct BoundaryTables : detail::TablesOf<Boundary> {};

/// The geometry of a solid; null for another boundary.
inline const UprightSolid* geometry_of(const Boundary& boundary) {
  if (const auto* nodal = std::get_if<NodalSolid>(&boundary)) return &nodal->solid;
  const auto* surface = std::get_if<SurfaceSolid>(&boundary);
  return surface != nullptr ? &surface->solid() : nullptr;
}

}  // namespace mpm
