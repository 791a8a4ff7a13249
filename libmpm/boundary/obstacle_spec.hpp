#pragma once
/// Shape, height and friction of an obstacle and the size of its cross-arm, as a case gives them.

#include <optional>
#include <string>

#include "libmpm/boundary/outline.hpp"
#include "libmpm/boundary/shapes/any_shape.hpp"

namespace mpm {

class ParameterReport;
struct MaterialParameters;

/// [obstacle]: rigid, upright; its most upstream point at x = 0, its centre at y = 0; separable Coulomb contact.
struct ObstacleSpec {
  AnyShape shape;                        ///< with the parameters of that shape
  std::optional<double> height;          ///< m; empty: taller than any jet
  double base = 0.0;                     ///< m, of the underside; 0: it stands on the ground
  double friction = 0.15;                ///< mu
  std::optional<double> friction_ratio;  ///< mu / tan(phi'), given instead of friction: resolve_friction turns it into friction
  bool operator==(const ObstacleSpec&) const = default;

  /// w, m: the width that corresponds to the paper's, of what faces the flow
  [[nodiscard]] double width() const {
    return std::visit(
        [](const auto& s) {
          if constexpr (requires { s.facing_width(); })
            return s.facing_width();
          else
            return s.width;
        },
        shape);
  }
  /// How it meets the flow: what begins above the ground lets snow pass below it, as no obstacle of the grid studies does.
  [[nodiscard]] Front front() const {
    return base > 0.0 ? Front::other : std::visit([](const auto& s) { return s.front(); }, shape);
  }
  /// Its geometry.
  [[nodiscard]] UprightSolid solid() const {
    UprightSolid solid{outline_of(shape)};
    if (base > 0.0) solid.base = base;
    if (height) solid.top = *height;
    return solid;
  }
  /// The parameters of one shape; std::bad_variant_access if it is another one.
  template <ObstacleShape S>
  [[nodiscard]] S& as() {
    return std::get<S>(shape);
  }
  /// The parameters of one shape; std::bad_variant_access if it is another one.
  template <ObstacleShape S>
  [[nodiscard]] const S& as() const {
    return std::get<S>(shape);
  }

  /// The keys of [obstacle] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.alternatives("shape", &ObstacleSpec::shape,
                       "Rigid, upright, its most upstream point at x = 0, its middle at y = 0. " + shape_descriptions());
    table.add("height_m", &ObstacleSpec::height).unit("m").positive(1e5).left_out("taller than any jet").text("Height of its top");
    table.add("base_m", &ObstacleSpec::base)
        .unit("m")
        .range(0.0, 1e5)
        .hide_default()
        .text("Height of its underside, of a cross-arm, a sign or a deck; 0: it stands on the ground");
    table.add("friction", &ObstacleSpec::friction).range(0.0, most_friction).text("Coulomb coefficient mu of snow on the obstacle");
    table.add("friction_ratio", &ObstacleSpec::friction_ratio)
        .range(0.0, 1.0)
        .left_out("friction is used")
        .excludes("friction")
        .text(
            "Instead of friction: mu / tan(phi'), phi' the snow's own angle of friction (of Drucker-Prager, phi). Snow without "
            "friction (M = 0) then slides freely");
  }

  /// The underside is below the top.
  template <class Report>
  void check(Report& report) const {
    if (height && base >= *height && report.all_valid({"base_m", "height_m"}))
      report.problem("base_m", "is not below height_m, the top; both are heights above the ground");
  }
  /// Turns friction_ratio, where it was given, into friction. @param report  of this component: names are those of its keys
  void resolve_friction(const MaterialParameters& material, ParameterReport& report);
  /// Whether all parameters that make the plan of an obstacle are valid. @param report  of this component
  [[nodiscard]] static bool plan_is_valid(const ParameterReport& report);

  static constexpr double most_friction = 10.0;  ///< bound of mu, given or from friction_ratio
};

/// [arm]: a rigid beam across the flow, through the obstacle that carries it, its middle on the obstacle's axis; contact as on the
/// obstacle.
struct ArmSpec {
  double length = 5.25;   ///< m, across the flow, from end to end
  double depth = 0.875;   ///< m, along the flow
  double base = 1.75;     ///< m, of the underside; 0: it stands on the ground
  double height = 2.625;  ///< m, of the top
  bool operator==(const ArmSpec&) const = default;

  /// Its geometry, on this obstacle; the part inside the obstacle is never reached by snow.
  [[nodiscard]] UprightSolid solid(const ObstacleSpec& obstacle) const {
    UprightSolid solid{.outline = BoxShape{.width = length, .depth = depth}.outline(), .top = height};
    if (base > 0.0) solid.base = base;
    solid.translate({front_x(obstacle), 0.0, 0.0});
    return solid;
  }
  /// x of its upstream face, m.
  [[nodiscard]] double front_x(const ObstacleSpec& obstacle) const { return outline_of(obstacle.shape).centre().x() - 0.5 * depth; }

  /// The keys of [arm] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("length_m", &ArmSpec::length).unit("m").positive(1e4).required().text("Length across the flow, from end to end");
    table.add("depth_m", &ArmSpec::depth)
        .unit("m")
        .positive(1e4)
        .required()
        .text("Depth along the flow; its middle is on the obstacle's axis");
    table.add("base_m", &ArmSpec::base).unit("m").range(0.0, 1e5).required().text("Height of its underside; 0: it stands on the ground");
    table.add("height_m", &ArmSpec::height).unit("m").positive(1e5).required().text("Height of its top");
  }
  /// The obstacle that carries it. @param carrier  what the file calls that, for messages @param report  of this component
  void check_on(const ObstacleSpec& obstacle, const std::string& carrier, ParameterReport& report) const;
  /// The underside is below the top.
  template <class Report>
  void check(Report& report) const {
    if (base >= height && report.all_valid({"base_m", "height_m"}))
      report.problem("base_m", "is not below height_m, the top; both are heights above the ground");
  }
};

}  // namespace mpm
