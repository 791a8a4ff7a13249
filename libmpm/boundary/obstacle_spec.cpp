#include "libmpm/boundary/obstacle_spec.hpp"

#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/material/any_material.hpp"

namespace mpm {

void resolve_friction(ObstacleSpec& obstacle, const MaterialParameters& material, ParameterReport& report) {
  if (!obstacle.friction_ratio) return;
  const double ratio = *obstacle.friction_ratio;
  obstacle.friction_ratio.reset();
  const std::string name = "obstacle.friction_ratio";
  for (const auto& p : parameters_of<MaterialParameters>().all()) {
    if (!report.sound("material." + p.info.name)) return;
  }
  if (!report.sound(name)) return;
  const std::optional<double> own = material.internal_friction();
  if (!own) {
    return report.problem(name,
                          "is a part of the material's own friction, and \"" + std::string(material.name()) + "\" has none; give friction");
  }
  obstacle.friction = ratio == 0.0 ? 0.0 : ratio * *own;
  if (obstacle.friction > ObstacleSpec::most_friction) {
    report.problem(name, "= " + number_text(ratio) + " makes a friction of " + number_text(obstacle.friction) + "; it has to be at most " +
                             number_text(ObstacleSpec::most_friction) + ": give a smaller ratio, or friction itself");
  }
}

namespace {

template <ObstacleShape... S>
bool shapes_are_sound(std::type_identity<std::variant<S...>>, const ParameterReport& report) {
  const auto sound = [&](const auto& parameter) { return report.sound("obstacle." + parameter.info.name); };
  return (std::ranges::all_of(parameters_of<S>().all(), sound) && ...);
}

}  // namespace

bool plan_is_sound(const ParameterReport& report) {
  return report.all_sound({"obstacle", "obstacle.shape"}) && shapes_are_sound(std::type_identity<AnyShape>{}, report);
}

}  // namespace mpm
