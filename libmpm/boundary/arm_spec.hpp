#pragma once
/// A cross-arm of an obstacle, as a case gives it.

#include "libmpm/boundary/obstacle_spec.hpp"

namespace mpm {

/// [arm]: a rigid beam across the flow, through the obstacle that carries it, its middle on the obstacle's axis; contact as on the
/// obstacle.
struct ArmSpec {
  double length = 5.25;   ///< m, across the flow, from end to end
  double depth = 0.875;   ///< m, along the flow
  double base = 1.75;     ///< m, of the underside
  double height = 2.625;  ///< m, of the top
  bool operator==(const ArmSpec&) const = default;

  /// Its geometry, on this obstacle; the part inside the obstacle is never reached by snow.
  [[nodiscard]] UprightSolid solid(const ObstacleSpec& obstacle) const {
    UprightSolid solid{BoxShape{.width = length, .depth = depth}.outline(), base, height};
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
    table.add("base_m", &ArmSpec::base).unit("m").range(0.0, 1e5).required().text("Height of its underside");
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
