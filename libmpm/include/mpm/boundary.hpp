#pragma once
/// Rigid boundaries: half-spaces, boxes, prisms and cylinders. They act on grid nodes on or behind their surface and return the impulse
/// that they took from the material, so that a force is an exact sum over steps and never a sample.
///
/// Booking: boundaries act one after the other in the order of Scene::boundaries (walls first, the obstacle last), each on the
/// velocity that the one before left, and each books the momentum it changed itself. A node shared by floor and mast is so
/// booked twice, each time with its own part; the parts add up to the whole change.

#include <functional>
#include <optional>
#include <variant>

#include "mpm/case.hpp"
#include "mpm/grid.hpp"

namespace mpm {

/// Linear and angular impulse given by the material to the boundary, N s and N m s.
struct Impulse {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();  ///< about the boundary's reference point
  double work = 0.0;            ///< J: of the moving surface on the material, -linear . u summed over the nodes
  Impulse& operator+=(const Impulse& other) {
    linear += other.linear;
    angular += other.angular;
    work += other.work;
    return *this;
  }
};

/// Contact with a surface of normal n (unit, into the material), friction mu, surface velocity u: with r = v - u,
/// no_slip: r = 0; slip: r.n = 0; separable: r.n = max(r.n, 0). Where the surface took the normal part |r.n| from approaching
/// material, Coulomb friction takes at most mu |r.n| from the tangential part (both are impulses per mass of one step).
Vec3 contact_velocity(const Vec3& velocity, const Vec3& normal, const Vec3& surface_velocity, Contact contact, double friction);

/// Impulses of one boundary by grid layer: nodes of one height. They add up to its Impulse::linear.
struct LayerImpulses {
  std::int32_t first = 0;   ///< number of the lowest layer: its nodes stand at z = first dx
  std::vector<Vec3> layer;  ///< N s, from there upwards; empty: the boundary took nothing
};

/// Half-space behind a plane.
struct Wall {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  Contact contact = Contact::no_slip;
  double friction = 0.0;
  Vec3 velocity = Vec3::Zero();  ///< of the surface, m/s
  bool travels = false;          ///< the plane itself moves with `velocity`; false: a belt, or an inlet at a fixed place

  [[nodiscard]] Vec3 reference_point() const { return point; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return velocity; }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
};

/// Half-space at a fixed place whose surface moves along x, at a speed that varies with height and time: an inlet of sheared snow, a belt
/// that speeds up.
struct Belt {
  Wall plane;                                               ///< its point stands on the floor; its velocity is not used
  std::function<double(double height, double time)> speed;  ///< m/s, of the height over the plane's point (m) and the time (s)

  [[nodiscard]] Vec3 reference_point() const { return plane.point; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3& node, double time) const { return {speed(node.z() - plane.point.z(), time), 0.0, 0.0}; }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const { return plane.reaches(low, high, time); }
  [[nodiscard]] bool covers(const Vec3& node, double time) const { return plane.covers(node, time); }
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
};

/// Rigid box at rest. A node inside is treated by the nearest face (an edge belongs to the upstream face first, then the
/// downstream one, the sides, the top): its normal points out of the box.
struct RigidBox {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();
  Contact contact = Contact::separable;
  double friction = 0.0;
  Vec3 reference = Vec3::Zero();  ///< point about which the moment is taken

  [[nodiscard]] Vec3 reference_point() const { return reference; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return Vec3::Zero(); }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
};

/// What upright solids of any cross-section share.
///
/// A box whose faces stand on grid planes holds the nodes on them, and each node stands for half a cell to either side: the solid on the
/// grid reaches half a cell beyond the face. So that an inclined or round surface, which nodes rarely meet, stands for the same solid, a
/// node belongs to it up to a skin of half a cell outside. A cross-section has to be some four cells wide to be one.
///
/// A node is treated by the nearest face: the one that it is least deep behind, or in the skin before. On the bisector of two sides
/// (a front edge on a mirror plane) the normal is their mean; the top counts only where it is nearer than every side.
struct Upright {
  double top = 0.0;   ///< m; there is no bottom: the solid stands on the floor
  double skin = 0.0;  ///< m, not on the top
  Contact contact = Contact::separable;
  double friction = 0.0;
  Vec3 reference = Vec3::Zero();  ///< point about which the moment is taken
};

/// Convex prism at rest.
struct RigidPrism {
  /// One side: n.(x, y) = offset on it, n the outward unit normal.
  struct Side {
    double normal_x, normal_y, offset;
  };
  Upright solid;
  std::vector<Side> sides;                                    ///< three or more
  double min_x = 0.0, max_x = 0.0, min_y = 0.0, max_y = 0.0;  ///< of the plan, m; bounds the skin before a sharp edge, too

  [[nodiscard]] Vec3 reference_point() const { return solid.reference; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return Vec3::Zero(); }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
};

/// Circular cylinder at rest; its axis is vertical.
struct RigidCylinder {
  Upright solid;
  double centre_x = 0.0, centre_y = 0.0, radius = 0.0;  ///< m

  [[nodiscard]] Vec3 reference_point() const { return solid.reference; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3&, double) const { return Vec3::Zero(); }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time = 0.0) const;
};

/// Adding a boundary: a struct with these four functions, named here and in scene.cpp.
using Boundary = std::variant<Wall, RigidBox, RigidPrism, RigidCylinder, Belt>;

/// Folds the grid at the mirror planes x = 0 and y = 0: the image of every particle adds to the nodes, so that half a symmetric
/// domain gives what the whole would. Call between particle_to_grid and update_grid.
void fold_mirror_planes(Grid& grid, bool mirror_x, bool mirror_y);

/// v_i = p_i / m_i + dt g, then the boundaries in their order. Nodes hold velocities afterwards.
/// @param impulses one entry a boundary; set to what each took in this step. With mirror planes: of the computed part.
/// @param layered  boundary whose impulse is wanted layer by layer, too, in `layers`: likewise of the computed part
/// @returns mass on the grid (of the computed part), kg: gravity gave it dt g m
double update_grid(Grid& grid, std::span<const Boundary> boundaries, const Vec3& gravity, double dt, double time, bool mirror_x,
                   bool mirror_y, std::vector<Impulse>& impulses, std::optional<std::size_t> layered = {}, LayerImpulses* layers = nullptr);

}  // namespace mpm
