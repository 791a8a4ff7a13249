#pragma once
/// Grids with given node values, for tests of contact.

#include <array>
#include <random>
#include <vector>

#include "libmpm/core/mirror.hpp"
#include "support/solver_states.hpp"

namespace mpm::testing {

/// A grid with the nodes first_node(low) .. first_node(high + 2) - 1 along each axis.
inline Grid grid_of_blocks(double dx, const Index3& low, const Index3& high) {
  Grid grid(dx);
  for (int z = low[2]; z <= high[2]; ++z) {
    for (int y = low[1]; y <= high[1]; ++y) {
      for (int x = low[0]; x <= high[0]; ++x) grid.insert(particle_at(dx * Vec3(4 * x + 2, 4 * y + 2, 4 * z + 2)));
    }
  }
  grid.refresh();
  return grid;
}

/// Null if there is no block.
inline Node* find_node(Grid& grid, const Index3& n) {
  const auto b = grid.find(block_of_node(n));
  return b == no_block ? nullptr : &grid.velocities(b).node[number_of_node(n)];
}

/// f(Node& with a velocity, const Index3&, fraction of it that belongs to the computed part)
template <class F>
void for_each_node(Grid& grid, const MirrorPlanes& mirror, F&& f) {
  for (const auto b : grid.own_blocks()) {
    const Index3& c = grid.block(b).coordinate;
    for (int n = 0; n < block_nodes; ++n) f(grid.velocities(b).node[n], node_index(c, n), computed_fraction(mirror, c, n));
  }
}
template <class F>
void for_each_node(Grid& grid, F&& f) {
  for_each_node(grid, {}, [&](Node& n, const Index3& at, double) { f(n, at); });
}

inline Vec3 velocity_of(const Node& n) { return {n[0], n[1], n[2]}; }
inline Node node_of(const Vec3& v, double mass) { return Node{v.x(), v.y(), v.z(), mass}; }

/// Velocities up to 5 m/s an axis and masses from 0.1 to 2 kg, functions of a node's coordinates, equal on every grid.
inline Node random_node(const Index3& at, unsigned seed) {
  std::seed_seq sequence{static_cast<unsigned>(at[0] + 1000), static_cast<unsigned>(at[1] + 1000), static_cast<unsigned>(at[2] + 1000),
                         seed};
  std::minstd_rand random(sequence);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double x = unit(random), y = unit(random), z = unit(random), m = unit(random);
  return Node{10.0 * x - 5.0, 10.0 * y - 5.0, 10.0 * z - 5.0, 0.1 + 1.9 * m};
}

/// Impulse on a boundary, from the velocities before and after.
struct Taken {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  double scale = 0.0, angular_scale = 0.0;  ///< of the terms
};
inline Taken taken_between(Grid& before, Grid& after, const MirrorPlanes& mirror, const Vec3& reference) {
  Taken sum;
  for_each_node(before, mirror, [&](Node& n, const Index3& at, double fraction) {
    const Node& m = *find_node(after, at);
    EXPECT_EQ(n[3], m[3]);
    const Vec3 x = before.cell_size() * Vec3(at[0], at[1], at[2]) - reference, p = fraction * n[3] * (velocity_of(n) - velocity_of(m));
    sum.linear += p;
    sum.angular += x.cross(p);
    sum.scale += fraction * n[3] * velocity_of(n).norm();
    sum.angular_scale += x.norm() * fraction * n[3] * velocity_of(n).norm();
  });
  return sum;
}

}  // namespace mpm::testing
