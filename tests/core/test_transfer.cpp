#include "libmpm/core/transfer.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <random>

#include "libmpm/core/stress_update.hpp"
#include "support/solver_states.hpp"

namespace mpm {
namespace {

using testing::affine_of;
using testing::particle_at;
using testing::position_of;
using testing::stress_of;
using testing::velocity_of;

constexpr double dx = 0.25, density = 300.0;

/// A node of the oracle: what the docstring's sums give, and a scale for their round-off: the sum of the sizes of all terms, unweighted.
struct MockNode {
  double mass = 0.0;
  Vec3 momentum = Vec3::Zero();
  double mass_scale = 0.0, momentum_scale = 0.0;
};
using MockGrid = std::map<std::array<int, 3>, MockNode>;

/// Relative to those scales. Coordinates of up to 30 cells carry a round-off of 30 eps = 7e-15 into the offset, thus into each of three
/// weights (slope at most 1); 1e-13 leaves room for the sums of some hundred terms.
constexpr double round_off = 1e-13;

double weight(double x, int node) {  // N(x/dx - node), the textbook's three branches
  const double d = std::abs(x / dx - node);
  return d <= 0.5 ? 0.75 - d * d : d <= 1.5 ? 0.5 * (1.5 - d) * (1.5 - d) : 0.0;
}

/// f(node index, weight, x_i - x_p) on the 27 nodes of a particle at x.
template <class F>
void for_27_nodes(const Vec3& x, F&& f) {
  const std::array<int, 3> base = {base_node(x[0] / dx), base_node(x[1] / dx), base_node(x[2] / dx)};
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        const std::array<int, 3> n = {base[0] + i, base[1] + j, base[2] + k};
        f(n, weight(x[0], n[0]) * weight(x[1], n[1]) * weight(x[2], n[2]), Vec3(dx * Vec3(n[0], n[1], n[2]) - x));
      }
    }
  }
}

MockGrid mock_particle_to_grid(const std::vector<Particle>& particles, double dt, bool affine) {
  MockGrid grid;
  for (const Particle& p : particles) {
    const double m = density * p.volume;
    const Mat3 a = (affine ? m : 0.0) * affine_of(p) - dt * p.volume * (4.0 / (dx * dx)) * stress_of(p);
    for_27_nodes(position_of(p), [&](const std::array<int, 3>& n, double w, const Vec3& r) {
      MockNode& node = grid[n];
      node.mass += w * m;
      node.momentum += w * (m * velocity_of(p) + a * r);
      node.mass_scale += m;
      node.momentum_scale += m * velocity_of(p).norm() + a.norm() * dx;
    });
  }
  return grid;
}

Node& node_at(Grid& grid, const std::array<int, 3>& n) {
  const auto b = grid.find(block_of_node(n));
  EXPECT_NE(b, no_block);
  return grid.velocities(b).node[number_of_node(n)];
}

template <class F>
void for_each_node(Grid& grid, F&& f) {
  for (const auto b : grid.own_blocks()) {
    const Index3& c = grid.block(b).coordinate;
    for (int n = 0; n < block_nodes; ++n) {
      f(grid.velocities(b).node[n], node_index(c, n));
    }
  }
}

/// 1 to 27 particles in a third of the cells of some blocks on both sides of the origin, some lonely ones, and some exactly on nodes, ties
/// and edges of cells and blocks.
std::vector<Particle> cloud(unsigned seed, bool with_stress = true) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> inside(0.0, 1.0);
  std::vector<Particle> particles;
  const auto add = [&](const Vec3& x) {
    Particle p = particle_at(x, particles.size());
    testing::randomise(p, random);
    if (!with_stress) std::fill(std::begin(p.stress), std::end(p.stress), 0.0);
    particles.push_back(p);
  };
  for (int z = -6; z < 6; ++z) {
    for (int y = -5; y < 5; ++y) {
      for (int x = -7; x < 6; ++x) {
        if (random() % 3 != 0) continue;
        const auto count = 1 + random() % 27;
        for (unsigned long n = 0; n < count; ++n) add(dx * (Vec3(x, y, z) + Vec3(inside(random), inside(random), inside(random))));
      }
    }
  }
  for (int n = 0; n < 20; ++n) add(Vec3(4.0 + 0.7 * n, -7.0, 0.3 * n));
  for (int n = -18; n <= 18; ++n) add(0.5 * dx * Vec3(n, -n, n % 5));
  return particles;
}

