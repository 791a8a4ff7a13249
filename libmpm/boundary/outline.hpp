#pragma once
/// The geometry of every obstacle: a cross-section in plan, as its shape gives it, between two heights; and distances from it.

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/contact.hpp"

namespace mpm {

/// How a shape meets the flow. How well a grid resolves the force depends on it: the numerical uncertainty of a run is looked up by it.
enum class Front : std::uint8_t {
  plane,  ///< plane faces, as those of a box
  round,  ///< curved
  edge,   ///< an edge against the flow between plane flanks
  other,  ///< none of these: the numerical uncertainty is not known
};

/// From low to high.
struct Interval {
  double low, high;  ///< m
};

/// A circle in plan.
struct Circle {
  Vec2 centre = Vec2::Zero();  ///< m
  double radius = 0.0;         ///< m
};

/// A convex polygon or a circle. Frame of every shape: the most upstream point at x = 0, the middle of its width at y = 0.
class Outline {
 public:
  /// A side of a polygon: n.x <= offset holds for the points of the solid.
  struct Side {
    Vec2 from, to;  ///< m; the solid is to the left
    Vec2 normal;    ///< outward unit normal n
    double offset;  ///< distance of its line from the origin along n, m

    /// Signed distance from its line, m; negative on the side of the solid.
    [[nodiscard]] double distance(const Vec2& x) const { return normal.dot(x) - offset; }
    /// The nearest point of the side, m.
    [[nodiscard]] Vec2 nearest(const Vec2& x) const {
      const Vec2 along(-normal.y(), normal.x());
      return from + std::clamp(along.dot(x - from), 0.0, along.dot(to - from)) * along;
    }
  };
  /// The nearest place of the outline.
  struct Nearest {
    double distance;  ///< m, negative inside
    Vec2 normal;      ///< outward, of the side whose line is the nearest. Of several the one further upstream; of two that are equally far
                      ///< upstream (the flanks of a wedge at its edge) their mean: symmetric outlines give symmetric results
    Vec2 point;       ///< m, on the outline
  };

  /// @param corners  of a convex polygon, m, counter-clockwise
  explicit Outline(const std::vector<Vec2>& corners);
  explicit Outline(const Circle& circle);  ///< @param circle  m

  [[nodiscard]] std::optional<Circle> circle() const { return circle_; }    ///< where it is one
  [[nodiscard]] const std::vector<Side>& sides() const& { return sides_; }  ///< counter-clockwise; of a circle: of 256 chords
  [[nodiscard]] std::vector<Side> sides() && { return std::move(sides_); }  ///< those of a temporary may be looped over
  [[nodiscard]] Eigen::AlignedBox2d bounds() const { return bounds_; }      ///< the smallest box that contains it, m
  [[nodiscard]] bool symmetric() const;                                     ///< about y = 0
  [[nodiscard]] bool along_axes() const;                                    ///< a rectangle whose sides are along x and y
  [[nodiscard]] double area() const;                                        ///< m^2
  [[nodiscard]] Vec2 centre() const;                                        ///< of the area, m
  [[nodiscard]] std::optional<Interval> section(double y) const;            ///< of the line y = const; empty beside it. @param y  m
  [[nodiscard]] Nearest nearest(const Vec2& x) const;                       ///< @param x  m
  [[nodiscard]] double distance(const Vec2& x) const;                       ///< m, negative inside. @param x  m
  /// Of the upstream surface alone: the distance is negative inside and behind, whatever is near there; outside the normal is the direction
  /// from the nearest point. @param x  m, within the width
  [[nodiscard]] Nearest nearest_of_front(const Vec2& x) const;
  /// Whether two sides are within `margin` (m) of being the nearest; false for a circle. @param x  m, inside
  [[nodiscard]] bool is_ambiguous(const Vec2& x, double margin) const;
  /// Moves it in plan. @param by  m
  void translate(const Vec2& by);

 private:
  void set_sides(const std::vector<Vec2>& corners);
  /// The nearest point of a polygon. @param x  m, outside
  [[nodiscard]] Vec2 nearest_from_outside(const Vec2& x) const;

  std::optional<Circle> circle_;
  std::vector<Side> sides_;
  Eigen::AlignedBox2d bounds_;
};

/// A solid with vertical sides; what stands on the ground has no underside, what no jet reaches has no top.
struct UprightSolid {
  Outline outline;                                         ///< in plan
  double base = -std::numeric_limits<double>::infinity();  ///< m, of the underside
  double top = std::numeric_limits<double>::infinity();    ///< m

  /// The nearest place of the surface.
  struct Nearest {
    double distance;  ///< m, negative inside; before an edge of the top or of the underside the larger of the distances along z and in plan
    Vec3 normal;      ///< outward, of the nearest face; a side where a side and another face are equally near
  };
  /// @param x  m
  [[nodiscard]] Nearest nearest(const Vec3& x) const {
    const Outline::Nearest side = outline.nearest(x.head<2>());
    if (const double face = beyond(x.z()); face > side.distance + on_surface)
      return {face, x.z() - top >= base - x.z() ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitZ())};
    return {side.distance, Vec3(side.normal.x(), side.normal.y(), 0.0)};
  }
  /// Of the surface, m; negative inside; before an edge as in Nearest. @param x  m
  [[nodiscard]] double distance(const Vec3& x) const { return std::max(outline.distance(x.head<2>()), beyond(x.z())); }
  /// Height over the top or below the underside, m; negative between them. @param z  m
  [[nodiscard]] double beyond(double z) const { return std::max(z - top, base - z); }
  /// Of the underside, or of the ground that it stands on, m.
  [[nodiscard]] double foot() const { return std::max(base, 0.0); }
  /// The smallest box that contains it, m.
  [[nodiscard]] Eigen::AlignedBox3d bounds() const {
    const Eigen::AlignedBox2d plan = outline.bounds();
    return {Vec3(plan.min().x(), plan.min().y(), base), Vec3(plan.max().x(), plan.max().y(), top)};
  }
  /// Moves it. @param by  m
  void translate(const Vec3& by) {
    outline.translate(by.head<2>());
    base += by.z();
    top += by.z();
  }
};

}  // namespace mpm
