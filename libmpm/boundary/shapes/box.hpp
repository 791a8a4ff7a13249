#pragma once
/// Box: front face x = 0, |y| <= w/2; turned about its own vertical axis, and shifted so that the corner that leads touches x = 0.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "libmpm/boundary/outline.hpp"

namespace mpm {

/// Parameters of a box.
struct BoxShape {
  static constexpr std::string_view name = "box";                       ///< value of [obstacle] shape
  static constexpr std::string_view description = "rectangle in plan";  ///< some words for the reference of keys

  double width = 1.75;    ///< w, m: across the flow
  double depth = 1.75;    ///< m: along the flow
  double rotation = 0.0;  ///< rad, counter-clockwise from above
  bool operator==(const BoxShape&) const = default;

  /// Its keys (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("width_m", &BoxShape::width).unit("m").positive(1e4).text("Width w across the flow");
    table.add("depth_m", &BoxShape::depth).unit("m").positive(1e4).text("Depth along the flow");
    table.add("rotation_deg", &BoxShape::rotation)
        .degrees()
        .range(-90.0, 90.0)
        .hide_default()
        .text("Turns the box about its vertical axis, counter-clockwise from above; unless it stays symmetric, with mirror_y = false");
  }

  /// Width of the side that faces the flow, m: of a box that is turned by more than 45 degrees its depth.
  [[nodiscard]] double facing_width() const { return std::abs(rotation) <= 0.25 * std::numbers::pi + 1e-9 ? width : depth; }

  /// How it meets the flow: with a face, or turned with an edge.
  [[nodiscard]] Front front() const {
    const double quarters = rotation / (0.5 * std::numbers::pi);
    return std::abs(quarters - std::round(quarters)) < 1e-9 ? Front::plane : Front::edge;
  }

  /// A rectangle.
  [[nodiscard]] Outline outline() const {
    const double c = std::cos(rotation), s = std::sin(rotation);
    const Vec2 along = 0.5 * depth * Vec2(c, s), across = 0.5 * width * Vec2(-s, c);
    std::vector<Vec2> corners;
    for (const auto& [i, j] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) corners.emplace_back(i * along + j * across);
    double upstream = 0.0;
    for (const Vec2& corner : corners) upstream = std::min(upstream, corner.x());
    for (Vec2& corner : corners) corner.x() -= upstream;
    return Outline(corners);
  }
};

}  // namespace mpm
