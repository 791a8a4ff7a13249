/// Particles of 96 bytes and the kernels on them, against double precision.

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <map>
#include <random>

#include "libmpm/base/error.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/core/transfer.hpp"
#include "support/solver_states.hpp"

namespace mpm {
namespace {

using testing::affine_of;
using testing::particle_at;
using testing::position_of;
using testing::velocity_of;

constexpr double dx = 0.25;
constexpr double half_unit = 0.5 * position_unit * dx;  // m: of a stored position
constexpr double epsilon = 0x1p-24;                     // round-off of a float, relative

/// The same particles in both precisions.
struct Both {
  Grid wide{dx}, narrow{dx, Precision::single_precision};
  void insert(const Particle& p) {
    wide.insert(p);
    narrow.insert(p);
  }
  void refresh() {
    wide.refresh();
    narrow.refresh();
  }
};

/// Particles at random, at a distance from the origin, all fields filled; velocities about a common one.
Both random_cloud(int count, const Vec3& centre, const Vec3& velocity, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  Both grids;
  for (int i = 0; i < count; ++i) {
    Particle p = particle_at(centre + Vec3(place(random), place(random), place(random)), static_cast<std::uint64_t>(i));
    testing::randomise(p, random);
    for (int k = 0; k < 3; ++k) p.velocity[k] += velocity[k];
    grids.insert(p);
  }
  grids.refresh();
  return grids;
}

TEST(SingleRecord, GivesBackWhatItHolds) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const std::int32_t far : {0, -3, 100, -100000, 1000000}) {
    const RecordFrame frame{{far, -far, far / 7}, dx, Vec3(20.0, -3.0, 0.25)};
    for (int n = 0; n < 200; ++n) {
      const int cell = static_cast<int>(random() % 64);
      Vec3 x;
      for (int i = 0; i < 3; ++i) x[i] = (node_index(frame.block, cell)[static_cast<std::size_t>(i)] + 0.5 + unit(random)) * dx;
      Particle p = particle_at(x, random() & largest_single_id);
      testing::randomise(p, random);
      SingleRecord r;
      encode(p, cell, frame, r);
      const Particle q = decode(r, frame);
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(q.position[i], p.position[i], half_unit * (1.0 + 1e-6) + 4e-16 * std::abs(p.position[i]));
        EXPECT_EQ(r.position[static_cast<std::size_t>(i)] >> position_bits, cell >> (2 * i) & 3);
        EXPECT_NEAR(q.velocity[i], p.velocity[i], epsilon * std::abs(p.velocity[i] - frame.velocity[i]) + 1e-14);
      }
      for (int i = 0; i < 9; ++i) EXPECT_NEAR(q.affine[i], p.affine[i], epsilon * std::abs(p.affine[i]));
      for (int i = 0; i < 6; ++i) EXPECT_NEAR(q.stress[i], p.stress[i], epsilon * std::abs(p.stress[i]));
      EXPECT_EQ(q.id, p.id);
      EXPECT_EQ(q.internal, double{static_cast<float>(p.internal)});
      EXPECT_EQ(q.volume, double{static_cast<float>(p.volume)});
      SingleRecord again;  // a particle that changes block goes through the value: its position is not rounded again
      encode(q, cell, frame, again);
      EXPECT_EQ(again.position, r.position);
    }
  }
}

TEST(SingleRecord, StaysInItsCellWhereRoundingWouldLeaveIt) {
  const RecordFrame frame{{0, 0, 0}, dx, Vec3::Zero()};
  const double edge = (first_node(0) + 1.5) * dx;  // between cells 0 and 1
  SingleRecord r;
  encode(particle_at(Vec3::Constant(edge * (1.0 - 1e-12))), 0, frame, r);
  EXPECT_EQ(r.position[0], (1 << position_bits) - 1);
  encode(particle_at(Vec3::Constant(edge)), 1 + 4 + 16, frame, r);
  EXPECT_EQ(r.position[0], 1 << position_bits);
}

TEST(SingleRecord, RefusesIdentityNumbersThatDoNotFit) {
  Grid grid(dx, Precision::single_precision);
  grid.insert(particle_at(Vec3::Zero(), largest_single_id));
  EXPECT_THROW(grid.insert(particle_at(Vec3::Zero(), largest_single_id + 1)), ConfigError);
}

