#pragma once
/// How a surface acts on the velocity of the material that touches it.

#include <cstdint>
#include <memory>

#include "libmpm/base/types.hpp"

namespace mpm {

class HeightField;

/// What the material may do at a surface.
enum class Contact : std::uint8_t {
  no_slip,    ///< sticks fully
  slip,       ///< stays on the plane, slides (with Coulomb friction if mu > 0)
  separable,  ///< may lift off, slides (with Coulomb friction if mu > 0)
};

/// Where contact acts.
enum class ContactRule : std::uint8_t {
  nodal,    ///< on every node on or behind the surface, each by itself: moves the surface to the nodes; first order
  surface,  ///< at the surface, on the nodes around it together (core/folded_wall.hpp, boundary/contact_stencil.hpp); second order
};

/// Contact with a surface of normal n (unit, into the material), friction mu, surface velocity u: with r = v - u,
/// no_slip: r = 0; slip: r.n = 0; separable: r.n = max(r.n, 0). Where the surface took the normal part |r.n| from approaching
/// material, Coulomb friction takes at most mu |r.n| from the tangential part (both are impulses per mass of one step).
Vec3 contact_velocity(const Vec3& velocity, const Vec3& normal, const Vec3& surface_velocity, Contact contact, double friction);

/// What a boundary is made from beside its own table of a case.
struct BoundarySetting {
  ContactRule rule = ContactRule::surface;         ///< [numerics] contact
  std::shared_ptr<const HeightField> ground = {};  ///< of [terrain]; null without one
};

/// A node this close to a surface counts as on it, m: coordinates are sums of rounded multiples of dx.
inline constexpr double on_surface = 1e-9;
inline constexpr double cell_rounding = 1e-9;  ///< the same of lengths in cells

}  // namespace mpm
