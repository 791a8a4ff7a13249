#pragma once
/// A typical obstacle of every shape: one entry a shape, more where a parameter changes how it meets the flow.

#include <numbers>
#include <string>
#include <vector>

#include "libmpm/boundary/obstacle_spec.hpp"

namespace mpm::testing {

/// An obstacle with a name for tests, in letters.
struct TypicalShape {
  std::string name;
  AnyShape shape;

  [[nodiscard]] ObstacleSpec obstacle() const { return {.shape = shape}; }
  [[nodiscard]] Outline outline() const { return outline_of(shape); }
};
inline void PrintTo(const TypicalShape& typical, std::ostream* out) { *out << typical.name; }

/// @param w  m: the width of the shape; no plan is wider than 1.4 w or longer than 1.4 w
inline std::vector<TypicalShape> typical_shapes(double w = 1.75) {
  constexpr double pi = std::numbers::pi;
  return {{"Box", BoxShape{.width = w, .depth = 0.75 * w}},
          {"TurnedBox", BoxShape{.width = w, .depth = 0.75 * w, .rotation = pi / 6.0}},
          {"BoxOnItsCorner", BoxShape{.width = 0.8 * w, .depth = 0.8 * w, .rotation = pi / 4.0}},
          {"Cylinder", CylinderShape{.width = w}},
          {"Wedge", WedgeShape{.width = w, .depth = w}}};
}

/// Those that a mirror plane may halve.
inline std::vector<TypicalShape> symmetric_shapes(double w = 1.75) {
  std::vector<TypicalShape> all = typical_shapes(w);
  std::erase_if(all, [](const TypicalShape& typical) { return !typical.outline().symmetric(); });
  return all;
}

}  // namespace mpm::testing
