#pragma once
/// A plane wall, as a case gives it.

#include <cmath>
#include <limits>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/contact.hpp"

namespace mpm {

/// [[wall]]: half-space. Numerics::contact decides whether it acts at its plane or on the nodes on and behind it.
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
  static Vec3 unit(const Vec3& n) {
    constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();  // of normalising: a few ulp in the square
    const double length = n.stableNorm();
    return length == 0.0 || std::abs(n.squaredNorm() - 1.0) < rounding ? n : Vec3(n / length);
  }
  /// Conditions between these keys.
  template <class Report>
  void check(Report& report) const {
    if (report.valid("normal") && normal.isZero(0.0))
      report.problem("normal", "= [0, 0, 0] has no direction; give a vector that points into the material");
  }
};

}  // namespace mpm