TEST(SinglePrecision, ParticlesThatMigrateKeepTheirPositionToTheBit) {
  Both grids = random_cloud(3000, Vec3(100.0, -50.0, 7.0), Vec3(3.0, -2.0, 1.0), 2);
  std::map<std::uint64_t, Vec3> before;
  grids.narrow.for_each_particle([&](const Particle& p) { before[p.id] = position_of(p); });
  // one cell along each axis, in whole units: what leaves a block is in the next with the same offset
  for (const auto b : grids.narrow.occupied_blocks()) {
    ParticleBin& bin = grids.narrow.block(b).particles;
    for (int s = 0; s < bin.count(); ++s) {
      SingleRecord& r = bin.record<SingleRecord>(s);
      int cell = 0;
      bool stays = true;
      for (std::size_t i = 0; i < 3; ++i) {
        r.position[i] += 1 << position_bits;
        const int local = r.position[i] >> position_bits;
        stays = stays && local < 4;
        cell |= (local & 3) << (2 * i);
      }
      bin.cell[static_cast<std::size_t>(s)] = stays ? static_cast<std::uint8_t>(cell) : ParticleBin::left_block;
    }
    ASSERT_TRUE(collect_migrants(grids.narrow, b));
  }
  grids.narrow.migrate();
  ASSERT_EQ(grids.narrow.particle_count(), before.size());
  grids.narrow.for_each_particle([&](const Particle& p) {
    const Vec3 moved = (position_of(p) - before[p.id]) / dx;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(moved[i], 1.0, 1e-12);  // half a unit would be 4e-9
  });
}

/// Largest difference of the nodes' numbers, momenta and mass apart, over the largest number.
struct NodeDifference {
  double momentum = 0.0, mass = 0.0;
};
NodeDifference compare_nodes(const Grid& wide, const Grid& narrow) {
  double momentum = 0.0, mass = 0.0, largest_momentum = 0.0, largest_mass = 0.0;
  EXPECT_EQ(wide.own_blocks().size(), narrow.own_blocks().size());
  for (const auto b : wide.own_blocks()) {
    const std::int32_t other = narrow.find(wide.block(b).coordinate);
    for (int n = 0; n < block_nodes; ++n) {
      const Node a = wide.momenta(b).node[n], c = narrow.momenta(other).node[n];
      for (int i = 0; i < 3; ++i) {
        momentum = std::max(momentum, std::abs(a[i] - c[i]));
        largest_momentum = std::max(largest_momentum, std::abs(a[i]));
      }
      mass = std::max(mass, std::abs(a[3] - c[3]));
      largest_mass = std::max(largest_mass, std::abs(a[3]));
    }
  }
  return {momentum / largest_momentum, mass / largest_mass};
}

// A node sums a hundred products of six factors each: some ten round-offs, of which most cancel.
constexpr double kernel_bound = 1e-6;

TEST(SinglePrecision, ParticleToGridGivesTheNodesOfDoublePrecision) {
  for (const bool affine : {true, false}) {
    for (const bool old : {false, true}) {
      Both grids = random_cloud(4000, Vec3(-30.0, 12.0, 5.0), Vec3::Zero(), 3);
      const TransferOptions options{.dt = 1e-4, .density = 300.0, .affine = affine, .retained = old ? 0.9 : 0.0};
      grids.wide.keep_forces_apart(old);
      grids.narrow.keep_forces_apart(old);
      particle_to_grid(grids.wide, options);
      particle_to_grid(grids.narrow, options);
      const NodeDifference d = compare_nodes(grids.wide, grids.narrow);
      EXPECT_LE(d.momentum, 2.0 * kernel_bound);  // fifteen other clouds: 0.4e-6 to 1.5e-6, whatever the blocks
      EXPECT_LE(d.mass, kernel_bound);
      EXPECT_GT(d.momentum, 1e-12);  // they are two precisions
    }
  }
}

