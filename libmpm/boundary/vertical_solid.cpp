#include "libmpm/boundary/vertical_solid.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

bool below_top(const VerticalSolid& solid, double z) { return z <= solid.top + on_surface; }

/// The velocity after contact with the nearest face. @param distance  in front of the nearest side, negative inside
Vec3 constrain_vertical(const VerticalSolid& solid, const Vec3& node, const Vec3& v, double distance, const Vec3& side_normal) {
  const bool top = node.z() - solid.top > distance + on_surface;
  return contact_velocity(v, top ? Vec3::UnitZ() : side_normal, Vec3::Zero(), solid.contact, solid.friction);
}

}  // namespace

bool RigidPrism::reaches(const Vec3& low, const Vec3& high, double) const {
  const double reach = skin + on_surface;
  return low.x() <= max_x + reach && high.x() >= min_x - reach && low.y() <= max_y + reach && high.y() >= min_y - reach &&
         below_top(*this, low.z());
}

bool RigidPrism::covers(const Vec3& node, double time) const {
  if (!reaches(node, node, time)) return false;
  return std::all_of(sides.begin(), sides.end(),
                     [&](const HalfPlane& side) { return side.distance(node.x(), node.y()) <= skin + on_surface; });
}

Vec3 RigidPrism::constrain(const Vec3& node, const Vec3& v, double) const {
  const auto distance_to = [&](const HalfPlane& side) { return side.distance(node.x(), node.y()); };
  double nearest = distance_to(sides.front());
  for (const HalfPlane& side : sides) nearest = std::max(nearest, distance_to(side));
  Vec3 normal = Vec3::Zero();
  for (const HalfPlane& side : sides) {
    if (distance_to(side) >= nearest - on_surface) normal.head<2>() += side.normal;
  }
  // normals of opposite sides of a thin plate cancel: use the first
  if (normal.squaredNorm() < 1e-12) normal.head<2>() = sides.front().normal;
  return constrain_vertical(*this, node, v, nearest, normal.normalized());
}

bool RigidCylinder::reaches(const Vec3& low, const Vec3& high, double) const {
  const double reach = circle.radius + skin + on_surface;
  const Vec2& centre = circle.centre;
  return low.x() <= centre.x() + reach && high.x() >= centre.x() - reach && low.y() <= centre.y() + reach &&
         high.y() >= centre.y() - reach && below_top(*this, low.z());
}

bool RigidCylinder::covers(const Vec3& node, double) const {
  return below_top(*this, node.z()) &&
         std::hypot(node.x() - circle.centre.x(), node.y() - circle.centre.y()) <= circle.radius + skin + on_surface;
}

Vec3 RigidCylinder::constrain(const Vec3& node, const Vec3& v, double) const {
  const Vec3 arm(node.x() - circle.centre.x(), node.y() - circle.centre.y(), 0.0);
  const double r = arm.norm();
  // on the axis all directions are equally near: use upstream
  return constrain_vertical(*this, node, v, r - circle.radius, r > on_surface ? Vec3(arm / r) : Vec3(-Vec3::UnitX()));
}

void RigidPrism::translate(const Vec3& by) {
  VerticalSolid::translate(by);
  for (HalfPlane& side : sides) side.translate(by.head<2>());
  for (double* x : {&min_x, &max_x}) *x += by.x();
  for (double* y : {&min_y, &max_y}) *y += by.y();
}

void RigidCylinder::translate(const Vec3& by) {
  VerticalSolid::translate(by);
  circle.centre += by.head<2>();
}

}  // namespace mpm
