#pragma once
/// Wedge: isosceles triangle, front edge at the origin, base of width w at x = depth.

#include <string_view>

#include "libmpm/boundary/outline.hpp"

namespace mpm {

/// Parameters of a wedge.
struct WedgeShape {
  static constexpr std::string_view name = "wedge";  ///< value of [obstacle] shape
  /// Some words for the reference of keys.
  static constexpr std::string_view description = "isosceles triangle in plan, its edge against the flow";

  double width = 1.75;  ///< w, m: of the base, across the flow
  double depth = 1.75;  ///< m: from edge to base
  bool operator==(const WedgeShape&) const = default;

  [[nodiscard]] static Front front() { return Front::edge; }  ///< how it meets the flow

  /// Its keys (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("width_m", &WedgeShape::width).unit("m").positive(1e4).text("width of the base");
    table.add("depth_m", &WedgeShape::depth)
        .unit("m")
        .positive(1e4)
        .text("from edge to base: half the angle of the edge is atan(width_m / (2 depth_m))");
  }

  /// A triangle.
  [[nodiscard]] Outline outline() const { return Outline({Vec2::Zero(), Vec2(depth, -0.5 * width), Vec2(depth, 0.5 * width)}); }
};

}  // namespace mpm
