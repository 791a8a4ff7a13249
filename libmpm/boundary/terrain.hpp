#pragma once
/// Uneven ground: heights in plan between the points of a raster, and the space below them.

#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/contact.hpp"

namespace mpm {

/// z = h(x, y), between regular points by Catmull-Rom's cubic along both axes (Keys 1981, IEEE Trans. Acoust. 29, with a = -1/2): h passes
/// through the points, its slope is continuous, planes are exact and so are quadratic surfaces away from the edge. Beyond the outermost
/// points it goes on with the slope of the nearest place that they span. Equal heights at all points give this height to the last bit.
class HeightField {
 public:
  /// The points.
  struct Points {
    Vec2 first = Vec2::Zero();          ///< m, of the south-western point: least x and y
    double spacing = 1.0;               ///< m, along both axes
    std::size_t columns = 2, rows = 2;  ///< along x and y, two or more of each
    std::vector<double> height = {};    ///< m, x fastest, from the south: columns * rows
    bool operator==(const Points&) const = default;
  };
  /// @param points  two or more along both axes; heights finite
  explicit HeightField(Points points);

  /// The surface above a place in plan.
  struct Surface {
    double height = 0.0;        ///< m
    Vec2 slope = Vec2::Zero();  ///< dh/dx, dh/dy
    /// Unit, upwards.
    [[nodiscard]] Vec3 normal() const { return Vec3(-slope.x(), -slope.y(), 1.0) / std::sqrt(1.0 + slope.squaredNorm()); }
  };
  [[nodiscard]] Surface at(const Vec2& place) const;  ///< @param place  m

  [[nodiscard]] const Points& points() const { return points_; }  ///< as given
  [[nodiscard]] Vec2 last() const;                                ///< m, the north-eastern point

  /// Bounds of h within the raster, m: the cubic leaves the range of its 16 points by at most 0.29 of it.
  /// @{
  [[nodiscard]] double lowest() const { return lowest_; }
  [[nodiscard]] double highest() const { return highest_; }
  /// @}

 private:
  Points points_;
  double lowest_, highest_;
};

struct TerrainTable;

/// The ground below z = h(x, y), at rest or a belt that follows it.
///
/// With ContactRule::surface it acts on each column of nodes along z with the height and the normal that it has there
/// (core/folded_terrain.hpp); with ContactRule::nodal on each node below, with those at the node.
struct Terrain {
  using Table = TerrainTable;  ///< from which a case makes it
  /// Slope up to which a case may have ground: tan 30 degrees, beyond which columns along z are a poor approximation of the surface.
  static constexpr double steepest = 0.578;

  std::shared_ptr<const HeightField> field;  ///< in the frame of the case
  Contact contact = Contact::separable;      ///< of the surface
  double friction = 0.0;                     ///< mu
  double speed = 0.0;                        ///< m/s: the surface moves with speed (1, 0, dh/dx), tangent to the ground
  ContactRule rule = ContactRule::surface;   ///< where it acts
  Vec3 shift = Vec3::Zero();                 ///< m, of the field against the frame of the grid

  /// The surface above or below a point; heights in the frame of the grid. @param x  m
  [[nodiscard]] HeightField::Surface surface(const Vec3& x) const;
  /// Of the surface where its slope is `slope`, m/s.
  [[nodiscard]] Vec3 velocity(const Vec2& slope) const { return {speed, 0.0, speed * slope.x()}; }

  /// What every boundary offers (any_boundary.hpp). Places in m, velocities in m/s, time in s.
  /// @{
  [[nodiscard]] Vec3 reference_point() const { return shift; }
  [[nodiscard]] Vec3 surface_velocity(const Vec3& x, double time) const;
  [[nodiscard]] bool reaches(const Vec3& low, const Vec3& high, double time) const;
  [[nodiscard]] bool covers(const Vec3& node, double time) const;
  [[nodiscard]] Vec3 constrain(const Vec3& node, const Vec3& v, double time) const;
  void translate(const Vec3& by) { shift += by; }
  /// @}
};

/// [terrain]: the ground as a raster of heights.
struct TerrainSpec {
  std::optional<std::string> file;       ///< with the raster; its content becomes `raster` when a case is read
  std::optional<std::string> raster;     ///< an ESRI ASCII grid in the coordinates of the case
  Contact contact = Contact::separable;  ///< how the surface acts (boundary/contact.hpp)
  double friction = 0.0;                 ///< Coulomb mu; slip and separable only
  double speed = 0.0;                    ///< of the surface along x, m/s; along z it follows the slope
  bool operator==(const TerrainSpec&) const = default;

  /// The keys of [terrain] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("file", &TerrainSpec::file)
        .left_out("raster is given instead (one of the two is required)")
        .excludes("raster")
        .text(
            "Heights of the ground, relative to the case file: an ESRI ASCII grid, or a table (.csv) of a regular grid with the columns "
            "x_m, "
            "y_m, z_m; in the coordinates of the case. Its content becomes raster, so that the case does not depend on the file");
    table.add("raster", &TerrainSpec::raster)
        .left_out("file is given instead (one of the two is required)")
        .text(
            "The same as text in the case: an ESRI ASCII grid with blanks instead of line breaks. Heights between its points are "
            "interpolated by cubics");
    table.add("contact", &TerrainSpec::contact, {"no_slip", "slip", "separable"})
        .text("no_slip: sticks; slip: stays on the ground and slides; separable: slides and may lift off");
    table.add("friction", &TerrainSpec::friction)
        .range(0.0, 10.0)
        .only_with("contact", {"slip", "separable"})
        .text("Coulomb coefficient mu, in the tangent plane");
    table.add("surface_speed_m_s", &TerrainSpec::speed)
        .unit("m/s")
        .range(-fastest_speed, fastest_speed)
        .text("Speed of the surface along x, as of a belt that follows the ground");
  }
  /// The ground, of the setting's heights.
  [[nodiscard]] Terrain boundary(const BoundarySetting& setting) const { return {setting.ground, contact, friction, speed, setting.rule}; }
};

/// [terrain] of a case.
struct TerrainTable {
  static constexpr const char* name = "terrain";  ///< of the table
  /// For the reference of keys.
  static constexpr const char* description =
      "Uneven ground: a raster of heights; on the conveyor in place of its level floor, in a custom scene in addition to walls. Left out: "
      "none";
  std::optional<TerrainSpec> terrain;  ///< [terrain]
  bool operator==(const TerrainTable&) const = default;
  /// The table. @param c  a case
  static auto& of(auto& c) { return c.terrain; }
};

}  // namespace mpm