void fill(Grid& grid, const std::vector<Particle>& particles) {
  for (const Particle& p : particles) grid.insert(p);
  grid.refresh();
}

/// Momentum to velocity, as update_grid does without gravity and boundaries.
void normalise(Grid& grid) {
  for_each_node(grid, [](Node& n, const auto&) {
    const double m = n[3];
    n = m > 0.0 ? n / m : Node{};
    n[3] = m;
  });
}

/// Sum over nodes of momentum and of x_i x momentum; nodes hold momentum, or velocity with `velocities`.
struct Sums {
  double mass = 0.0;
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
  double scale = 0.0, angular_scale = 0.0;  ///< of the terms
};
Sums node_sums(Grid& grid, bool velocities = false) {
  Sums s;
  for_each_node(grid, [&](Node& n, const std::array<int, 3>& i) {
    const Vec3 p = (velocities ? n[3] : 1.0) * Vec3(n[0], n[1], n[2]), x = dx * Vec3(i[0], i[1], i[2]);
    s.mass += n[3];
    s.momentum += p;
    s.angular += x.cross(p);
    s.scale += p.norm();
    s.angular_scale += x.norm() * p.norm();
  });
  return s;
}
Sums particle_sums(const std::vector<Particle>& particles, bool affine) {
  Sums s;
  for (const Particle& p : particles) {
    const double m = density * p.volume;
    const Mat3 c = affine_of(p);
    const Vec3 spin(c(2, 1) - c(1, 2), c(0, 2) - c(2, 0), c(1, 0) - c(0, 1));
    s.mass += m;
    s.momentum += m * velocity_of(p);
    s.angular += position_of(p).cross(m * velocity_of(p)) + (affine ? m * dx * dx / 4.0 : 0.0) * spin;
    s.scale += m * velocity_of(p).norm();
    s.angular_scale += m * position_of(p).norm() * velocity_of(p).norm() + m * dx * dx * c.norm();
  }
  return s;
}

class TransferMode : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(All, TransferMode, ::testing::Values(true, false), [](const auto& mode) { return mode.param ? "Apic" : "Flip"; });

/// Compares all nodes after particle_to_grid with the sums of its docstring.
void expect_sums_of_the_docstring(const std::vector<Particle>& particles, bool affine) {
  Grid grid(dx);
  fill(grid, particles);
  const TransferOptions options{2e-3, density, affine};
  for (int repeated = 0; repeated < 2; ++repeated) particle_to_grid(grid, options);  // overwrites, does not add
  const MockGrid mock = mock_particle_to_grid(particles, options.dt, options.affine);
  std::size_t touched = 0;
  for_each_node(grid, [&](Node& n, const std::array<int, 3>& i) {
    const auto it = mock.find(i);
    const MockNode expected = it == mock.end() ? MockNode{} : it->second;
    touched += it != mock.end();
    EXPECT_NEAR(n[3], expected.mass, round_off * expected.mass_scale);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(n[c], expected.momentum[c], round_off * expected.momentum_scale);
  });
  EXPECT_EQ(touched, mock.size());
}

TEST_P(TransferMode, ParticleToGridIsTheSumOfTheDocstring) { expect_sums_of_the_docstring(cloud(11), GetParam()); }

// More particles in a cell than the transfer takes through its passes at once (32), and exactly as many.
TEST_P(TransferMode, ParticleToGridSumsCrowdedCells) {
  for (const std::size_t count : {32U, 33U, 75U}) {
    auto particles = cloud(13);
    ASSERT_GE(particles.size(), count);
    particles.resize(count);
    for (Particle& p : particles) {
      for (double& x : p.position) x = dx * (7.6 + 0.8 * (x / dx - std::floor(x / dx)));  // into one cell: base node 7
    }
    expect_sums_of_the_docstring(particles, GetParam());
  }
}

