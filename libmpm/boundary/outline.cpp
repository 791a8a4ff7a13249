#include "libmpm/boundary/outline.hpp"

#include <cmath>
#include <numbers>

namespace mpm {

namespace {

constexpr double rounding = 1e-9;  // m, and of unit vectors: distances are sums of rounded numbers
constexpr double infinite = std::numeric_limits<double>::infinity();

}  // namespace

Outline::Outline(const std::vector<Vec2>& corners) { set_sides(corners); }

Outline::Outline(const Circle& circle) : circle_(circle) {
  constexpr int chords = 256;  // 7.5e-5 of the radius short of the circle
  std::vector<Vec2> corners;
  for (int i = 0; i < chords; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / chords;
    corners.emplace_back(circle.centre + circle.radius * Vec2(std::cos(angle), std::sin(angle)));
  }
  set_sides(corners);
}

void Outline::set_sides(const std::vector<Vec2>& corners) {
  sides_.clear();
  bounds_.setEmpty();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &from = corners[i], &to = corners[(i + 1) % corners.size()];
    const Vec2 along = (to - from).normalized(), normal(along.y(), -along.x());
    sides_.push_back({from, to, normal, normal.dot(from)});
    bounds_.extend(from);
  }
  if (circle_) bounds_.extend(Vec2(circle_->centre.array() - circle_->radius)).extend(Vec2(circle_->centre.array() + circle_->radius));
}

bool Outline::symmetric() const {
  const double tolerance = 1e-9 * bounds_.sizes().y();
  return std::ranges::all_of(sides_, [&](const Side& a) {
    return std::ranges::any_of(sides_, [&](const Side& b) { return (Vec2(a.from.x(), -a.from.y()) - b.from).norm() <= tolerance; });
  });
}

bool Outline::along_axes() const {
  return !circle_ && std::ranges::all_of(sides_, [](const Side& side) { return side.normal.cwiseAbs().minCoeff() < rounding; });
}

double Outline::area() const {
  if (circle_) return std::numbers::pi * circle_->radius * circle_->radius;
  double twice = 0.0;
  for (const Side& side : sides_) twice += side.from.x() * side.to.y() - side.to.x() * side.from.y();
  return 0.5 * twice;
}

Vec2 Outline::centre() const {
  if (circle_) return circle_->centre;
  Vec2 moment = Vec2::Zero();
  for (const Side& side : sides_) {  // shoelace formula
    const double cross = side.from.x() * side.to.y() - side.to.x() * side.from.y();
    moment += cross * (side.from + side.to) / 6.0;
  }
  return moment / area();
}

std::optional<Interval> Outline::section(double y) const {
  if (circle_) {
    const double arm = y - circle_->centre.y();
    if (std::abs(arm) >= circle_->radius) return {};
    const double half = std::sqrt(circle_->radius * circle_->radius - arm * arm);
    return Interval{circle_->centre.x() - half, circle_->centre.x() + half};
  }
  Interval cut{-infinite, infinite};
  for (const Side& side : sides_) {
    const double n_x = side.normal.x(), end = -side.distance({0.0, y});  // n_x x <= end
    if (n_x < -rounding) cut.low = std::max(cut.low, end / n_x);
    if (n_x > rounding) cut.high = std::min(cut.high, end / n_x);
    if (std::abs(n_x) <= rounding && end < 0.0) return {};
  }
  return cut.low < cut.high ? std::optional(cut) : std::nullopt;
}

Vec2 Outline::nearest_from_outside(const Vec2& x) const {
  Vec2 nearest = x;
  double least = infinite;  // square of the distance
  for (const Side& side : sides_) {
    if (side.distance(x) <= 0.0) continue;
    const Vec2 point = side.nearest(x);
    if (const double square = (x - point).squaredNorm(); square < least) least = square, nearest = point;
  }
  return nearest;
}

Outline::Nearest Outline::nearest(const Vec2& x) const {
  if (circle_) {
    const Vec2 arm = x - circle_->centre;
    const double r = arm.norm();
    const Vec2 normal = r > rounding * circle_->radius ? Vec2(arm / r) : Vec2(-Vec2::UnitX());  // upstream from the centre
    return {r - circle_->radius, normal, circle_->centre + circle_->radius * normal};
  }
  Nearest nearest{-infinite, Vec2::Zero(), x};
  Vec2 sum = Vec2::Zero();  // of the normals of the nearest sides that are equally far upstream
  for (const Side& side : sides_) {
    const double d = side.distance(x), nearer = d - nearest.distance, further_up = nearest.normal.x() - side.normal.x();
    if (nearer > rounding || (nearer > -rounding && further_up > rounding)) {
      nearest = {d, side.normal, x};
      sum = side.normal;
    } else if (nearer > -rounding && further_up > -rounding) {
      sum += side.normal;
    }
  }
  if (sum != nearest.normal && sum.norm() > rounding) nearest.normal = sum.normalized();  // those of a thin plate cancel: the first
  if (nearest.distance > 0.0) {
    nearest.point = nearest_from_outside(x);
    nearest.distance = (x - nearest.point).norm();
  } else {
    nearest.point = x - nearest.distance * nearest.normal;
  }
  return nearest;
}

double Outline::distance(const Vec2& x) const {
  if (circle_) return (x - circle_->centre).norm() - circle_->radius;
  double inside = -infinite;
  for (const Side& side : sides_) inside = std::max(inside, side.distance(x));
  return inside > 0.0 ? (x - nearest_from_outside(x)).norm() : inside;
}

Outline::Nearest Outline::nearest_of_front(const Vec2& x) const {
  const std::optional<Interval> strip = section(x.y());
  Nearest near = nearest(x);
  if (!strip || x.x() < strip->low) {
    const Vec2 gap = x - near.point;
    const bool beside_corner = near.distance > rounding && near.normal.dot(gap) < (1.0 - 1e-12) * near.distance;
    if (beside_corner) near.normal = gap / near.distance;
    return near;
  }
  if (circle_) {
    if (x.x() < circle_->centre.x()) return near;
    return {circle_->centre.x() - circle_->radius - x.x(), -Vec2::UnitX(), circle_->centre - circle_->radius * Vec2::UnitX()};
  }
  near.distance = -infinite;
  for (const Side& side : sides_) {
    const double d = side.distance(x);
    if (side.normal.x() < -rounding && d > near.distance) near = {d, side.normal, x - d * side.normal};
  }
  return near;
}

bool Outline::is_ambiguous(const Vec2& x, double margin) const {
  if (circle_) return false;
  const double nearest = std::ranges::max_element(sides_, {}, [&](const Side& side) { return side.distance(x); })->distance(x);
  return std::ranges::count_if(sides_, [&](const Side& side) { return side.distance(x) > nearest - margin; }) > 1;
}

void Outline::translate(const Vec2& by) {
  if (circle_) circle_->centre += by;
  std::vector<Vec2> corners;
  for (const Side& side : sides_) corners.emplace_back(side.from + by);
  set_sides(corners);
}

}  // namespace mpm
