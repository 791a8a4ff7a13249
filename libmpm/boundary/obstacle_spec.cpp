#include "libmpm/boundary/obstacle_spec.hpp"

#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/material/any_material.hpp"

namespace mpm {

void ObstacleSpec::resolve_friction(const MaterialParameters& material, ParameterReport& report) {
  if (!friction_ratio) return;
  const double ratio = *friction_ratio;
  friction_ratio.reset();
  const char* const name = "friction_ratio";
  if (!report.valid(name)) return;
  const std::optional<double> own = material.internal_friction();
  if (!own) {
    return report.problem(name,
                          "is a part of the material's own friction, and \"" + std::string(material.name()) + "\" has none; give friction");
  }
  friction = ratio == 0.0 ? 0.0 : ratio * *own;
  if (friction > most_friction) {
    report.problem(name, "= " + number_text(ratio) + " makes a friction of " + number_text(friction) + "; it has to be at most " +
                             number_text(most_friction) + ": give a smaller ratio, or friction itself");
  }
}

namespace {

template <ObstacleShape... S>
bool shapes_are_valid(std::type_identity<std::variant<S...>>, const ParameterReport& report) {
  const auto valid = [&](const auto& parameter) { return report.valid(parameter.info.name); };
  return (std::ranges::all_of(parameters_of<S>().all(), valid) && ...);
}

}  // namespace

bool ObstacleSpec::plan_is_valid(const ParameterReport& report) {
  return report.all_valid({"", "shape"}) && shapes_are_valid(std::type_identity<AnyShape>{}, report);
}

void ArmSpec::check_on(const ObstacleSpec& obstacle, const std::string& carrier, ParameterReport& report) const {
  const Outline outline = outline_of(obstacle.shape);
  const double width = outline.bounds().sizes().y(), deepest = 2.0 * outline.centre().x(), top = obstacle.solid().top;
  const auto check = [&](bool wrong, const char* key, double value, const std::string& text) {
    if (wrong && report.valid(key)) report.problem(key, "= " + number_text(value) + " " + text);
  };
  check(length <= width, "length_m", length,
        "does not reach beyond the " + carrier + ", " + number_text(width) + " m across the flow; give a longer one");
  check(front_x(obstacle) < -1e-9 * deepest, "depth_m", depth,
        "reaches upstream of the " + carrier + ", where the snow begins; give at most " + number_text(deepest) + " m");
  check(base >= top, "base_m", base, "is not below the top of the " + carrier + ", " + number_text(top) + " m");
}

}  // namespace mpm
