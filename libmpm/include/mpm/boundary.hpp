#pragma once
/// Rigid boundaries: half-spaces and a box. They act on grid nodes on or behind their surface and return the impulse that they
/// took from the material, so that a force is an exact sum over steps and never a sample.
///
/// Booking: boundaries act one after the other in the order of Scene::boundaries (walls first, the obstacle last), each on the
/// velocity that the one before left, and each books the momentum it changed itself. A node shared by floor and mast is so
/// booked twice, each time with its own part; the parts add up to the whole change.

#include <variant>

#include "mpm/case.hpp"
#include "mpm/grid.hpp"

namespace mpm {

/// Linear and angular impulse given by the material to the boundary, N s and N m s.
struct Impulse {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();  ///< about the boundary's reference point
  Impulse& operator+=(const Impulse& other) {
    linear += other.linear;
    angular += other.angular;
    return *this;
  }
};

/// Contact with a surface of normal n (unit, into the material), friction mu, surface velocity u: with r = v - u,
/// no_slip: r = 0; slip: r.n = 0; separable: r.n = max(r.n, 0). Where the surface took the normal part |r.n| from approaching
/// material, Coulomb friction takes at most mu |r.n| from the tangential part (both are impulses per mass of one step).
Vec3 contact_velocity(const Vec3& velocity, const Vec3& normal, const Vec3& surface_velocity, Contact contact, double friction);

/// Half-space behind a plane.
struct Wall {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  Contact contact = Contact::no_slip;
  double friction = 0.0;
  Vec3 velocity = Vec3::Zero();  ///< of the surface, m/s
  bool travels = false;          ///< the plane itself moves with `velocity`; false: a belt, or an inlet at a fixed place

  [[nodiscard]] Vec3 reference_point() const { return point; }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v) const;
};

/// Rigid box at rest. A node inside is treated by the nearest face (an edge belongs to the upstream face first, then the
/// downstream one, the sides, the top): its normal points out of the box.
struct RigidBox {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();
  Contact contact = Contact::separable;
  double friction = 0.0;
  Vec3 reference = Vec3::Zero();  ///< point about which the moment is taken

  [[nodiscard]] Vec3 reference_point() const { return reference; }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v) const;
};

/// Adding a boundary: a struct with these four functions, named here and in scene.cpp.
using Boundary = std::variant<Wall, RigidBox>;

/// Folds the grid at the mirror planes x = 0 and y = 0: the image of every particle adds to the nodes, so that half a symmetric
/// domain gives what the whole would. Call between particle_to_grid and update_grid.
void fold_mirror_planes(Grid& grid, bool mirror_x, bool mirror_y);

/// v_i = p_i / m_i + dt g, then the boundaries in their order. Nodes hold velocities afterwards.
/// @param impulses one entry a boundary; set to what each took in this step. With mirror planes: of the computed part.
/// @returns mass on the grid (of the computed part), kg: gravity gave it dt g m
double update_grid(Grid& grid, std::span<const Boundary> boundaries, const Vec3& gravity, double dt, double time, bool mirror_x,
                   bool mirror_y, std::vector<Impulse>& impulses);

}  // namespace mpm
