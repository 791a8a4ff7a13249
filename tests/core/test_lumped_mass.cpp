#include "libmpm/core/lumped_mass.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <complex>
#include <cstring>
#include <functional>
#include <random>
#include <vector>

#include "libmpm/boundary/shapes/any_shape.hpp"
#include "libmpm/core/grid_update.hpp"
#include "libmpm/core/transfer.hpp"
#include "support/node_field.hpp"

namespace mpm {
namespace {

using testing::find_node;
using testing::for_each_node;
using testing::particle_at;
using testing::random_node;
using testing::velocity_of;

constexpr double dx = 0.25, density = 300.0, tall = 100.0;

SurfaceSolid cylinder(double radius, double top = tall) {
  Outline outline = CylinderShape{.width = 2.0 * radius}.outline();
  outline.translate({-radius, 0.0});  // its axis in the origin
  return SurfaceSolid({.outline = outline, .top = top}, 0.0, Vec3::Zero(), dx, {});
}

/// A staggered lattice of eight particles a cell around a cylinder, one cell high. @param half  only y > 0
Grid around(double radius, bool half = false) {
  Grid grid(dx);
  const double reach = radius + 8.0 * dx, h = 0.5 * dx;
  const int count = static_cast<int>(reach / h);
  std::uint64_t id = 0;
  for (int i = -count; i < count; ++i) {
    for (int j = half ? 0 : -count; j < count; ++j) {
      for (int k = 0; k < 2; ++k) {
        // the rows move against each other along x only, so that y > 0 is the image of y < 0
        const int row = j >= 0 ? j : -j - 1;
        const Vec3 x((i + 0.25 + 0.38 * (row % 2)) * h, (j + 0.5) * h, (k + 0.5) * h);
        if (x.head<2>().norm() > radius) grid.insert(particle_at(x, id++, h * h * h));
      }
    }
  }
  grid.refresh();
  grid.keep_forces_apart(true);
  particle_to_grid(grid, {.dt = 1e-3, .density = density});  // masses
  return grid;
}

using Field = std::function<Vec3(const Index3&)>;
/// Sets the velocities before and after forces.
void set_fields(Grid& grid, const Field& before, const Field& by_forces) {
  for (const auto b : grid.own_blocks()) {
    const Index3& c = grid.block(b).coordinate;
    for (int n = 0; n < block_nodes; ++n) {
      const Index3 at = node_index(c, n);
      const Vec3 u = before(at), v = u + by_forces(at);
      grid.velocities_before_forces(b).node[n] = Node{u.x(), u.y(), u.z(), 1.0};
      grid.velocities(b).node[n] = Node{v.x(), v.y(), v.z(), grid.velocities(b).node[n][3]};
    }
  }
}
Field random_field(unsigned seed) {
  return [seed](const Index3& at) { return velocity_of(random_node(at, seed)); };
}
Field zero() {
  return [](const Index3&) -> Vec3 { return Vec3::Zero(); };
}

std::vector<NodeBlock> correction_of(const Grid& grid, const SurfaceSolid& solid, double relaxed) {
  std::vector<NodeBlock> change(static_cast<std::size_t>(*std::ranges::max_element(grid.own_blocks())) + 1);
  LumpedMassCorrection({&solid.solid()}, dx, density, relaxed).add_inner(grid, change);
  return change;
}
struct Sums {
  Vec3 total = Vec3::Zero(), moment = Vec3::Zero();  ///< moment: about the origin
  double size = 0.0;                                 ///< sum of the changes' sizes
};
Sums sums_of(const Grid& grid, const std::vector<NodeBlock>& change) {
  Sums sums;
  for (const auto b : grid.own_blocks()) {
    for (int n = 0; n < block_nodes; ++n) {
      const Vec3 v = velocity_of(change[static_cast<std::size_t>(b)].node[n]);
      sums.total += v;
      sums.moment += node_position(grid.block(b).coordinate, n, dx).cross(v);
      sums.size += v.norm();
    }
  }
  return sums;
}

TEST(LumpedMass, CorrectionConservesMomentumAndWithApicAngularMomentum) {
  Grid grid = around(1.0);
  set_fields(grid, random_field(3), random_field(4));
  for (const double relaxed : {0.3, 1.0}) {
    const Sums sums = sums_of(grid, correction_of(grid, cylinder(1.0), relaxed));
    EXPECT_GT(sums.size, 100.0);
    EXPECT_LE(sums.total.norm(), 1e-13 * sums.size);
    if (relaxed == 1.0) {
      EXPECT_LE(sums.moment.norm(), 1e-13 * 4.0 * sums.size);  // m: how far the nodes are
    }
  }
}

TEST(LumpedMass, UniformForcesAndLinearMotionNeedNoCorrection) {
  Grid grid = around(1.0);
  Mat3 gradient;
  gradient << 0.3, -1.2, 0.4, 0.7, 0.1, -0.6, 0.2, 0.9, -0.5;
  set_fields(
      grid, [&](const Index3& at) -> Vec3 { return Vec3(3, -2, 1) + dx * gradient * Vec3(at[0], at[1], at[2]); },
      [](const Index3&) -> Vec3 { return Vec3(0.1, -0.2, -0.3); });
  EXPECT_LE(sums_of(grid, correction_of(grid, cylinder(1.0), 1.0)).size, 1e-10);
  set_fields(grid, zero(), [&](const Index3& at) -> Vec3 { return dx * gradient * Vec3(at[0], at[1], at[2]); });
  EXPECT_GT(sums_of(grid, correction_of(grid, cylinder(1.0), 1.0)).size, 1.0);  // forces that vary, where kernels are cut off
}

TEST(LumpedMass, ShareFallsToZeroAwayFromTheSide) {
  const SurfaceSolid solid = cylinder(1.0, 3.0);
  const LumpedMassCorrection c({&solid.solid()}, dx, density, 0.0);
  const double full = LumpedMassCorrection::full_reach, fade = LumpedMassCorrection::fade;
  const auto before_the_side = [&](double cells) { return c.weight({0.0, 1.0 + cells * dx, 1.0}); };
  EXPECT_EQ(before_the_side(0.0), 1.0);
  EXPECT_EQ(before_the_side(full - 1e-9), 1.0);
  EXPECT_NEAR(before_the_side(full + 0.5 * fade), 0.5, 1e-12);
  EXPECT_EQ(before_the_side(full + fade + 1e-9), 0.0);
  EXPECT_NEAR(c.weight({0.0, 1.0, 3.0 + (full + 0.5 * fade) * dx}), 0.5, 1e-12);  // above the top
  for (double x = -20.0; x < 20.0; x += 0.31) {                                   // no column is missed
    for (double y = -20.0; y < 20.0; y += 0.31) {
      const Vec3 at(dx * x, dx * y, 0.0);
      const auto block = [](double cells) { return static_cast<std::int32_t>(std::floor((cells - 0.5 - first_node(0)) / block_edge)); };
      EXPECT_TRUE(c.weight(at) == 0.0 || c.reaches(block(x), block(y))) << x << " " << y;
    }
  }
}

/// A wall holds the nodes behind it whatever its place in the list: it acts on the corrected velocities, too.
TEST(LumpedMass, AnObliqueWallActsAfterTheCorrection) {
  const SurfaceSolid solid = cylinder(1.0);
  const Vec3 normal = Vec3(1.0, 1.0, 0.0).normalized();
  const Wall wall{.point = -(1.0 + 3.5 * dx) * normal, .normal = normal, .contact = Contact::separable};
  for (const std::vector<Boundary>& boundaries : {std::vector<Boundary>{wall, solid}, std::vector<Boundary>{solid, wall}}) {
    Grid grid = around(1.0);
    for_each_node(grid, [&](Node& n, const Index3& at) {
      const Vec3 momentum = n[3] * velocity_of(random_node(at, 5));
      n = Node{momentum.x(), momentum.y(), momentum.z(), n[3]};
    });
    for (const auto b : grid.own_blocks()) {
      for (int n = 0; n < block_nodes; ++n) {
        const Vec3 impulse = grid.momenta(b).node[n][3] * velocity_of(random_node(node_index(grid.block(b).coordinate, n), 6));
        grid.force_impulses(b).node[n] = Node{impulse.x(), impulse.y(), impulse.z(), 0.0};
      }
    }
    update_grid(grid, {.boundaries = boundaries, .layered = {}, .density = density, .relaxed = 0.3}, 1e-3, 0.0);
    int behind = 0;
    for_each_node(grid, [&](Node& n, const Index3& at) {
      if (n[3] <= 0.0 || !wall.covers(dx * Vec3(at[0], at[1], at[2]), 0.0)) return;
      EXPECT_GE(velocity_of(n).dot(normal), -1e-12) << at[0] << ' ' << at[1] << ' ' << at[2];
      ++behind;
    });
    EXPECT_GT(behind, 20);
  }
}

/// Near an edge it counts from the corner, and not from the line of a side, which may pass far away from a sharp edge and yet be near.
TEST(LumpedMass, ShareOfAPolygonCountsFromItsNearestPoint) {
  const double full = LumpedMassCorrection::full_reach, fade = LumpedMassCorrection::fade;
  const Outline wedge({{0.0, 0.0}, {4.0, -4.0 * std::tan(0.1745)}, {4.0, 4.0 * std::tan(0.1745)}});  // 20 degrees, its edge in the origin
  const SurfaceSolid solid({.outline = wedge}, 0.0, Vec3::Zero(), dx, {});
  const LumpedMassCorrection c({&solid.solid()}, dx, density, 0.0);
  EXPECT_EQ(c.weight({1.0, 0.0, 0.0}), 1.0);  // inside
  EXPECT_NEAR(c.weight({-(full + 0.5 * fade) * dx, 0.0, 0.0}), 0.5, 1e-12);
  EXPECT_EQ(c.weight({-(full + fade + 1e-9) * dx, 0.0, 0.0}), 0.0);
  EXPECT_NEAR(c.weight({2.0, 2.0 * std::tan(0.1745) + (full + 0.5 * fade) * dx / std::cos(0.1745), 0.0}), 0.5, 1e-12);
}

TEST(LumpedMass, ShareNearTwoSolidsIsTheLarger) {
  const SurfaceSolid mast = cylinder(1.0), low = cylinder(1.5, 0.5);
  const LumpedMassCorrection first({&mast.solid()}, dx, density, 1.0), second({&low.solid()}, dx, density, 1.0),
      both({&mast.solid(), &low.solid()}, dx, density, 1.0);
  std::mt19937_64 random{7};
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x = Vec3(4.0 * unit(random), 4.0 * unit(random), 2.0 * unit(random));
    EXPECT_EQ(both.weight(x), std::max(first.weight(x), second.weight(x)));
  }
}

/// The computed half with its image has the same corrections as the whole.
TEST(LumpedMass, HalfGivesWhatTheWholeGives) {
  const auto even = [](const Index3& at) -> Vec3 {
    const Index3 up = {at[0], std::abs(at[1]), at[2]};
    Vec3 v = velocity_of(random_node(up, 5));
    if (at[1] == 0) v.y() = 0.0;
    if (at[1] < 0) v.y() = -v.y();
    return v;
  };
  Grid whole = around(1.0), half = around(1.0, true);
  const MirrorPlanes mirror{false, true};
  set_fields(whole, even, even);
  set_fields(half, even, even);
  const auto of_whole = correction_of(whole, cylinder(1.0), 0.2);
  auto of_half = correction_of(half, cylinder(1.0), 0.2);
  add_mirror_images(half, mirror, NodeFields(of_half), half.own_blocks());
  double largest = 0.0;
  for (const auto b : half.own_blocks()) {
    const Index3& c = half.block(b).coordinate;
    if (c[1] < 0) continue;
    for (int n = 0; n < block_nodes; ++n) {
      const Vec3 change = velocity_of(of_half[static_cast<std::size_t>(b)].node[n]);
      largest = std::max(largest, change.norm());
      EXPECT_LE((change - velocity_of(of_whole[static_cast<std::size_t>(whole.find(c))].node[n])).norm(), 1e-12);
    }
  }
  EXPECT_GT(largest, 0.1);
}

TEST(LumpedMass, SameBitsOnAnyNumberOfThreads) {
  const auto of = [&](int threads) {
    omp_set_num_threads(threads);
    Grid grid = around(1.0);
    set_fields(grid, random_field(3), random_field(4));
    auto change = correction_of(grid, cylinder(1.0), 0.3);
    omp_set_num_threads(1);
    return change;
  };
  const auto one = of(1), three = of(3);
  ASSERT_EQ(one.size(), three.size());
  EXPECT_EQ(std::memcmp(one.data(), three.data(), one.size() * sizeof(NodeBlock)), 0);
}

/// Potential flow around a cylinder, U = 1: dv/dt, exact.
Vec3 acceleration(double radius, const Vec3& x) {
  const std::complex<double> z(x.x(), x.y());
  const auto a = std::conj(2.0 * radius * radius / (z * z * z)) * (1.0 - radius * radius / (z * z));
  return {a.real(), a.imag(), 0.0};
}

/// What the transfer to the grid and back adds to the acceleration along the wall, as a multiple of its exact value times dx: the sum over
/// layers of a cell's fraction, on the windward side. @param corrected  with the correction
double excess(double radius, bool corrected) {
  Grid grid = around(radius);
  std::vector<Node> sums(grid.own_blocks().size() * block_nodes);
  const auto for_each_kernel = [&](auto&& f) {  // f(particle, its place, weight, node)
    grid.for_each_particle([&](const Particle& p) {
      const Vec3 x = testing::position_of(p);
      Index3 base;
      BsplineWeights<double> w[3];
      for (int i = 0; i < 3; ++i) {
        base[static_cast<std::size_t>(i)] = base_node(x[i] / dx);
        w[i] = bspline_weights(x[i] / dx - base[static_cast<std::size_t>(i)]);
      }
      const auto weight = [&](int axis, int n) { return n == 0 ? w[axis].n0 : n == 1 ? w[axis].n1 : w[axis].n2; };
      for (int n = 0; n < 27; ++n) {
        const Index3 at = {base[0] + n % 3, base[1] + n / 3 % 3, base[2] + n / 9};
        f(p, x, weight(0, n % 3) * weight(1, n / 3 % 3) * weight(2, n / 9), at);
      }
    });
  };
  set_fields(grid, zero(), zero());
  for_each_kernel([&](const Particle& p, const Vec3& x, double w, const Index3& at) {
    const Vec3 force = density * p.volume * w * acceleration(radius, x);
    Node& node = *find_node(grid, at);
    node += Node{force.x(), force.y(), 0.0, 0.0} / node[3];
  });
  if (corrected) {
    const auto change = correction_of(grid, cylinder(radius), 0.0);
    for (const auto b : grid.own_blocks()) {
      for (int n = 0; n < block_nodes; ++n) {
        Node& node = grid.velocities(b).node[n];
        if (node[3] > 0.0) node += Node{1, 1, 1, 0} * (change[static_cast<std::size_t>(b)].node[n] / node[3]);
      }
    }
  }
  constexpr int layers = 12;  // a quarter of a cell each
  double transferred[layers] = {}, exact[layers] = {};
  for_each_kernel([&](const Particle&, const Vec3& x, double w, const Index3& at) {
    const double r = x.head<2>().norm(), angle = std::atan2(std::abs(x.y()), -x.x());
    const int layer = static_cast<int>((r - radius) / (0.25 * dx));
    if (layer >= layers || angle < 0.3 || angle > 1.2) return;
    const Vec3 along(-x.y() * (x.y() > 0.0 ? -1.0 : 1.0) / r, x.x() * (x.y() > 0.0 ? -1.0 : 1.0) / r, 0.0);
    transferred[layer] += w * along.dot(velocity_of(*find_node(grid, at)));
    exact[layer] += w * along.dot(acceleration(radius, x));
  });
  double sum = 0.0;
  for (int k = 0; k < layers; ++k) sum += 0.25 * (transferred[k] / exact[k] - 1.0);
  return sum;
}

TEST(LumpedMass, CorrectionRemovesTheLackOfAccelerationAlongACylinder) {
  EXPECT_LT(excess(4.0 * dx, false), -0.15);  // lumped: that of a fifth of a cell is missing
  EXPECT_LT(std::abs(excess(4.0 * dx, true)), 0.04);
  EXPECT_LT(excess(8.0 * dx, false), -0.08);
  EXPECT_LT(std::abs(excess(8.0 * dx, true)), 0.02);
}

}  // namespace
}  // namespace mpm
