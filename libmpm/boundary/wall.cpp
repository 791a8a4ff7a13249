#include "libmpm/boundary/wall.hpp"

#include <cmath>
#include <limits>

namespace mpm {

bool Wall::covers(const Vec3& node, double time) const {
  const double shift = travels ? time * velocity.dot(normal) : 0.0;
  return (node - point).dot(normal) - shift <= on_surface;
}

bool Wall::reaches(const Vec3& low, const Vec3& high, double time) const {
  Vec3 deepest;
  for (int i = 0; i < 3; ++i) deepest[i] = normal[i] > 0.0 ? low[i] : high[i];
  return covers(deepest, time);
}

Vec3 Wall::constrain(const Vec3& node, const Vec3& v, double time) const {
  return contact_velocity(v, normal, surface_velocity(node, time), contact, friction);
}

Vec3 WallSpec::unit(const Vec3& n) {
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();  // of normalising: a few ulp in the square
  const double length = n.stableNorm();
  return length == 0.0 || std::abs(n.squaredNorm() - 1.0) < rounding ? n : Vec3(n / length);
}

Wall WallSpec::boundary(const BoundarySetting& setting) const {
  return {point, normal.normalized(), contact, friction, velocity, true, setting.rule};
}

}  // namespace mpm