TEST_P(TransferMode, GridToParticleIsTheSumOfTheDocstring) {
  const bool apic = GetParam();
  const auto particles = cloud(12);
  Grid grid(dx);
  grid.keep_forces_apart(!apic);
  fill(grid, particles);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-10.0, 10.0);
  for_each_node(grid, [&](Node& n, const auto&) { n = Node{unit(random), unit(random), unit(random), 1.0}; });
  for (const auto b : grid.own_blocks()) {
    if (apic) break;
    for (Node& n : grid.velocities_before_forces(b).node) n = Node{unit(random), unit(random), unit(random), 1.0};
  }
  const TransferOptions options{1e-3, density, apic, apic ? 0.0 : 0.9};
  double fastest = 0.0;
  std::vector<Particle> expected = particles;
  for (Particle& p : expected) {
    Vec3 v = Vec3::Zero(), old = Vec3::Zero();
    Mat3 c = Mat3::Zero();
    for_27_nodes(position_of(p), [&](const std::array<int, 3>& n, double w, const Vec3& r) {
      const Node& node = node_at(grid, n);
      const Vec3 vi(node[0], node[1], node[2]);
      v += w * vi;
      c += w * vi * r.transpose() * (4.0 / (dx * dx));
      if (apic) return;
      const Node& o = grid.velocities_before_forces(grid.find(block_of_node(n))).node[number_of_node(n)];
      old += w * Vec3(o[0], o[1], o[2]);
    });
    for (int i = 0; i < 3; ++i) {
      p.position[i] += options.dt * v[i];
      p.velocity[i] = apic ? v[i] : v[i] + options.retained * (p.velocity[i] - old[i]);
    }
    testing::set_affine(p, c);
    fastest = std::max(fastest, velocity_of(p).squaredNorm());
  }
  double reported = 0.0;
  for (const auto b : grid.occupied_blocks()) {
    const BlockMotion motion = grid_to_particle(grid, b, options);
    EXPECT_TRUE(motion.finite);
    EXPECT_TRUE(motion.within_reach);
    reported = std::max(reported, motion.max_speed_squared);
  }
  EXPECT_NEAR(reported, fastest, 1e-12 * fastest);
  const auto moved = testing::particles_by_id(grid);
  ASSERT_EQ(moved.size(), expected.size());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Particle &p = moved[i], &e = expected[i];
    ASSERT_EQ(p.id, e.id);
    EXPECT_LE((velocity_of(p) - velocity_of(e)).norm(), round_off * 30.0);                 // node velocities up to 10 m/s an axis
    EXPECT_LE((position_of(p) - position_of(e)).norm(), round_off * 30.0 * 1e-3 + 1e-14);  // and an ulp of 15 m
    EXPECT_LE((affine_of(p) - affine_of(e)).norm(), round_off * 30.0 * 4.0 / dx * 3.0);    // 4/dx^2 times arms of up to 1.5 dx
    EXPECT_EQ(p.volume, e.volume);                                                         // untouched
    EXPECT_EQ(p.internal, e.internal);
    for (int n = 0; n < 6; ++n) EXPECT_EQ(p.stress[n], e.stress[n]);
  }
}

TEST_P(TransferMode, ParticleToGridKeepsMassAndMomentumWhateverTheStress) {
  const auto particles = cloud(13);
  Grid grid(dx);
  fill(grid, particles);
  particle_to_grid(grid, {5e-3, density, GetParam()});
  const Sums nodes = node_sums(grid), points = particle_sums(particles, GetParam());
  EXPECT_NEAR(nodes.mass, points.mass, round_off * points.mass);
  // the internal forces (first node sums up to their size) add nothing: neither force nor, tau being symmetric, moment
  EXPECT_LE((nodes.momentum - points.momentum).norm(), round_off * nodes.scale);
  EXPECT_LE((nodes.angular - points.angular).norm(), round_off * nodes.angular_scale);
}

