#include "libmpm/impact/mast_axis.hpp"

#include <variant>

namespace mpm {

double mast_axis(const ObstacleSpec& mast) {
  const Outline outline = std::visit([](const auto& shape) { return shape.outline(); }, mast.shape);
  if (outline.circle) return outline.circle->centre.x();
  double area = 0.0, moment = 0.0;  // shoelace formula
  for (const auto& [from, to, normal] : outline.sides()) {
    const double cross = from.x() * to.y() - to.x() * from.y();
    area += 0.5 * cross;
    moment += cross * (from.x() + to.x()) / 6.0;
  }
  return moment / area;
}

}  // namespace mpm
