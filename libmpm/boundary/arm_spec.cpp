#include "libmpm/boundary/arm_spec.hpp"

#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"

namespace mpm {

void ArmSpec::check_on(const ObstacleSpec& obstacle, const std::string& carrier, ParameterReport& report) const {
  const Outline outline = outline_of(obstacle.shape);
  const double width = outline.bounds().sizes().y(), deepest = 2.0 * outline.centre().x(), top = obstacle.solid().top;
  const auto check = [&](bool wrong, const char* key, double value, const std::string& text) {
    if (wrong && report.valid(key)) report.problem(key, "= " + number_text(value) + " " + text);
  };
  check(length <= width, "length_m", length,
        "does not reach beyond the " + carrier + ", " + number_text(width) + " m across the flow; give a longer one");
  check(front_x(obstacle) < 0.0, "depth_m", depth,
        "reaches upstream of the " + carrier + ", where the snow begins; give at most " + number_text(deepest) + " m");
  check(base >= top, "base_m", base, "is not below the top of the " + carrier + ", " + number_text(top) + " m");
}

}  // namespace mpm