TEST(Transfer, InternalForcesAndTheirMomentsSumToZero) {
  auto particles = cloud(14);
  for (Particle& p : particles) std::fill_n(p.velocity, 3, 0.0), std::fill_n(p.affine, 9, 0.0);
  Grid grid(dx);
  fill(grid, particles);
  particle_to_grid(grid, {1.0, density, true});
  const Sums force = node_sums(grid);
  EXPECT_GT(force.scale, 0.0);
  EXPECT_LE(force.momentum.norm(), round_off * force.scale);
  EXPECT_LE(force.angular.norm(), round_off * force.angular_scale);
}

TEST(Transfer, GridToParticleKeepsLinearAndAngularMomentumOfApic) {
  const auto particles = cloud(15);
  Grid grid(dx);
  fill(grid, particles);
  particle_to_grid(grid, {1e-3, density, true});
  normalise(grid);
  const Sums nodes = node_sums(grid, true);
  for (const auto b : grid.occupied_blocks()) grid_to_particle(grid, b, {1e-3, density, true});
  const Sums points = particle_sums(testing::stored_particles(grid), true);  // about the origin, at the new positions: x_p moves along v_p
  EXPECT_LE((nodes.momentum - points.momentum).norm(), round_off * nodes.scale);
  EXPECT_LE((nodes.angular - points.angular).norm(), round_off * (nodes.angular_scale + points.angular_scale));
}

/// Velocity a + B x on particles with C = B gives the same field on the nodes, and the nodes give it back: the patch test. Two fields: a
/// general one and a rigid rotation.
TEST(Transfer, AffineVelocityFieldsPassBothTransfersUnchanged) {
  Mat3 general, rotation;
  general << 1.0, -2.0, 0.5, 3.0, 0.25, -1.0, 0.0, 2.0, -1.5;
  rotation << 0.0, -3.0, 2.0, 3.0, 0.0, -1.0, -2.0, 1.0, 0.0;
  const Vec3 a(4.0, -1.0, 2.0);
  for (const Mat3& b : {general, rotation}) {
    auto particles = cloud(16, false);
    for (Particle& p : particles) {
      const Vec3 v = a + b * position_of(p);
      std::copy_n(v.data(), 3, p.velocity);
      testing::set_affine(p, b);
    }
    Grid grid(dx);
    fill(grid, particles);
    particle_to_grid(grid, {1e-3, density, true});
    normalise(grid);
    const double size = a.norm() + b.norm() * 20.0;  // velocities at up to 20 m
    for_each_node(grid, [&](Node& n, const std::array<int, 3>& i) {
      const Vec3 x = dx * Vec3(i[0], i[1], i[2]), v = a + b * x;
      // p_i / m_i: both sums carry the same weights, however small they are
      if (n[3] > 0.0) {
        EXPECT_LE((Vec3(n[0], n[1], n[2]) - v).norm(), 1e-12 * size);
      }
      n = Node{v.x(), v.y(), v.z(), n[3]};  // exact, also where no particle was: as a wall would
    });
    for (const auto block : grid.occupied_blocks()) grid_to_particle(grid, block, {0.0, density, true});
    for (const Particle& p : testing::stored_particles(grid)) {
      EXPECT_LE((velocity_of(p) - a - b * position_of(p)).norm(), round_off * size);
      EXPECT_LE((affine_of(p) - b).norm(), round_off * size * 4.0 / dx * 3.0);
    }
  }
}

TEST(Transfer, ParticlesEndInTheBlockAndCellOfTheirNewPosition) {
  auto particles = cloud(17);
  Grid grid(dx);
  fill(grid, particles);
  const Vec3 v(3.9 * dx, -3.9 * dx, 2.0 * dx);  // in dt = 1 s: at most one block on
  for_each_node(grid, [&](Node& n, const auto&) { n = Node{v.x(), v.y(), v.z(), 1.0}; });
  for (const auto b : grid.occupied_blocks()) {
    EXPECT_TRUE(grid_to_particle(grid, b, {1.0, density, true}).within_reach);
    EXPECT_TRUE(collect_migrants(grid, b));
  }
  grid.migrate();
  std::size_t count = 0;
  for (const auto b : grid.occupied_blocks()) {
    const Block& block = grid.block(b);
    for (int s = 0; s < block.particles.count(); ++s, ++count) {
      const Particle& p = block.particles[s];
      const int cell = block.particles.cell[static_cast<std::size_t>(s)];
      for (int axis = 0; axis < 3; ++axis) {
        const double f = p.position[axis] / dx - node_index(block.coordinate, cell)[static_cast<std::size_t>(axis)];
        EXPECT_GE(f, 0.5 - 1e-13);  // ties may fall to either side, by a round-off of 30 cells
        EXPECT_LE(f, 1.5 + 1e-13);
      }
    }
  }
  EXPECT_EQ(count, particles.size());
}

