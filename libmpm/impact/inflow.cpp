#include "libmpm/impact/inflow.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

Inflow::Inflow(const ConveyorSpec& conveyor) : slip_ratio_(conveyor.slip_ratio), exponent_(conveyor.shear_exponent) {
  for (const InflowPoint& p : conveyor.inflow) {
    points_.push_back({p.time, p.velocity.value_or(conveyor.velocity), p.flow_height.value_or(conveyor.flow_height), p.density_ratio, 0.0});
  }
  if (points_.empty()) points_.push_back({0.0, conveyor.velocity, conveyor.flow_height, 1.0, 0.0});
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const Point& before = points_[i - 1];
    points_[i].travelled = before.travelled + 0.5 * (before.velocity + points_[i].velocity) * (points_[i].time - before.time);
  }
}

Inflow::Between Inflow::between(double time) const {
  const auto after = std::find_if(points_.begin(), points_.end(), [&](const Point& p) { return p.time > time; });
  if (after == points_.begin()) return {&points_.front(), &points_.front(), 0.0};
  if (after == points_.end()) return {&points_.back(), &points_.back(), 0.0};
  const Point &a = *(after - 1), &b = *after;
  return {&a, &b, (time - a.time) / (b.time - a.time)};
}

double Inflow::interpolated(double time, double Point::*what) const {
  const Between p = between(time);
  return p.a->*what + p.fraction * (p.b->*what - p.a->*what);
}

double Inflow::travelled_since_first(double time) const {
  const Between p = between(time);
  return p.a->travelled + 0.5 * (p.a->velocity + velocity(time)) * (time - p.a->time);
}

double Inflow::travelled(double time) const {
  if (steady()) return points_.front().velocity * time;
  return travelled_since_first(time) - travelled_since_first(0.0);
}

double Inflow::fastest() const { return std::ranges::max_element(points_, {}, &Point::velocity)->velocity; }

double Inflow::highest() const { return std::ranges::max_element(points_, {}, &Point::flow_height)->flow_height; }

double Inflow::shear(double relative_height) const {
  if (!sheared()) return 1.0;
  return slip_ratio_ + (1.0 - slip_ratio_) * (1.0 + exponent_) * std::pow(std::clamp(relative_height, 0.0, 1.0), exponent_);
}

double Inflow::mean_shear(double from, double to) const {
  if (!sheared()) return 1.0;
  return slip_ratio_ + (1.0 - slip_ratio_) * (std::pow(to, 1.0 + exponent_) - std::pow(from, 1.0 + exponent_)) / (to - from);
}

}  // namespace mpm