TEST(SinglePrecision, GridToParticleGivesTheParticlesOfDoublePrecision) {
  for (const double retained : {0.0, 0.9}) {
    Both grids = random_cloud(4000, Vec3(-30.0, 12.0, 5.0), Vec3(15.0, 0.0, 0.0), 4);
    const TransferOptions options{.dt = 2e-3, .density = 300.0, .affine = true, .retained = retained};
    for (Grid* grid : {&grids.wide, &grids.narrow}) {
      grid->keep_forces_apart(retained > 0.0);
      particle_to_grid(*grid, options);
      for (const auto b : grid->own_blocks()) {  // v = p/m; forces changed it by 1 %
        for (int n = 0; n < block_nodes; ++n) {
          Node& node = grid->velocities(b).node[n];
          const double mass = node[3];
          if (mass > 0.0) node /= Node{mass, mass, mass, 1.0};
          if (retained > 0.0) grid->velocities_before_forces(b).node[n] = Node{0.99, 0.99, 0.99, 1.0} * node;
        }
      }
      const std::vector<std::int32_t> blocks(grid->occupied_blocks().begin(), grid->occupied_blocks().end());
      double speed = 0.0;
      for (const auto b : blocks) {
        const BlockMotion motion = grid_to_particle(*grid, b, options);
        EXPECT_TRUE(motion.within_reach);
        collect_migrants(*grid, b);
        speed = std::max(speed, motion.max_speed_squared);
      }
      EXPECT_GT(speed, 15.0 * 15.0);
      grid->migrate();
    }
    const auto a = testing::particles_by_id(grids.wide), b = testing::particles_by_id(grids.narrow);
    ASSERT_EQ(a.size(), b.size());
    double gradient = 0.0;
    for (const Particle& p : a) gradient = std::max(gradient, affine_of(p).cwiseAbs().maxCoeff());
    for (std::size_t i = 0; i < a.size(); ++i) {
      constexpr double velocity_range = 10.0;  // within a block
      EXPECT_LE((velocity_of(a[i]) - velocity_of(b[i])).cwiseAbs().maxCoeff(), 3.0 * kernel_bound * velocity_range);
      EXPECT_LE((affine_of(a[i]) - affine_of(b[i])).cwiseAbs().maxCoeff(), 10.0 * kernel_bound * gradient);  // 4/dx times a difference
      EXPECT_LE((position_of(a[i]) - position_of(b[i])).cwiseAbs().maxCoeff(), 4.0 * half_unit + options.dt * 3e-5);
    }
  }
}

/// Every regime of the law that a double test covers: random trial states around the surface.
TEST(SinglePrecision, LawsGiveTheStressOfDoublePrecision) {
  std::vector<MaterialParameters> laws = testing::every_law();
  for (const double xi : {0.5, 5.0, 50.0})
    for (const double beta : {0.0, 0.3}) laws.push_back(testing::cam_clay_snow(0.8, beta, xi));
  laws.push_back(testing::cam_clay_snow(0.0, 0.0));
  constexpr double dt = 1e-3;
  for (const MaterialParameters& parameters : laws) {
    const AnyMaterial wide_law = make_material(parameters), narrow_law = make_material(parameters, Precision::single_precision);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (const double rate : {1e-3, 0.1, 1.0, 20.0}) {
      Both grids;
      for (int i = 0; i < 1000; ++i) {
        Particle p = particle_at({0.5, 0.5, 0.5}, static_cast<std::uint64_t>(i));
        for (double& c : p.affine) c = static_cast<float>(rate * unit(random));
        for (double& s : p.stress) s = static_cast<float>(3e3 * unit(random));
        for (int k = 0; k < 3; ++k) p.stress[k] = static_cast<float>(p.stress[k] - 4e3);
        p.internal = double{static_cast<float>(initial_internal_of(wide_law))};
        grids.insert(p);
      }
      grids.refresh();
      ASSERT_TRUE(update_stress(grids.wide, grids.wide.occupied_blocks()[0], wide_law, dt));
      ASSERT_TRUE(update_stress(grids.narrow, grids.narrow.occupied_blocks()[0], narrow_law, dt));
      const auto a = testing::particles_by_id(grids.wide), b = testing::particles_by_id(grids.narrow);
      // Trial stresses are up to 1e4 Pa plus K |dl|; the map itself does not enlarge their round-off, of some operations, by more than
      // that.
      const double size = 1e4 + 4e5 * rate * dt, bound = 3e-6 * size;
      double largest = 0.0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        for (int n = 0; n < 6; ++n) largest = std::max(largest, std::abs(a[i].stress[n] - b[i].stress[n]));
        EXPECT_NEAR(a[i].internal, b[i].internal, 3e-6 * (std::abs(a[i].internal) + size / 4e5)) << parameters.name();
      }
      EXPECT_LE(largest, bound) << parameters.name() << ", rate " << rate;
    }
  }
}