TEST(Transfer, SaysWhenAParticleCrossesMoreThanABlock) {
  for (const double cells : {-1e6, -9.0, -7.0, 7.0, 9.0, 1e6, 1e300}) {
    Grid grid(dx);
    grid.insert(particle_at({0.5, 0.5, 0.5}));  // second cell of its block: six more, or five less, end in the next
    grid.refresh();
    for_each_node(grid, [&](Node& n, const auto&) { n = Node{0.0, cells * dx, 0.0, 1.0}; });
    const auto b = grid.occupied_blocks()[0];
    BlockMotion motion = grid_to_particle(grid, b, {1.0, density, true});
    if (motion.finite && motion.within_reach) motion.within_reach = collect_migrants(grid, b);
    EXPECT_FALSE(motion.finite && motion.within_reach) << cells;
  }
}

TEST(Transfer, HandsAVelocityThatIsNotFiniteOnToTheStress) {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    for (int count = 1; count <= 3; ++count) {  // first, second or lonely half of a pair
      for (int axis = 0; axis < 3; ++axis) {
        Grid grid(dx);
        for (int i = 0; i < count; ++i) grid.insert(particle_at({0.5, 0.5, 0.5 + 0.01 * i}));
        grid.refresh();
        for_each_node(grid, [&](Node& n, const auto&) {
          n = Node{1.0, 1.0, 1.0, 1.0};
          n[axis] = bad;
        });
        const auto b = grid.occupied_blocks()[0];
        grid_to_particle(grid, b, {1e-3, density, true});
        EXPECT_FALSE(update_stress(grid, b, make_material(testing::elastic_snow()), 1e-3));
      }
    }
  }
}

// --- two fields, and what particles keep ----------------------------------------------------------------------------------

Node& force_impulse_at(Grid& grid, const std::array<int, 3>& n) {
  const auto b = grid.find(block_of_node(n));
  EXPECT_NE(b, no_block);
  return grid.force_impulses(b).node[number_of_node(n)];
}
Node& before_forces_at(Grid& grid, const std::array<int, 3>& n) {
  const auto b = grid.find(block_of_node(n));
  EXPECT_NE(b, no_block);
  return grid.velocities_before_forces(b).node[number_of_node(n)];
}

TEST_P(TransferMode, TwoFieldsAreTheMomentumWithoutForcesAndWhatTheForcesAdd) {
  const auto particles = cloud(18);
  const TransferOptions options{2e-3, density, GetParam(), 0.5};
  Grid grid(dx);
  grid.keep_forces_apart(true);
  fill(grid, particles);
  for (int repeated = 0; repeated < 2; ++repeated) particle_to_grid(grid, options);  // overwrites both
  auto unloaded = particles, at_rest = particles;
  for (Particle& p : unloaded) std::fill_n(p.stress, 6, 0.0);
  for (Particle& p : at_rest) std::fill_n(p.velocity, 3, 0.0), std::fill_n(p.affine, 9, 0.0);
  const MockGrid momentum = mock_particle_to_grid(unloaded, options.dt, options.affine),
                 forces = mock_particle_to_grid(at_rest, options.dt, options.affine);
  double largest_force = 0.0;
  for_each_node(grid, [&](Node& n, const std::array<int, 3>& i) {
    const auto it = momentum.find(i);
    const MockNode p = it == momentum.end() ? MockNode{} : it->second, f = it == momentum.end() ? MockNode{} : forces.at(i);
    const Node& of_forces = force_impulse_at(grid, i);
    EXPECT_NEAR(n[3], p.mass, round_off * p.mass_scale);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(n[c], p.momentum[c], round_off * p.momentum_scale);
      EXPECT_NEAR(of_forces[c], f.momentum[c], round_off * f.momentum_scale);
      largest_force = std::max(largest_force, std::abs(of_forces[c]));
    }
  });
  EXPECT_GT(largest_force, 0.1);  // N s: 10 kPa on a litre's gradient over 2 ms
}

