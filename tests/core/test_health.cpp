#include "libmpm/core/health.hpp"

#include <gmock/gmock.h>

#include "libmpm/base/error.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/driver/estimate.hpp"
#include "libmpm/driver/run.hpp"
#include "support/command.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using ::testing::AllOf;
using testing::box_body;
using ::testing::Contains;
using ::testing::ElementsAre;
using testing::empty_case;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

double energy_of(const Totals& t) { return t.kinetic_energy + t.affine_energy + t.elastic_energy; }

/// What an energy watch saw: the largest share at any sample, and the balance at the end.
struct Watched {
  double largest_share = 0.0, gain = 0.0, energy = 0.0;
  State state;
};

Watched watch(const Case& c, double duration, double from = 0.0) {
  const CaseScene scene = make_scene(c);
  Watched seen{.state = make_state(c, scene)};
  advance(seen.state, scene, from);
  EnergyWatch energy(seen.state, scene);
  for (int k = 1; k <= 20; ++k) {
    advance(seen.state, scene, from + k * duration / 20, [&](const StepReport& report) { energy.add(report); });
    const Totals now = totals(seen.state, scene);
    seen.largest_share = std::max(seen.largest_share, energy.excess_ratio(now));
    seen.energy = energy_of(now);
  }
  seen.gain = energy.gain();
  return seen;
}

/// A cube of water of 1 m that spreads on a floor; dx = 1/8 m, so that density c cell_size = 3953 Pa s.
Case viscous_drop(double viscosity) {
  Case c = empty_case();
  c.material = WeaklyCompressibleFluid::Parameters{};
  c.material.set_density(1000.0);
  c.material.as<WeaklyCompressibleFluid>().viscosity = viscosity;
  c.numerics.cell_size = 0.125;
  c.bodies = {box_body(Vec3::Zero(), Vec3::Ones())};
  c.walls = {testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::no_slip)};
  c.domain.mirror_x = c.domain.mirror_y = true;
  return c;
}

TEST(EnergyWatch, BooksTheWorkOfGravityExactly) {
  // Symplectic Euler in free fall: a step gives g.v_new m dt by the watch and m (g.v_new dt - g^2 dt^2/2) in truth.
  for (const Transfer transfer : {Transfer::apic, Transfer::flip}) {
    Case c = empty_case();
    c.numerics.transfer = transfer;
    c.bodies = {box_body({0.0, 0.0, 0.0}, {0.5, 1.0, 0.5}, {3.0, 0.0, 2.0})};
    const CaseScene scene = make_scene(c);
    State state = make_state(c, scene);
    EnergyWatch energy(state, scene);
    const double mass = totals(state, scene).mass, dt = 1e-3;
    for (int n = 0; n < 100; ++n) energy.add(step(state, scene, dt));
    const Totals now = totals(state, scene);
    EXPECT_EQ(energy.excess_ratio(now), 0.0);
    // round-off of a hundred steps of the kinetic energy
    EXPECT_NEAR(energy.gain(), -100.0 * 0.5 * mass * 9.81 * 9.81 * dt * dt, 1e-12 * energy_of(now));
  }
}

TEST(EnergyWatch, BooksWhatTheInletTheWallsAndTheOutletGiveAndTake) {
  // A plug that only travels, from when its front has left: a third of it is exchanged, and the balance is zero, but for what the front's
  // collapse left behind.
  Case c = testing::small_avalanche(8.0);
  c.obstacle.reset();
  const Watched seen = watch(c, 0.2, 0.35);
  EXPECT_GT(seen.state.entered.energy, 0.5 * seen.energy);
  EXPECT_GT(seen.state.left.energy, 0.3 * seen.energy);
  EXPECT_LT(std::abs(seen.gain), 0.01 * seen.energy);
  EXPECT_LT(seen.largest_share, 0.01);
}

TEST(EnergyWatch, BooksTheWorkOfAMovingWall) {
  // A piston at 2 m/s sets an elastic body at rest in motion: what it has comes from the piston alone.
  Case c = empty_case();
  c.numerics.gravity = 0.0;
  c.bodies = {box_body(Vec3::Zero(), {1.0, 0.5, 0.5})};
  WallSpec piston = testing::wall(Vec3::Zero(), Vec3::UnitX(), Contact::separable);
  piston.velocity = Vec3(2.0, 0.0, 0.0);
  c.walls = {piston};
  const Watched seen = watch(c, 0.1);
  EXPECT_GT(seen.energy, 100.0);  // m u^2/2 = 150 J, twice that after an elastic bounce
  EXPECT_LT(seen.gain, 0.0);
  EXPECT_LT(seen.largest_share, EnergyWatch::suspicious);
}

TEST(EnergyWatch, IsSilentInSoundRuns) {
  std::vector<Case> cases = {testing::small_avalanche(), testing::small_avalanche(), testing::small_avalanche(), viscous_drop(0.0),
                             empty_case()};
  cases[1].numerics.transfer = Transfer::flip;
  cases[2].conveyor->sidewall_contact = Contact::separable;
  cases[2].conveyor->sidewall_friction = 0.5;
  cases[4].bodies = {box_body({0.0, 0.0, 0.5}, {0.5, 0.5, 1.0}, {1.0, 0.0, -5.0})};  // bounces, all elastic, two cells wide
  cases[4].walls = {testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::separable)};
  for (std::size_t i = 0; i < cases.size(); ++i) EXPECT_LT(watch(cases[i], 0.25).largest_share, 0.5 * EnergyWatch::suspicious) << i;
}