TEST(SinglePrecision, StepsOfAnAvalancheStayCloseToDoublePrecision) {
  Case c = testing::small_avalanche();
  std::vector<State> ends;
  for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
    c.numerics.precision = precision;
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    EXPECT_EQ(state.grid.precision(), precision);
    Totals now = totals(state, scene);
    for (int n = 0; n < 100; ++n) {
      const Totals before = now;
      const StepReport report = step(state, scene, 2e-4);
      now = totals(state, scene);
      Vec3 due = report.entered.momentum - report.left.momentum + report.gravity_impulse;
      for (const Impulse& taken : report.impulses) due -= taken.linear;
      const double share = precision == Precision::double_precision ? 1e-13 : 1e-7;  // round-off of a float, averaged over the particles
      EXPECT_LE((whole_of_mirrored(now, scene.mirror).momentum - whole_of_mirrored(before, scene.mirror).momentum -
                 whole_force(due, scene.mirror))
                    .norm(),
                share * now.momentum_scale * scene.mirror.parts());
    }
    ends.push_back(std::move(state));
  }
  const auto a = testing::particles_by_id(ends[0].grid), b = testing::particles_by_id(ends[1].grid);
  ASSERT_EQ(a.size(), b.size());
  double x2 = 0.0, v2 = 0.0, s2 = 0.0, size2 = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].id, b[i].id);
    x2 += (position_of(a[i]) - position_of(b[i])).squaredNorm();
    v2 += (velocity_of(a[i]) - velocity_of(b[i])).squaredNorm();
    for (int n = 0; n < 6; ++n) {
      s2 += std::pow(a[i].stress[n] - b[i].stress[n], 2);
      size2 += std::pow(a[i].stress[n], 2);
    }
  }
  const double n = static_cast<double>(a.size());
  EXPECT_LE(std::sqrt(x2 / n) / c.numerics.cell_size, 1e-5);
  EXPECT_LE(std::sqrt(v2 / n), 1e-4);
  EXPECT_LE(std::sqrt(s2 / size2), 1e-4);
}

/// Gravity's increment of a velocity never meets the round-off of that velocity: it goes to that of the block.
TEST(SinglePrecision, ABodyInFreeFallKeepsItsAcceleration) {
  Case c = testing::empty_case();
  c.domain.min = Vec3::Constant(-1e3);
  c.domain.max = Vec3::Constant(1e3);
  c.numerics.precision = Precision::single_precision;
  for (const Transfer transfer : {Transfer::apic, Transfer::flip, Transfer::aflip}) {
    c.numerics.transfer = transfer;
    c.bodies = {testing::box_body(Vec3::Zero(), Vec3::Constant(0.75), Vec3(17.0, -3.0, 5.0))};
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    const auto start = testing::particles_by_id(state.grid);
    constexpr double dt = 1e-3;
    constexpr int steps = 3000;
    for (int n = 0; n < steps; ++n) step(state, scene, dt);
    const double t = steps * dt;
    const Vec3 velocity = Vec3(17.0, -3.0, 5.0 - 9.81 * t);
    const Vec3 way = Vec3(17.0, -3.0, 5.0 - 0.5 * 9.81 * (t + dt)) * t;  // symplectic Euler: v_n+1 dt
    const auto end = testing::particles_by_id(state.grid);
    for (std::size_t i = 0; i < end.size(); ++i) {
      EXPECT_LE((velocity_of(end[i]) - velocity).norm(), 1e-9);
      // each step rounds the block's displacement by at most half a unit along each axis
      EXPECT_LE((position_of(end[i]) - position_of(start[i]) - way).cwiseAbs().maxCoeff(), steps * half_unit * 1.01);
    }
  }
}

/// A drop alone keeps its velocity gradient: its volume would be e^340 times the first at the end, beyond the largest float after 88/340 of
/// the time.
TEST(SinglePrecision, ADropOfSprayMayFlyForAnyTime) {
  Case c = testing::empty_case();
  c.material = WeaklyCompressibleFluid::Parameters{};
  c.numerics.gravity = 0.0;
  c.numerics.precision = Precision::single_precision;
  const CaseScene scene = make_scene(c);
  State state(c.numerics.cell_size, c.numerics.precision);
  Particle drop = particle_at(Vec3(0.3, 0.2, 0.1));
  testing::set_affine(drop, 100.0 * Mat3::Identity());
  state.grid.insert(drop);
  state.grid.refresh();
  for (int n = 0; n < 1133; ++n) ASSERT_NO_THROW(step(state, scene, 1e-3)) << n;
  const auto end = testing::particles_by_id(state.grid);
  ASSERT_EQ(end.size(), 1U);
  EXPECT_NEAR(affine_of(end[0]).trace(), 300.0, 0.1);
}

TEST(SinglePrecision, ADisplacementBeyondABlockIsUnstable) {
  Case c = testing::empty_case();
  c.numerics.precision = Precision::single_precision;
  c.bodies = {testing::box_body(Vec3::Zero(), Vec3::Constant(0.5), Vec3(1.0, 0.0, 0.0))};
  const CaseScene scene = make_scene(c);
  for (const double speed : {5e3, 1e9, 1e30, 1e200, -1e7}) {
    State state = make_state(c, scene);
    testing::change_particle(state.grid, 3, [&](Particle& p) { p.velocity[1] = speed; });
    EXPECT_THROW(
        {
          for (int n = 0; n < 3; ++n) step(state, scene, 1e-2);
        },
        UnstableError)
        << speed;
  }
}

}  // namespace
}  // namespace mpm
