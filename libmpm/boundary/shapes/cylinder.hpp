#pragma once
/// Vertical circular cylinder, its centre at (w/2, 0).

#include <cmath>
#include <numbers>
#include <string_view>

#include "libmpm/boundary/shapes/outline.hpp"

namespace mpm {

/// Parameters of a cylinder.
struct CylinderShape {
  static constexpr std::string_view name = "cylinder";                           ///< value of [obstacle] shape
  static constexpr std::string_view description = "vertical, a circle in plan";  ///< some words for the reference of keys
  static constexpr Front front = Front::round;                                   ///< how it meets the flow

  double width = 1.75;  ///< w, m: the diameter
  bool operator==(const CylinderShape&) const = default;

  /// Its keys (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("width_m", &CylinderShape::width).unit("m").positive(1e4).text("diameter");
  }

  /// A regular polygon inscribed in the circle, with the radius of the circle.
  [[nodiscard]] Outline outline() const {
    constexpr int circle_sides = 256;  // the polygon is 7.5e-5 of the radius short of the circle
    const double r = 0.5 * width;
    Outline plan{.circle = Circle{{r, 0.0}, r}};
    for (int i = 0; i < circle_sides; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / circle_sides;
      plan.corners.emplace_back(r + r * std::cos(angle), r * std::sin(angle));
    }
    return plan;
  }
};

}  // namespace mpm
