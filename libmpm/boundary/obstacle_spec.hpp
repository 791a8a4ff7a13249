#pragma once
/// Shape, height and friction of an obstacle, as a case gives them.

#include <optional>
#include <string>
#include <vector>

#include "libmpm/boundary/shapes/any_shape.hpp"

namespace mpm {

class ParameterReport;
struct MaterialParameters;

/// [obstacle]: rigid, upright, on the floor; its most upstream point at x = 0, its centre at y = 0; separable Coulomb contact.
struct ObstacleSpec {
  AnyShape shape;                        ///< with the parameters of that shape
  std::optional<double> height;          ///< m; empty: taller than any jet
  double friction = 0.15;                ///< mu
  std::optional<double> friction_ratio;  ///< mu / tan(phi'), given instead of friction: resolve_friction turns it into friction
  bool operator==(const ObstacleSpec&) const = default;

  /// w, m: the width that corresponds to the paper's
  [[nodiscard]] double width() const {
    return std::visit([](const auto& s) { return s.width; }, shape);
  }
  /// How the shape meets the flow.
  [[nodiscard]] Front front() const {
    return std::visit([](const auto& s) { return s.front; }, shape);
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
                       "Rigid, upright, on the floor, its most upstream point at x = 0, its middle at y = 0. " + shape_descriptions());
    table.add("height_m", &ObstacleSpec::height).unit("m").positive(1e5).left_out("taller than any jet").text("Height");
    table.add("friction", &ObstacleSpec::friction).range(0.0, most_friction).text("Coulomb coefficient mu of snow on the obstacle");
    table.add("friction_ratio", &ObstacleSpec::friction_ratio)
        .range(0.0, 1.0)
        .left_out("friction is used")
        .excludes("friction")
        .text(
            "Instead of friction: mu / tan(phi'), phi' the snow's own angle of friction (of Drucker-Prager, phi). Snow without "
            "friction (M = 0) then slides freely");
  }

  /// Turns friction_ratio, where it was given, into friction. @param report  of this component: names are those of its keys
  void resolve_friction(const MaterialParameters& material, ParameterReport& report);
  /// Whether all parameters that make the plan of an obstacle are valid. @param report  of this component
  [[nodiscard]] static bool plan_is_valid(const ParameterReport& report);

  static constexpr double most_friction = 10.0;  ///< bound of mu, given or from friction_ratio
};

}  // namespace mpm
