#pragma once
/// Vertical circular cylinder, its centre at (w/2, 0).

#include <string_view>

#include "libmpm/boundary/outline.hpp"

namespace mpm {

/// Parameters of a cylinder.
struct CylinderShape {
  static constexpr std::string_view name = "cylinder";                           ///< value of [obstacle] shape
  static constexpr std::string_view description = "vertical, a circle in plan";  ///< some words for the reference of keys

  double width = 1.75;  ///< w, m: the diameter
  bool operator==(const CylinderShape&) const = default;

  [[nodiscard]] static Front front() { return Front::round; }  ///< how it meets the flow

  /// Its keys (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("width_m", &CylinderShape::width).unit("m").positive(1e4).text("diameter");
  }

  /// A circle.
  [[nodiscard]] Outline outline() const { return Outline(Circle{{0.5 * width, 0.0}, 0.5 * width}); }
};

}  // namespace mpm
