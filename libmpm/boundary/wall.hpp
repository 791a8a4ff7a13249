#pragma once
/// Plane walls: half-spaces at rest, moving, or with a surface that moves.

#include <functional>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/contact.hpp"

namespace mpm {

struct WallTable;

/// Half-space behind a plane.
struct Wall {
  using Table = WallTable;  ///< from which a case makes it

  /// m, on the plane
  Vec3 point = Vec3::Zero();
  /// unit, into the material
  Vec3 normal = Vec3::UnitZ();
  /// of the surface
  Contact contact = Contact::no_slip;
  /// mu
  double friction = 0.0;
  Vec3 velocity = Vec3::Zero();           ///< of the surface, m/s
  bool travels = false;                   ///< the plane itself moves with `velocity`; false: a belt, or an inlet at a fixed place
  ContactRule rule = ContactRule::nodal;  ///< `surface` applies to walls normal to an axis; oblique walls are nodal
  /// Speed of the surface along x, m/s, by the height over `point` (m) and the time (s): an inlet with a sheared profile, a belt that
  /// speeds up. Replaces `velocity`; empty: the same everywhere
  std::function<double(double height, double time)> speed = {};

  /// Distance of the plane from the origin along its normal at some time, m.
  [[nodiscard]] double plane_distance(double time) const { return point.dot(normal) + (travels ? time * velocity.dot(normal) : 0.0); }

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return point; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3& node, double time) const {
    return speed ? Vec3(speed(node.z() - point.z(), time), 0.0, 0.0) : velocity;
  }
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time) const;
  void translate(const Vec3& by) { point += by; }
  /// @}
};

/// An entry of [[wall]]: half-space. Numerics::contact decides whether it acts at its plane or on the nodes on and behind it.
struct WallSpec {
  Vec3 point = Vec3::Zero();           ///< m, on the plane
  Vec3 normal = Vec3::UnitZ();         ///< unit, into the material
  Contact contact = Contact::no_slip;  ///< how the surface acts (boundary/contact.hpp)
  double friction = 0.0;               ///< Coulomb mu; slip and separable only
  Vec3 velocity = Vec3::Zero();        ///< of the surface, m/s
  bool operator==(const WallSpec&) const = default;

  /// The keys of [[wall]] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("point_m", &WallSpec::point).unit("m").range(-longest_length, longest_length).required().text("A point of the plane");
    table.add("normal", &WallSpec::normal)
        .range(-1e6, 1e6)
        .stored_as(&WallSpec::unit)
        .required()
        .text("Normal of the plane, into the material; any length but zero");
    table.add("contact", &WallSpec::contact, {"no_slip", "slip", "separable"})
        .text("no_slip: sticks; slip: stays on the plane and slides; separable: slides and may lift off");
    table.add("friction", &WallSpec::friction).range(0.0, 10.0).only_with("contact", {"slip", "separable"}).text("Coulomb coefficient mu");
    table.add("velocity_m_s", &WallSpec::velocity).unit("m/s").range(-fastest_speed, fastest_speed).text("Velocity of the wall");
  }
  /// Normalised; a vector that already has unit length keeps its bits.
  static Vec3 unit(const Vec3& n);
  /// Conditions between these keys.
  template <class Report>
  void check(Report& report) const {
    if (report.valid("normal") && normal.isZero(0.0))
      report.problem("normal", "= [0, 0, 0] has no direction; give a vector that points into the material");
  }
  /// The wall, which travels with its velocity.
  [[nodiscard]] Wall boundary(const BoundarySetting& setting) const;
};

/// [[wall]] of a case.
struct WallTable {
  static constexpr const char* name = "wall";  ///< of the table
  /// For the reference of keys.
  static constexpr const char* description = "A half-space in a custom scene, any number; the material is on the side of its normal";
  std::vector<WallSpec> walls;  ///< [[wall]]
  bool operator==(const WallTable&) const = default;
  /// Its entries. @param c  a case
  static auto* of(auto& c) { return &c.walls; }
};

}  // namespace mpm
