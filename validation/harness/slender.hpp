#pragma once
/// Bars, columns and layers that are one particle across, between frictionless side walls.

#include <initializer_list>

#include "libmpm/driver/case.hpp"

namespace mpm::validation {

/// Gives the first body, which starts at 0 along these axes, and the walls on its far sides another width. @param side  m
inline void set_side(Case& c, double side, std::initializer_list<int> axes) {
  for (const int axis : axes) {
    c.bodies.at(0).max[axis] = side;
    for (WallSpec& wall : c.walls)
      if (wall.point[axis] > 0.0) wall.point[axis] = side;
  }
}

}  // namespace mpm::validation