/// The particles with the viscous pressure of transfer.hpp in their stress.
std::vector<Particle> with_shock_pressure(std::vector<Particle> particles, const TransferOptions& options, int& free, int& bounded) {
  for (Particle& p : particles) {
    const double compression = std::max(-affine_of(p).trace(), 0.0), bound = 0.25 / options.dt;
    free += compression > 0.0 && options.shock_viscosity * compression < bound;
    bounded += options.shock_viscosity * compression > bound;
    for (int i = 0; i < 3; ++i) p.stress[i] -= density * dx * dx * compression * std::min(options.shock_viscosity * compression, bound);
  }
  return particles;
}

TEST_P(TransferMode, ParticleToGridAddsTheViscousPressureOfShocksToBothFieldsInCompressionAlone) {
  const auto particles = cloud(23);
  TransferOptions options{2e-3, density, GetParam(), 0.5};
  double largest = 0.0;
  for (const Particle& p : particles) largest = std::max(largest, -affine_of(p).trace());
  options.shock_viscosity = 2.0 * 0.25 / options.dt / largest;  // half of the range of compression is beyond the bound
  int free = 0, bounded = 0;
  const auto viscous = with_shock_pressure(particles, options, free, bounded);
  EXPECT_GT(free, 10);
  EXPECT_GT(bounded, 10);
  Grid one(dx), two(dx);
  two.keep_forces_apart(true);
  fill(one, particles);
  fill(two, particles);
  particle_to_grid(one, options);
  particle_to_grid(two, options);
  const MockGrid expected = mock_particle_to_grid(viscous, options.dt, options.affine);
  for_each_node(one, [&](Node& n, const std::array<int, 3>& i) {
    const auto it = expected.find(i);
    const Node sum = node_at(two, i) + Node{1.0, 1.0, 1.0, 0.0} * force_impulse_at(two, i);
    for (int c = 0; c < 3; ++c) {
      const double value = it == expected.end() ? 0.0 : it->second.momentum[c],
                   scale = it == expected.end() ? 0.0 : it->second.momentum_scale;
      EXPECT_NEAR(n[c], value, round_off * scale);
      EXPECT_NEAR(sum[c], value, round_off * scale);
    }
  });
}

TEST_P(TransferMode, TwoFieldsTogetherAreTheOne) {
  const auto particles = cloud(19);
  const TransferOptions options{2e-3, density, GetParam(), 0.5};
  Grid one(dx), two(dx);
  two.keep_forces_apart(true);
  fill(one, particles);
  fill(two, particles);
  particle_to_grid(one, options);
  particle_to_grid(two, options);
  const MockGrid scale = mock_particle_to_grid(particles, options.dt, options.affine);
  for_each_node(one, [&](Node& n, const std::array<int, 3>& i) {
    const Node sum = node_at(two, i) + Node{1.0, 1.0, 1.0, 0.0} * force_impulse_at(two, i);
    EXPECT_EQ(n[3], node_at(two, i)[3]);  // the same sum
    const auto it = scale.find(i);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(n[c], sum[c], it == scale.end() ? 0.0 : round_off * it->second.momentum_scale);
  });
}

/// Random velocities on nodes and old nodes, up to 10 m/s an axis.
void randomise_nodes(Grid& grid, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-10.0, 10.0);
  for_each_node(grid, [&](Node& n, const std::array<int, 3>& i) {
    n = Node{unit(random), unit(random), unit(random), 1.0};
    before_forces_at(grid, i) = Node{unit(random), unit(random), unit(random), 1.0};
  });
}

/// {sum w v, (4/dx^2) sum w v (x_i - x_p)^T} of a field at x.
template <class NodeOf>
std::pair<Vec3, Mat3> gathered(const Vec3& x, NodeOf&& node_of) {
  Vec3 v = Vec3::Zero();
  Mat3 c = Mat3::Zero();
  for_27_nodes(x, [&](const std::array<int, 3>& n, double w, const Vec3& r) {
    const Node& node = node_of(n);
    const Vec3 vi(node[0], node[1], node[2]);
    v += w * vi;
    c += w * vi * r.transpose() * (4.0 / (dx * dx));
  });
  return {v, c};
}