TEST(EnergyWatch, SeesStepsThatAreTooLong) {
  Case c = viscous_drop(4000.0);
  double share = 0.0;
  CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  HealthWatch health(state, scene);
  const double dt = 4.0 * stable_time_step(state, scene);
  std::vector<std::string> reported;
  std::string last;
  try {
    EnergyWatch energy(state, scene);
    for (int n = 0; n < 400; ++n) {
      const StepReport report = step(state, scene, dt);
      energy.add(report);
      health.add(report);
      if (n % 2 == 1) continue;
      const Totals now = totals(state, scene);
      share = std::max(share, energy.excess_ratio(now));
      for (const std::string& warning : health.check(state, scene, now)) reported.push_back(warning);
    }
  } catch (const UnstableError& error) {
    last = error.what();
  }
  EXPECT_GT(share, EnergyWatch::suspicious);
  EXPECT_THAT(reported, Contains(AllOf(HasSubstr("may be unstable at t = "), HasSubstr("step "), HasSubstr("came from nothing"),
                                       HasSubstr("particle "), HasSubstr(" m, "), HasSubstr("a smaller CFL number or a finer grid"))));
  EXPECT_THAT(last, AllOf(HasSubstr("unstable at t = "), HasSubstr("came from nothing")));
}

TEST(HealthWatch, SaysOnceThatTheTimeStepShrinks) {
  Case c = empty_case();
  c.bodies = {box_body(Vec3::Zero(), Vec3::Constant(0.5))};
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  HealthWatch health(state, scene);
  const Totals now = totals(state, scene);
  EXPECT_THAT(health.check(state, scene, now), ElementsAre());
  testing::change_particle(state.grid, 5, [](Particle& p) { p.velocity[2] = 700.0; });  // twelve times the speed of sound
  state.max_speed = 700.0;
  EXPECT_THAT(health.check(state, scene, now),
              ElementsAre(AllOf(StartsWith("warning: the time step has shrunk"), HasSubstr("particle 5 at ("), HasSubstr("700 m/s"),
                                HasSubstr("step 0"), HasSubstr("a finer grid"))));
  EXPECT_THAT(health.check(state, scene, now), ElementsAre());
}

TEST(StableTimeStep, IsLimitedByViscosity) {
  for (const auto& [viscosity, shortened] : {std::pair{0.0, false}, {1900.0, false}, {2100.0, true}, {40000.0, true}}) {
    const Case c = viscous_drop(viscosity);
    const CaseScene scene = make_scene(c);
    const State state = make_state(c, scene);
    const double acoustic = 0.4 * 0.125 / std::sqrt(1e6 / 1000.0);
    // 1/(2 nu) dx^2, above rho c dx/2 = 1976 Pa s
    const double expected = shortened ? 0.4 * 1000.0 * 0.125 * 0.125 / (2.0 * viscosity) : acoustic;
    EXPECT_NEAR(stable_time_step(state, scene), expected, 1e-12 * expected) << viscosity;
    if (viscosity > 1e4) {  // below, the estimate's fall of a metre counts
      EXPECT_NEAR(estimate(c).time_step, expected, 1e-12 * expected);
    }
  }
}

TEST(StableTimeStep, KeepsAViscousFluidStable) {
  // One, two and ten times what an explicit step of acoustic size bears, in a drop that is thrown against the floor.
  for (const double viscosity : {2000.0, 4000.0, 20000.0}) {
    Case c = viscous_drop(viscosity);
    c.numerics.cell_size = 0.25;
    c.bodies[0].velocity = Vec3(0.0, 0.0, -5.0);
    const Watched seen = watch(c, 0.2);
    EXPECT_LT(seen.largest_share, 0.5 * EnergyWatch::suspicious) << viscosity;
    EXPECT_LT(seen.state.max_speed, 10.0) << viscosity;
  }
}

TEST(ParticlesInside, ABoundaryAreCountedAndOneIsNamed) {
  Case c = empty_case();
  c.bodies = {box_body({0.0, 0.0, -0.5}, {0.5, 0.5, 0.5})};  // 4 x 4 x 8 particles, half of them below the floor
  c.walls = {testing::wall({0.0, 0.0, -5.0}, Vec3::UnitZ(), Contact::slip), testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::slip)};
  CaseScene scene = make_scene(c);
  EXPECT_THAT(particles_inside_boundaries(make_state(c, scene), scene),
              ElementsAre(AllOf(StartsWith("warning: 64 particles are inside [[wall]] number 2"),
                                HasSubstr("particle 0 at (0.0625, 0.0625, -0.4375) m"), HasSubstr("move the [[body]]"))));
  c.bodies = {box_body(Vec3::Zero(), Vec3::Constant(0.5))};
  EXPECT_THAT(particles_inside_boundaries(make_state(c, scene), scene), ElementsAre());
  c.obstacle = ObstacleSpec{.shape = BoxShape{.width = 0.5, .depth = 0.5}};
  scene = make_scene(c);
  EXPECT_THAT(particles_inside_boundaries(make_state(c, scene), scene), ElementsAre(HasSubstr("inside the [obstacle]")));
  const Case conveyor = testing::small_avalanche();  // its feed starts behind the inlet
  scene = make_scene(conveyor);
  EXPECT_THAT(particles_inside_boundaries(make_state(conveyor, scene), scene), ElementsAre());
}

