#include "libmpm/boundary/terrain.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace mpm {

namespace {

/// Value and derivative of the cubic between the second and the third of four points, at the fraction f of the way. In differences from the
/// second, so that equal values give exactly this value and no slope.
struct Cubic {
  double value, derivative;
  Cubic(const std::array<double, 4>& p, double f) {
    const double a = p[0] - p[1], c = p[2] - p[1], d = p[3] - p[1];
    const double first = 0.5 * (c - a), second = a + 2.0 * c - 0.5 * d, third = 0.5 * (d - a) - 1.5 * c;
    value = p[1] + f * (first + f * (second + f * third));
    derivative = first + f * (2.0 * second + 3.0 * f * third);
  }
};

/// The interval that holds a coordinate along one axis, and the place in it.
struct RasterInterval {
  std::size_t index;  ///< of its first point
  double fraction;    ///< 0 .. 1
  double beyond;      ///< spacings from the nearest place that the points span
  RasterInterval(double coordinate, std::size_t count) {
    const double inside = std::clamp(coordinate, 0.0, static_cast<double>(count - 1));
    beyond = coordinate - inside;
    index = std::min(static_cast<std::size_t>(inside), count - 2);
    fraction = inside - static_cast<double>(index);
  }
};

/// Four values around an interval; beyond the ends the line through the last two.
template <class F>
std::array<double, 4> around(std::size_t index, std::size_t count, F&& value) {
  std::array<double, 4> v{0.0, value(index), value(index + 1), 0.0};
  v[0] = index > 0 ? value(index - 1) : 2.0 * v[1] - v[2];
  v[3] = index + 2 < count ? value(index + 2) : 2.0 * v[2] - v[1];
  return v;
}

}  // namespace

HeightField::HeightField(Points points) : points_(std::move(points)) {
  const auto [low, high] = std::ranges::minmax(points_.height);
  constexpr double overshoot = 0.29;  // the negative weights of the two-dimensional cubic sum up to at most (1.25^2 - 1)/2
  lowest_ = low - overshoot * (high - low);
  highest_ = high + overshoot * (high - low);
}

Vec2 HeightField::last() const {
  return points_.first + points_.spacing * Vec2(static_cast<double>(points_.columns - 1), static_cast<double>(points_.rows - 1));
}

HeightField::Surface HeightField::at(const Vec2& place) const {
  const Vec2 cells = (place - points_.first) / points_.spacing;
  const RasterInterval x(cells.x(), points_.columns), y(cells.y(), points_.rows);
  const auto row = [&](std::size_t j) {
    return Cubic(around(x.index, points_.columns, [&](std::size_t i) { return points_.height[j * points_.columns + i]; }), x.fraction);
  };
  const auto along_x = [&](auto part) {
    return Cubic(around(y.index, points_.rows, [&](std::size_t j) { return row(j).*part; }), y.fraction);
  };
  const Cubic height = along_x(&Cubic::value), slope_x = along_x(&Cubic::derivative);
  const Vec2 slope(slope_x.value, height.derivative);
  return {height.value + slope.x() * x.beyond + slope.y() * y.beyond, slope / points_.spacing};
}

HeightField::Surface Terrain::surface(const Vec3& x) const {
  HeightField::Surface found = field->at(x.head<2>() - shift.head<2>());
  found.height += shift.z();
  return found;
}

Vec3 Terrain::surface_velocity(const Vec3& x, double) const { return speed == 0.0 ? Vec3(Vec3::Zero()) : velocity(surface(x).slope); }

bool Terrain::reaches(const Vec3& low, const Vec3& high, double) const {
  // beyond the raster the ground may rise above its highest point: there each node is asked
  const Vec2 from = field->points().first + shift.head<2>(), to = field->last() + shift.head<2>();
  const bool within = low.x() >= from.x() && low.y() >= from.y() && high.x() <= to.x() && high.y() <= to.y();
  return !within || low.z() <= field->highest() + shift.z() + on_surface;
}

bool Terrain::covers(const Vec3& node, double) const { return node.z() - surface(node).height <= on_surface; }

Vec3 Terrain::constrain(const Vec3& node, const Vec3& v, double) const {
  const HeightField::Surface here = surface(node);
  return contact_velocity(v, here.normal(), velocity(here.slope), contact, friction);
}

}  // namespace mpm
