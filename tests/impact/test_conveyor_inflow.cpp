/// Inflow that varies over height or in time: what the conveyor's feed releases, and that nothing is lost on the way.

#include <gtest/gtest.h>

#include <map>

#include "libmpm/base/error.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/impact/conveyor.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

constexpr double dx = 0.25, spacing = 0.125;

Case sheared(double slip = 0.4, double exponent = 1.0) {
  Case c = testing::small_avalanche();
  c.conveyor->sidewall_contact = Contact::slip;
  c.conveyor->slip_ratio = slip;
  c.conveyor->shear_exponent = exponent;
  return c;
}

/// Speed, height and density that rise and fall within half a second.
Case changing() {
  Case c = testing::small_avalanche();
  c.conveyor->inflow = {{0.0, 4.0, 1.0, 1.0}, {0.2, 6.0, 1.5, 1.02}, {0.4, 3.0, 0.75, 1.0}};
  return c;
}

Case at_random(Case c) {
  c.conveyor->lattice = Lattice::random;
  return c;
}

/// 'name' for messages, and the case.
std::vector<std::pair<const char*, Case>> varying() {
  return {{"sheared", sheared()},
          {"steep", sheared(0.0, 2.0)},
          {"changing", changing()},
          {"sheared, random", at_random(sheared())},
          {"changing, random", at_random(changing())}};
}

TEST(VaryingInflow, BooksMassAndMomentumExactlyInEveryStep) {
  for (const auto& [name, c] : varying()) {
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    Totals before = totals(state, scene);
    std::uint64_t entered = 0;
    for (int n = 0; n < 300; ++n) {
      const StepReport r = step(state, scene, stable_time_step(state, scene));
      const Totals after = totals(state, scene);
      Vec3 change = r.entered.momentum + r.gravity_impulse - r.left.momentum;
      for (const Impulse& impulse : r.impulses) change -= impulse.linear;
      for (const int axis : {0, 2}) {  // across the mirror plane the other half pushes
        // as in the test of the momentum's balance
        ASSERT_NEAR(after.momentum[axis] - before.momentum[axis], change[axis], 1e-13 * (after.momentum_scale + after.mass)) << name << n;
      }
      ASSERT_NEAR(after.mass, before.mass + r.entered.mass - r.left.mass, 1e-12 * after.mass) << name << n;
      entered += r.entered.count;
      before = after;
    }
    EXPECT_GT(entered, 1000U) << name;
  }
}

TEST(VaryingInflow, GivesTheSameBitsOnAnyNumberOfThreadsAndAfterACheckpoint) {
  const testing::TemporaryDirectory folder;
  for (const auto& [name, c] : varying()) {
    const CaseScene scene = make_scene(c);
    const auto run = [&, &c = c](int threads, bool interrupted) {
      omp_set_num_threads(threads);
      State state = make_state(c, scene);
      advance(state, scene, 0.15);
      if (interrupted) {
        write_checkpoint(folder.path() / "checkpoint.h5", c, state, {}, {});
        State again(c.numerics.cell_size);
        RunProgress progress;
        Arrays observed;
        read_checkpoint(folder.path() / "checkpoint.h5", c, again, progress, observed);
        advance(again, scene, 0.3);
        return testing::stored_particles(again.grid);
      }
      advance(state, scene, 0.3);
      return testing::stored_particles(state.grid);
    };
    const auto plain = run(1, false);
    EXPECT_TRUE(testing::same_bytes(plain, run(3, false))) << name;
    omp_set_num_threads(1);
    EXPECT_TRUE(testing::same_bytes(plain, run(1, true))) << name;
  }
}

TEST(VaryingInflow, LeavesASteadyPlugAsItIs) {
  Case table = testing::small_avalanche();
  table.conveyor->inflow = {{0.1, 4.0, 1.0, 1.0}, {0.3, 4.0, 1.0, 1.0}};  // nothing changes
  const Case plain = testing::small_avalanche();
  std::vector<std::vector<Particle>> last;
  for (const Case& c : {plain, table}) {
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    advance(state, scene, 0.3);
    last.push_back(testing::particles_by_id(state.grid));
  }
  ASSERT_EQ(last[0].size(), last[1].size());
  for (std::size_t i = 0; i < last[0].size(); ++i) {
    // the way is summed in another order: round-off, which the flow at the mast may spread
    ASSERT_LE((testing::position_of(last[0][i]) - testing::position_of(last[1][i])).norm(), 1e-9) << i;
  }
}

TEST(ChangingInflow, BringsTheMassOfItsTable) {
  Case c = changing();
  c.obstacle.reset();
  const CaseScene scene = make_scene(c), random = make_scene(at_random(c));
  State state = make_state(c, scene), of_random = make_state(at_random(c), random);
  const Inflow inflow(*c.conveyor);
  double expected = 0.0, largest = 0.0;  // half of the width
  constexpr int n = 40000;
  constexpr double end = 0.6;
  for (int i = 0; i < n; ++i) {
    const double t = (i + 0.5) * end / n;
    const double per_metre = 300.0 * inflow.density_ratio(t) * inflow.flow_height(t) * 1.5;
    expected += per_metre * inflow.velocity(t) * end / n;
    largest = std::max(largest, per_metre);
  }
  advance(state, scene, end);
  // a layer holds the height and density of its moment: the sum over layers is a rectangle rule over spacings, up to one layer at the end
  EXPECT_NEAR(state.entered.mass, expected, 1.5 * largest * spacing);
  advance(of_random, random, end);
  EXPECT_NEAR(of_random.entered.mass, expected,
              2.0 * largest * spacing);  // a layer of 12 x 8 to 12 x 12 cells has some points more or less
  EXPECT_GT(state.entered.mass, 0.0);
}

