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
  const double reach = solid.skin + on_surface;
  return low.x() <= max_x + reach && high.x() >= min_x - reach && low.y() <= max_y + reach && high.y() >= min_y - reach &&
         below_top(solid, low.z());
}

bool RigidPrism::covers(const Vec3& node, double time) const {
  if (!reaches(node, node, time)) return false;
  return std::all_of(sides.begin(), sides.end(), [&](const Side& side) {
    return side.normal_x * node.x() + side.normal_y * node.y() - side.offset <= solid.skin + on_surface;
  });
}

Vec3 RigidPrism::constrain(const Vec3& node, const Vec3& v, double) const {
  const auto distance_to = [&](const Side& side) { return side.normal_x * node.x() + side.normal_y * node.y() - side.offset; };
  double nearest = distance_to(sides.front());
  for (const Side& side : sides) nearest = std::max(nearest, distance_to(side));
  Vec3 normal = Vec3::Zero();
  for (const Side& side : sides) {
    if (distance_to(side) >= nearest - on_surface) normal += Vec3(side.normal_x, side.normal_y, 0.0);
  }
  // normals of opposite sides of a thin plate cancel: use the first
  if (normal.squaredNorm() < 1e-12) normal = Vec3(sides.front().normal_x, sides.front().normal_y, 0.0);
  return constrain_vertical(solid, node, v, nearest, normal.normalized());
}

bool RigidCylinder::reaches(const Vec3& low, const Vec3& high, double) const {
  const double reach = radius + solid.skin + on_surface;
  return low.x() <= centre_x + reach && high.x() >= centre_x - reach && low.y() <= centre_y + reach && high.y() >= centre_y - reach &&
         below_top(solid, low.z());
}

bool RigidCylinder::covers(const Vec3& node, double) const {
  return below_top(solid, node.z()) && std::hypot(node.x() - centre_x, node.y() - centre_y) <= radius + solid.skin + on_surface;
}

Vec3 RigidCylinder::constrain(const Vec3& node, const Vec3& v, double) const {
  const Vec3 arm(node.x() - centre_x, node.y() - centre_y, 0.0);
  const double r = arm.norm();
  // on the axis all directions are equally near: use upstream
  return constrain_vertical(solid, node, v, r - radius, r > on_surface ? Vec3(arm / r) : Vec3(-Vec3::UnitX()));
}

void RigidPrism::translate(const Vec3& by) {
  solid.translate(by);
  for (auto& side : sides) side.offset += side.normal_x * by.x() + side.normal_y * by.y();
  for (double* x : {&min_x, &max_x}) *x += by.x();
  for (double* y : {&min_y, &max_y}) *y += by.y();
}

void RigidCylinder::translate(const Vec3& by) {
  solid.translate(by);
  centre_x += by.x();
  centre_y += by.y();
}

}  // namespace mpm