TEST(UpdateStress, FindsAFaultInAnyNumberOfAnyParticleWithAnyLaw) {
  const auto numbers = [](Particle& p) {
    std::vector<double*> all;
    for (double& v : p.affine) all.push_back(&v);
    for (double& v : p.stress) all.push_back(&v);
    all.push_back(&p.internal);
    return all;
  };
  for (const MaterialParameters& spec : testing::every_law()) {
    const std::string name(spec.name());
    const AnyMaterial law = make_material(spec);
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      for (std::size_t n = 0; n < 16; ++n) {
        if (name == "weakly_compressible_fluid" && n >= 9 && n < 15) continue;  // its stress before does not count
        State state(0.25);
        for (int i = 0; i < 21; ++i) {  // a whole group of sixteen and a part of one
          Particle p = testing::particle_at({0.5, 0.5, 0.5}, static_cast<std::uint64_t>(i));
          p.internal = initial_internal_of(law);
          state.grid.insert(p);
        }
        state.grid.refresh();
        const auto block = state.grid.occupied_blocks()[0];
        ASSERT_TRUE(update_stress(state.grid, block, law, 1e-3)) << name;
        testing::change_particle(state.grid, n % 2 == 0 ? n : 20, [&](Particle& p) { *numbers(p)[n] = bad; });
        EXPECT_FALSE(update_stress(state.grid, block, law, 1e-3)) << name << " number " << n << " = " << bad;
      }
    }
  }
}

TEST(Step, NamesTheInvertedParticleAmongThoseItSpoils) {
  Case c = empty_case();
  c.bodies = {box_body(Vec3::Zero(), Vec3::Constant(0.5))};
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  state.step = 42;
  testing::change_particle(state.grid, 17, [](Particle& p) {
    p.volume *= 1e3;  // outweighs its neighbours, so that the grid takes its velocity field over
    testing::set_affine(p, Mat3(-3000.0 * Mat3::Identity()));
  });
  try {
    step(state, scene, 1e-3);
    FAIL() << "not unstable";
  } catch (const UnstableError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("inversion"), HasSubstr("inside out, det(I + dt C) = -"), HasSubstr("step 42"),
                                    HasSubstr("t = 0 s"), HasSubstr("a smaller CFL number or a finer grid")));
  }
}

/// All that a run says to its caller, and what it logs.
struct Reported {
  std::vector<std::string> messages;
  std::string log, error;
};

Reported run_and_listen(const Case& c) {
  const testing::TemporaryDirectory directory;
  Reported reported;
  RunOptions options{.out = directory / "run", .threads = 1};
  options.on_progress = [&](const Progress& p) {
    if (!p.message.empty()) reported.messages.push_back(p.message);
  };
  try {
    run_case(c, options);
  } catch (const UnstableError& error) {
    reported.error = error.what();
  }
  reported.log = testing::content(directory / "run/run.log");
  return reported;
}

TEST(RunCase, WarnsOfWhatIsInsideAWallAndGoesOn) {
  Case c = empty_case();
  c.bodies = {box_body({0.0, 0.0, -0.5}, {0.5, 0.5, 0.5})};
  c.walls = {testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::slip)};
  c.output.duration = 0.02;
  const Reported reported = run_and_listen(c);
  EXPECT_EQ(reported.error, "");
  EXPECT_THAT(reported.messages, Contains(HasSubstr("inside [[wall]] number 1")));
  EXPECT_THAT(reported.log, HasSubstr("inside [[wall]] number 1"));
}

TEST(RunCase, EndsWhereEnergyComesFromNothing) {
  Case c = empty_case();
  c.bodies = {box_body(Vec3::Zero(), Vec3::Constant(1.0))};
  c.walls = {testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::no_slip)};
  c.output.duration = 0.5;
  c.output.series_per_second = 100.0;
  EXPECT_THAT(run_and_listen(c).messages, Not(Contains(HasSubstr("warning"))));
  c.material = MaterialParameters(WeaklyCompressibleFluid::Parameters{});  // without a limit for lone particles
  c.bodies = {box_body(Vec3::Zero(), Vec3::Constant(1.0), {0.0, 0.0, -1.0})};
  c.numerics.cfl = 3.0;  // the reader admits at most 1
  const Reported reported = run_and_listen(c);
  EXPECT_THAT(reported.error, AllOf(HasSubstr("unstable at t = "), HasSubstr("came from nothing"), HasSubstr("particle ")));
  EXPECT_THAT(reported.log, HasSubstr(reported.error));
}

}  // namespace
}  // namespace mpm