TEST(ChangingInflow, EntersWithTheSpeedAndHeightOfTheMoment) {
  Case c = changing();
  c.obstacle.reset();
  c.conveyor->inflow[1].density_ratio = 1.0;
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const Inflow inflow(*c.conveyor);
  for (const double t : {0.1, 0.2, 0.3, 0.45}) {
    advance(state, scene, t);
    double top = 0.0;
    state.grid.for_each_particle([&](const Particle& p) {
      if (p.position[0] > -2.0 - dx) return;                                           // behind the inlet and out of reach of what is free
      EXPECT_NEAR(p.velocity[0], inflow.velocity(t), 0.02 * inflow.velocity(t)) << t;  // of the step before
      top = std::max(top, p.position[2]);
    });
    // within a row of the height, less what the column settles
    EXPECT_NEAR(top, inflow.flow_height(t), spacing) << t;
  }
}

TEST(ChangingInflow, OfOneRowIsASteadyFlowBetweenWallsOfItsSpeed) {
  ConveyorSpec belt = *testing::small_avalanche().conveyor;
  belt.inflow = {{0.0, 2.0 * belt.velocity, belt.flow_height, 1.0}};
  for (const Boundary& boundary : conveyor_walls(belt, ContactRule::surface, false)) {
    const Wall& wall = std::get<Wall>(boundary);
    EXPECT_EQ(wall.surface_velocity(Vec3(0.0, 0.0, 0.1), 0.5).x(), belt.inflow[0].velocity);
  }
}

TEST(ShearedInflow, RowsEnterAtTheirOwnSpeeds) {
  const Case c = [] {
    Case s = sheared(0.4, 1.0);
    s.obstacle.reset();
    s.numerics.transfer = Transfer::apic;  // with AFLIP the lowest row, half a cell above the floor, differs by 25 % from the shear profile
    return s;
  }();
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const Inflow inflow(*c.conveyor);
  const double end = 0.4;
  advance(state, scene, end);
  // The mass that entered is that of the plug of the same mean speed: rows are fed once a spacing, each to a whole layer.
  const double per_layer = 300.0 * 1.0 * 1.5 * spacing;
  EXPECT_NEAR(state.entered.mass, 4.0 * end * 300.0 * 1.0 * 1.5, 2.0 * per_layer);
  double worst = 0.0, mass = 0.0;
  state.grid.for_each_particle([&](const Particle& p) {
    if (p.position[0] < -1.0 && p.position[0] >= -2.0 - 3.0 * spacing) mass += 300.0 * p.volume;
    if (p.position[0] < -2.0) worst = std::max(worst, std::abs(p.velocity[0] / (4.0 * inflow.shear(p.position[2])) - 1.0));
  });
  // no gap at the inlet: from what its nodes touch behind it (3/2 cells) on there are eleven spacings, with a layer at either end in or out
  EXPECT_NEAR(mass, 11.0 * per_layer, per_layer);
  // the node on the floor represents half a cell of height, whose mean speed differs from that at the floor
  EXPECT_LT(worst, 0.15);
}

TEST(ShearedInflow, CarriesTheSameMassAndMoreMomentumThanThePlug) {
  Case plug = testing::small_avalanche();
  plug.conveyor->sidewall_contact = Contact::slip;
  for (const auto& c : {sheared(0.0, 1.0), sheared(0.5, 2.0)}) {
    const CaseScene scene = make_scene(c), plain = make_scene(plug);
    const Totals t = totals(make_state(c, scene), scene), p = totals(make_state(plug, plain), plain);
    const double late = Inflow(*c.conveyor).shear(1.0) * spacing;  // a deeper reservoir, to whole layers
    EXPECT_NEAR(t.mass / p.mass, (2.5 + late) / 2.5, spacing / 2.5);
    EXPECT_NEAR(t.momentum.x() / t.mass, 4.0, 1e-12);
    EXPECT_GT(t.kinetic_energy / t.mass, p.kinetic_energy / p.mass);
  }
}

TEST(DenserSnow, IsCompactedByItsRatioAndCarriesItsWeight) {
  const AnyMaterial material = make_material(testing::cam_clay_snow(0.4, 0.0));
  const double weight = 300.0 * 9.81;
  for (const double ratio : {1.0, 1.05, 1.3}) {
    const auto column = settled_column(material, weight, 1.75, 14, ratio);
    double height = 0.0;
    for (int j = 0; j < 14; ++j) {
      const auto& point = column[static_cast<std::size_t>(j)];
      const double jacobian = volume_ratio(material, point.state);
      EXPECT_NEAR(point.state.stress.zz / jacobian, -ratio * weight * (1.75 - (j + 0.5) * 0.125), 1e-9 * weight * 1.75);
      EXPECT_LE(jacobian, 1.0 / ratio + 1e-12);
      EXPECT_GT(jacobian, 0.98 / ratio) << "little more than its own compaction";
      height += 0.125 * ratio * jacobian;
    }
    EXPECT_NEAR(height, 1.75, 0.02);
  }
}

TEST(VaryingInflow, IsRefusedWhereItMeansNothing) {
  Case strip = changing();
  strip.conveyor->feed = ConveyorSpec::Feed::strip;
  EXPECT_THROW((void)make_scene(strip), ConfigError);
  Case held = sheared();
  held.conveyor->sidewall_contact = Contact::no_slip;
  EXPECT_THROW((void)make_scene(held), ConfigError);
  Case both = sheared();
  both.conveyor->inflow = changing().conveyor->inflow;
  EXPECT_THROW((void)make_scene(both), ConfigError);
}

}  // namespace
}  // namespace mpm
