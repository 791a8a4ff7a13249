#include "libmpm/core/step.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <regex>

#include "libmpm/base/error.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "support/solver_states.hpp"

namespace mpm {
namespace {

using testing::box_body;
using testing::change_particle;
using testing::empty_case;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::particle_at;
using testing::particle_of;
using testing::position_of;
using testing::velocity_of;

/// What f says when it throws UnstableError; a failure if it does not.
template <class F>
std::string unstable_message(F&& f) {
  try {
    f();
  } catch (const UnstableError& error) {
    EXPECT_EQ(error.code(), ExitCode::unstable);
    return error.what();
  }
  ADD_FAILURE() << "no UnstableError";
  return {};
}

/// "... at (x, y, z) m" of a message
std::optional<Vec3> position_in(const std::string& message) {
  std::smatch m;
  if (!std::regex_search(message, m, std::regex(R"(\(([-+.\de]+), ([-+.\de]+), ([-+.\de]+)\) m[;,. ])"))) return std::nullopt;
  return Vec3(std::stod(m[1]), std::stod(m[2]), std::stod(m[3]));
}

TEST(StableTimeStep, IsTheSafetyFactorTimesTheCellOverTheFastestSignal) {
  Case c = empty_case();
  c.bodies = {box_body(Vec3::Zero(), Vec3::Ones(), {3.0, 0.0, -4.0})};
  c.numerics.cfl = 0.3;
  const CaseScene scene = make_scene(c);
  const State state = make_state(c, scene);
  // c_P = sqrt((K + 4G/3) / rho_0) = sqrt(E (1 - nu) / ((1 + nu) (1 - 2 nu)) / rho_0) = 58.39 m/s for the paper's snow
  const double wave = std::sqrt(1e6 * 0.9 / (1.1 * 0.8) / 300.0);
  EXPECT_NEAR(wave, 58.4, 0.05);
  EXPECT_NEAR(stable_time_step(state, scene), 0.3 * 0.25 / (wave + 5.0), 1e-15);
}

/// A particle without neighbours that is compressed by 1e-4: its pressure oscillates.
class OneParticle : public ::testing::TestWithParam<Transfer> {
 protected:
  /// Largest pressure of the last tenth of the steps over that at the start. @param share  of the longest stable step
  double growth(double share, const Vec3& place, int steps = 400) {
    Case c = empty_case();
    c.material = MaterialParameters(HenckyElastic::Parameters{});
    c.numerics.gravity = 0.0;
    c.numerics.transfer = GetParam();
    const CaseScene scene = make_scene(c);
    State state(c.numerics.cell_size);
    Particle p{};
    for (int i = 0; i < 3; ++i) p.position[i] = c.numerics.cell_size * place[i], p.stress[i] = -pressure;
    p.volume = std::pow(0.5 * c.numerics.cell_size, 3.0);
    state.grid.insert(p);
    state.grid.refresh();
    const double longest = c.numerics.cell_size / (std::numbers::sqrt3 * bulk_speed_of(scene.material));
    double last = 0.0;
    for (int n = 0; n < steps; ++n) {
      step(state, scene, share * longest);
      if (n < steps - steps / 10) continue;
      state.grid.for_each_particle(
          [&](const Particle& q) { last = std::max(last, std::abs(q.stress[0] + q.stress[1] + q.stress[2]) / 3.0); });
    }
    return last / pressure;
  }
  static constexpr double pressure = 1.0;  // Pa: a strain at which the motion is linear
};
INSTANTIATE_TEST_SUITE_P(Transfers, OneParticle, ::testing::Values(Transfer::apic, Transfer::aflip),
                         [](const auto& test) { return test.param == Transfer::apic ? "Apic" : "Aflip"; });

TEST_P(OneParticle, OscillatesUpToTheLongestStepAndBurstsBeyond) {
  for (const Vec3& place : {Vec3(0.0, 0.0, 0.0), Vec3(0.5, 0.25, 0.49), Vec3(0.3, 0.7, 0.1)}) {
    EXPECT_LT(growth(0.92, place), 5.0) << "the share of stable_time_step";
    EXPECT_LT(growth(0.99, place), 20.0);
    EXPECT_GT(growth(1.02, place, 60), 1e3);
  }
}

TEST(StableTimeStep, IsThatOfAParticleWithoutNeighboursInSlowStiffFlow) {
  const AnyMaterial snow = make_material(empty_case().material);
  const double longest = 0.25 / (std::numbers::sqrt3 * bulk_speed_of(snow)), c = wave_speed_of(snow);
  EXPECT_NEAR(stable_time_step(snow, 1.0, 0.25, 0.0), 0.92 * longest, 1e-15);
  EXPECT_NEAR(stable_time_step(snow, 1.0, 0.25, 0.5 * c), 0.25 / (1.5 * c), 1e-15);
}

TEST(StableTimeStep, FollowsTheFastestParticle) {
  Case c = empty_case();
  c.numerics.gravity = 0.0;
  c.bodies = {box_body(Vec3::Zero(), Vec3::Constant(0.5)), box_body(Vec3(5.0, 5.0, 5.0), Vec3::Constant(5.5), {0.0, 30.0, 0.0})};
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  step(state, scene, 1e-3);
  EXPECT_NEAR(state.max_speed, 30.0, 1e-12);
}

TEST(StableTimeStep, ThatCollapsedIsUnstable) {
  const Case c = empty_case();
  const CaseScene scene = make_scene(c);
  for (const double speed : {1e9, HUGE_VAL, std::nan("")}) {
    State state(0.25);
    state.max_speed = speed;
    state.time = 1.5;
    EXPECT_THAT(unstable_message([&] { stable_time_step(state, scene); }), HasSubstr("t = 1.5 s"));
    EXPECT_THROW(advance(state, scene, 2.0), UnstableError);
  }
}

TEST(Step, OfNothingDoesNothing) {
  const Case c = empty_case();
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  advance(state, scene, 0.01);
  EXPECT_EQ(state.time, 0.01);
  EXPECT_GT(state.step, 0U);
  EXPECT_EQ(state.grid.particle_count(), 0U);
}

TEST(Step, LetsAFreeBodyFlyOnItsParabola) {
  // Symplectic Euler: after n steps v = v0 - n g dt and z = z0 + v0 t - g t (t + dt) / 2, exactly, for every particle: a body in free fall
  // has no stress.
  for (const Transfer transfer : {Transfer::apic, Transfer::flip}) {
    Case c = empty_case();
    c.numerics.transfer = transfer;
    c.bodies = {box_body({-0.6, 0.2, 1.0}, {0.1, 0.9, 2.0}, {2.0, -3.0, 4.0})};
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    const auto before = testing::particles_by_id(state.grid);
    const double dt = 1e-3, t = 0.2;
    for (int n = 0; n < 200; ++n) step(state, scene, dt);
    const auto after = testing::particles_by_id(state.grid);
    ASSERT_EQ(before.size(), after.size());
    for (std::size_t i = 0; i < after.size(); ++i) {
      const Vec3 fall = position_of(before[i]) + t * Vec3(2.0, -3.0, 4.0) - Vec3(0.0, 0.0, 0.5 * 9.81 * t * (t + dt));
      // round-off of 1e-15 m/s a step over a cell gives a stress of 1e-15/dx dt E = 4e-12 Pa, which grows the differences a little
      EXPECT_LE((position_of(after[i]) - fall).norm(), 1e-12);
      EXPECT_LE((velocity_of(after[i]) - Vec3(2.0, -3.0, 4.0 - 9.81 * t)).norm(), 1e-11);
    }
  }
}

TEST(Step, KeepsAngularMomentumOfAFreeApicBody) {
  Case c = empty_case();
  c.numerics.transfer = Transfer::apic;
  c.numerics.gravity = 0.0;
  c.bodies = {box_body({-0.5, -0.75, -0.25}, {0.5, 0.75, 0.25})};
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  Mat3 spin;  // spins and strains: the stress works
  spin << 0.5, -6.0, 1.0, 6.0, -1.0, 0.0, 2.0, 0.0, 0.5;
  state.grid.change_particles([&](Particle& p) {
    const Vec3 v = spin * position_of(p);
    std::copy_n(v.data(), 3, p.velocity);
    testing::set_affine(p, spin);
  });
  const Totals before = totals(state, scene);
  for (int n = 0; n < 200; ++n) step(state, scene, 1e-3);
  const Totals after = totals(state, scene);
  EXPECT_GT(after.elastic_energy, 1e-3 * before.kinetic_energy);
  const double size = before.mass * 6.0 * 0.9 * 0.9;  // m omega r^2
  EXPECT_LE((after.momentum - before.momentum).norm(), 1e-13 * size);
  EXPECT_LE((after.angular_momentum - before.angular_momentum).norm(), 1e-12 * size);  // 200 steps of round-off
}

TEST(Advance, MeetsEveryTimeToTheBitInStepsThatAreStable) {
  Case c = empty_case();
  c.bodies = {box_body(Vec3::Zero(), Vec3::Constant(0.5), {1.0, 0.0, 0.0})};
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  std::uint64_t calls = 0;
  for (const double time : {1e-9, 1.0 / 50.0, 0.02 + 1e-15, 2.0 / 30.0, 0.07, 0.0700001, 0.1}) {
    advance(state, scene, time, [&](const StepReport& report) {
      ++calls;
      EXPECT_GT(report.dt, 0.0);
      EXPECT_LE(report.dt, scene.numerics.cfl * 0.25 / (58.38 + 1.0));  // stable step at 1 m/s
      EXPECT_EQ(calls, state.step);
    });
    EXPECT_EQ(state.time, time);
  }
  advance(state, scene, 0.05);  // the past: nothing to do
  EXPECT_EQ(state.time, 0.1);
  EXPECT_EQ(calls, state.step);
  // no crumbs: the last two steps of a stretch are evened out
  std::vector<double> sizes;
  advance(state, scene, 0.2, [&](const StepReport& report) { sizes.push_back(report.dt); });
  EXPECT_GT(*std::min_element(sizes.begin(), sizes.end()), 0.49 * *std::max_element(sizes.begin(), sizes.end()));
}

TEST(ParticlesThatLeave, AreCountedWithMassAndMomentumAndOnlyOnce) {
  Case c = empty_case();
  c.numerics.gravity = 0.0;
  c.domain.min = Vec3(-1.0, -1.0, -1.0);
  c.domain.max = Vec3(1.0, 1.0, 1.0);
  c.bodies = {box_body({0.4, -0.5, -0.5}, {0.9, 0.0, 0.0}, {10.0, 0.0, 0.0}), box_body({-0.5, -0.5, 0.4}, {0.0, 0.0, 0.9}, {0.0, 0.0, 7.0}),
              box_body({-0.9, 0.4, -0.9}, {-0.4, 0.9, -0.4}, {-8.0, 0.0, 0.0})};
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const Totals before = totals(state, scene);
  FluxTotals sum;
  advance(state, scene, 0.3, [&](const StepReport& report) { sum += report.left; });
  EXPECT_EQ(state.grid.particle_count(), 0U);
  for (const FluxTotals& left : {sum, state.left}) {
    EXPECT_EQ(left.count, before.particles);
    EXPECT_EQ(left.through_x_max, before.particles / 3);  // those beyond x_max
    EXPECT_NEAR(left.mass, before.mass, 1e-12 * before.mass);
    EXPECT_LE((left.momentum - before.momentum).norm(), 1e-12 * before.mass * 10.0);
  }
}

TEST(ParticlesThatLeave, LeaveInTheStepInWhichTheyCrossHoweverFar) {
  // Block 0 holds x/dx from 1/2 to 4 1/2. A step may lead a block on, from -3 1/2 to 8 1/2: the domain ends just before that.
  Case c = empty_case();
  c.numerics.gravity = 0.0;
  c.domain.min = Vec3::Constant(-3.2 * 0.25);
  c.domain.max = Vec3::Constant(8.2 * 0.25);
  const CaseScene scene = make_scene(c);
  for (int axis = 0; axis < 3; ++axis) {
    for (const auto& [from, to] : {std::pair{4.4, 8.4}, std::pair{0.6, -3.4}}) {
      State state(0.25);
      Particle p = particle_at(Vec3::Constant(from * 0.25));
      p.velocity[axis] = (to - from) * 0.25;
      state.grid.insert(p);
      state.grid.refresh();
      EXPECT_EQ(step(state, scene, 1.0).left.count, 1U) << axis << ' ' << to;
    }
  }
}

/// A block of snow and, far from it, one particle, number `lonely`, whose neighbourhood is its own.
class Unstable : public ::testing::Test {
 protected:
  Unstable() : c(empty_case()), scene(make_scene(c)), state(0.25) {
    c.bodies = {box_body(Vec3::Zero(), Vec3::Ones())};
    state = make_state(c, scene);
    Particle p = particle_at(place, lonely, 1e-3);
    state.grid.insert(p);
    state.grid.refresh();
    state.time = 0.75;
    state.step = 123;
  }
  template <class F>
  void poison(F&& f) {
    change_particle(state.grid, lonely, f);
  }
  static constexpr std::uint64_t lonely = 987654;
  const Vec3 place{3.1, -2.2, 5.3};
  Case c;
  CaseScene scene;
  State state;
};

TEST_F(Unstable, NotANumberNamesParticlePositionAndTime) {
  for (int field = 0; field < 4; ++field) {
    const Particle sane = particle_of(state.grid, lonely);
    poison([&](Particle& p) {
      (field == 0   ? p.velocity[1]
       : field == 1 ? p.affine[4]
       : field == 2 ? p.stress[3]
                    : p.velocity[2]) = field == 3 ? HUGE_VAL : std::nan("");
    });
    const std::string message = unstable_message([&] { step(state, scene, 1e-3); });
    EXPECT_THAT(message, HasSubstr("particle 987654"));
    EXPECT_THAT(message, HasSubstr("t = 0.75 s"));
    EXPECT_THAT(message, HasSubstr("step 123"));
    EXPECT_THAT(message, HasSubstr("not finite"));
    const auto where = position_in(message);
    ASSERT_TRUE(where) << message;
    EXPECT_LE((*where - place).norm(), 1.01 * std::sqrt(3.0)) << message;  // at worst the block of 1 m
    poison([&](Particle& p) { p = sane; });
  }
}

TEST_F(Unstable, NotANumberInsideABodyIsFoundInItsNeighbourhood) {
  change_particle(state.grid, 300, [](Particle& p) { p.velocity[0] = std::nan(""); });
  const Vec3 start = position_of(particle_of(state.grid, 300));
  const std::string message = unstable_message([&] { step(state, scene, 1e-3); });
  const auto where = position_in(message);
  ASSERT_TRUE(where) << message;
  EXPECT_LE((*where - start).norm(), 2.0 * std::sqrt(3.0)) << message;  // its support, in blocks of 1 m
}

TEST_F(Unstable, AnInvertedParticleIsNamedWithItsPosition) {
  poison([](Particle& p) { testing::set_affine(p, Mat3(-3000.0 * Mat3::Identity())); });  // det (I + dt C) = -8
  const std::string message = unstable_message([&] { step(state, scene, 1e-3); });
  EXPECT_THAT(message, HasSubstr("particle 987654"));
  const auto where = position_in(message);
  ASSERT_TRUE(where) << message;
  EXPECT_LE((*where - place).norm(), 0.01) << message;  // one step of gravity away, printed to four digits
}

TEST_F(Unstable, AnAbsurdVelocityIsAMessageNotACrash) {
  for (const double speed : {1e4, 1e9, 1e100, 1e200, 1e308, -1e308}) {
    const Particle sane = particle_of(state.grid, lonely);
    poison([&](Particle& p) { p.velocity[1] = speed; });
    const std::string message = unstable_message([&] { step(state, scene, 1e-3); });
    EXPECT_THAT(message, HasSubstr("particle 987654")) << speed;
    EXPECT_THAT(message, HasSubstr("t = 0.75 s"));
    poison([&](Particle& p) { p = sane; });
  }
}

TEST_F(Unstable, ACaseWithAnAbsurdVelocityDoesNotStart) {
  c.bodies[0].velocity = Vec3(1e9, 0.0, 0.0);
  State fast = make_state(c, scene);
  EXPECT_THROW(advance(fast, scene, 0.1), UnstableError);
}

TEST_F(Unstable, ATimeStepThatIsNoNumberIsAMessageNotACrash) { EXPECT_THROW(step(state, scene, std::nan("")), UnstableError); }

}  // namespace
}  // namespace mpm