TEST(KeepingTransfer, ParticlesKeepTheirShareOfWhatTheGridCannotCarryButMoveWithTheGrid) {
  for (const double retained : {0.25, 1.0}) {
    const auto particles = cloud(20);
    Grid grid(dx);
    grid.keep_forces_apart(true);
    fill(grid, particles);
    randomise_nodes(grid, 6);
    const TransferOptions options{1e-3, density, true, retained};
    std::vector<Particle> expected = particles;
    for (Particle& p : expected) {
      const auto [v, c] = gathered(position_of(p), [&](const auto& n) -> Node& { return node_at(grid, n); });
      const Vec3 v0 = gathered(position_of(p), [&](const auto& n) -> Node& { return before_forces_at(grid, n); }).first;
      for (int i = 0; i < 3; ++i) {
        p.position[i] += options.dt * v[i];
        p.velocity[i] = v[i] + retained * (p.velocity[i] - v0[i]);
      }
      testing::set_affine(p, c);
    }
    double fastest = 0.0;
    for (const Particle& p : expected) fastest = std::max(fastest, velocity_of(p).squaredNorm());
    double reported = 0.0;
    std::size_t compared = 0;
    for (const auto b : grid.occupied_blocks()) {
      reported = std::max(reported, grid_to_particle(grid, b, options).max_speed_squared);
      const ParticleBin& bin = grid.block(b).particles;
      for (int s = 0; s < bin.count(); ++s, ++compared) {
        const Particle &p = bin[s], &e = expected[p.id];
        // as in GridToParticleIsTheSumOfTheDocstring; the velocity is gathered from two fields
        EXPECT_LE((velocity_of(p) - velocity_of(e)).norm(), 2.0 * round_off * 30.0);
        EXPECT_LE((position_of(p) - position_of(e)).norm(), round_off * 30.0 * 1e-3 + 1e-14);
        EXPECT_LE((affine_of(p) - affine_of(e)).norm(), round_off * 30.0 * 4.0 / dx * 3.0)
            << "the law takes the grid's gradient for the rate of strain";
        for (int n = 0; n < 6; ++n) EXPECT_EQ(p.stress[n], particles[p.id].stress[n]);  // next to the affine matrix in the record
      }
    }
    EXPECT_EQ(compared, particles.size());
    EXPECT_NEAR(reported, fastest, 1e-12 * fastest);
  }
}

/// All of it is on the grid: what stops there stops.
TEST(KeepingTransfer, NothingIsKeptOfAnAffineField) {
  Mat3 b;
  b << 1.0, -2.0, 0.5, 3.0, 0.25, -1.0, 0.0, 2.0, -1.5;
  const Vec3 a(4.0, -1.0, 2.0);
  auto particles = cloud(22, false);
  for (Particle& p : particles) {
    const Vec3 v = a + b * position_of(p);
    std::copy_n(v.data(), 3, p.velocity);
    testing::set_affine(p, b);
  }
  Grid grid(dx);
  grid.keep_forces_apart(true);
  fill(grid, particles);
  for_each_node(grid, [&](Node& n, const std::array<int, 3>& i) {
    const Vec3 v = a + b * dx * Vec3(i[0], i[1], i[2]);
    before_forces_at(grid, i) = Node{v.x(), v.y(), v.z(), 1.0};
    n = Node{};  // all stop
  });
  const double size = a.norm() + b.norm() * 20.0;  // velocities at up to 20 m
  for (const auto block : grid.occupied_blocks()) grid_to_particle(grid, block, {0.0, density, true, 1.0});
  for (const Particle& p : testing::stored_particles(grid)) {
    EXPECT_LE(velocity_of(p).norm(), round_off * size);
    EXPECT_LE(affine_of(p).norm(), round_off * size * 4.0 / dx * 3.0);
  }
}

}  // namespace
}  // namespace mpm
