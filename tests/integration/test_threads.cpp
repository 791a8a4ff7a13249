#include <gtest/gtest.h>
#include <omp.h>

#include "libmpm/driver/run.hpp"
#include "support/command.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

/// All bytes of all particles in storage order, and what else a state holds, after some steps.
struct Outcome {
  std::vector<Particle> particles;
  std::vector<double> numbers;
};

Outcome run(const Case& c, int threads, int steps) {
  omp_set_num_threads(threads);
  const Scene scene = make_scene(c);
  State state = make_state(c, scene);
  Outcome outcome;
  for (int n = 0; n < steps; ++n) {
    const StepReport report = step(state, scene, stable_time_step(state, scene));
    for (const Impulse& j : report.impulses) {
      for (int i = 0; i < 3; ++i) outcome.numbers.insert(outcome.numbers.end(), {j.linear[i], j.angular[i]});
    }
    outcome.numbers.insert(outcome.numbers.end(), {report.dt, report.gravity_impulse.z(), report.left.mass, report.left.momentum.x(),
                                                   state.max_speed, state.time});
  }
  outcome.particles = testing::stored_particles(state.grid);
  omp_set_num_threads(1);
  return outcome;
}

void expect_same_bits(const Case& c, int steps, std::initializer_list<int> thread_numbers) {
  const Outcome one = run(c, 1, steps);
  ASSERT_FALSE(one.particles.empty());
  for (const int threads : thread_numbers) {
    const Outcome many = run(c, threads, steps);
    EXPECT_EQ(one.numbers, many.numbers) << threads;
    EXPECT_TRUE(testing::same_bytes(one.particles, many.particles)) << threads;
  }
}

struct Named {
  const char* name;
  Case c;
  friend void PrintTo(const Named& n, std::ostream* out) { *out << n.name; }
};

/// A body of some hundred to a thousand particles on a floor with friction, dx = 0.25 m.
Case body_on_floor(BodySpec::Shape shape, const Vec3& velocity) {
  Case c = testing::empty_case();
  BodySpec body = testing::box_body({-1.0, -1.0, 0.05}, {1.0, 1.0, 1.55}, velocity);
  body.shape = shape;
  c.bodies = {body};
  c.walls = {testing::wall(Vec3::Zero(), Vec3::UnitZ(), Contact::separable, 0.4)};
  return c;
}

std::vector<Named> cases() {
  std::vector<Named> all = {{"avalanche_apic", testing::small_avalanche(6.0)}, {"avalanche_flip_cohesion", testing::small_avalanche(6.0)}};
  all[1].c.material = testing::cam_clay_snow(0.8, 0.3);
  all[1].c.numerics.transfer = Transfer::flip;
  all.push_back({"bodies_and_walls", body_on_floor(BodySpec::Shape::cylinder, {3.0, 1.0, -4.0})});
  Case& bodies = all.back().c;
  bodies.bodies.push_back(testing::box_body({1.0, -0.5, 0.5}, {2.0, 0.5, 1.0}, {-5.0, 0.0, 0.0}));  // they meet
  WallSpec piston = testing::wall({-1.0, 0.0, 0.0}, {1.0, 0.2, 0.0}, Contact::slip);
  piston.velocity = Vec3(2.0, 0.0, 0.0);
  bodies.walls.push_back(piston);
  bodies.domain.max = Vec3(1.8, 5.0, 5.0);  // some leave
  all.push_back({"mirrored_sand", body_on_floor(BodySpec::Shape::cylinder, Vec3::Zero())});
  all.back().c.material = DruckerPrager::Parameters{};
  all.back().c.domain.mirror_x = all.back().c.domain.mirror_y = true;
  all.push_back({"mirrored_viscous_fluid", body_on_floor(BodySpec::Shape::box, Vec3::Zero())});
  all.back().c.material = WeaklyCompressibleFluid::Parameters{.viscosity = 50.0};
  all.back().c.domain.mirror_y = true;
  all.push_back({"avalanche_aflip_at_surfaces", testing::small_avalanche(6.0)});
  all.push_back({"whole_avalanche_aflip_at_a_cylinder", testing::small_avalanche(6.0)});
  all.back().c.conveyor->mirror_y = false;
  all.back().c.obstacle->shape = CylinderShape{.width = 0.8};
  all.back().c.obstacle->height = 0.6;  // of the flow's 1 m
  for (std::size_t n = all.size() - 2; n < all.size(); ++n) {
    Case& c = all[n].c;
    c.numerics.transfer = Transfer::aflip;
    c.numerics.contact = ContactRule::surface;
    c.conveyor->upstream_length = 0.5;  // it is at the obstacle soon
    c.obstacle->friction = 0.3;
  }
  all.push_back({"bodies_aflip_at_surfaces", all[2].c});
  all.back().c.numerics.transfer = Transfer::aflip;
  all.back().c.numerics.contact = ContactRule::surface;
  all.back().c.walls[1].normal = Vec3::UnitX();  // a piston along the grid
  for (const auto& [name, of] : {std::pair{"avalanche_in_single_precision", 5}, std::pair{"cohesion_flip_in_single_precision", 1},
                                 std::pair{"sand_in_single_precision", 3}}) {
    all.push_back({name, all[static_cast<std::size_t>(of)].c});
    all.back().c.numerics.precision = Precision::single_precision;
  }
  for (Named& n : all) {
    n.c.output.series_per_second = 50.0;
    n.c.output.frames_per_second = 0.0;
    n.c.output.duration = 0.06;
  }
  return all;
}

class SameBits : public ::testing::TestWithParam<Named> {};
INSTANTIATE_TEST_SUITE_P(Cases, SameBits, ::testing::ValuesIn(cases()), [](const auto& test) { return std::string(test.param.name); });

TEST_P(SameBits, OnAnyNumberOfThreads) { expect_same_bits(GetParam().c, 60, {2, 3, 4, 8}); }

/// Runs to `samples` samples and stops there, or to the end.
void run_stretch(Case c, const std::filesystem::path& out, int threads, bool resume, int samples, double duration) {
  c.output.duration = duration;
  RunOptions options{.out = out, .threads = threads, .resume = resume};
  options.poll = [left = samples]() mutable { return --left == 0 ? Request::stop : Request::none; };
  run_case(c, options);
  omp_set_num_threads(1);
}

TEST_P(SameBits, ResumedAndExtendedOnOtherNumbersOfThreads) {
  const testing::TemporaryDirectory directory;
  const Case& c = GetParam().c;
  const double duration = c.output.duration;
  constexpr int all = -1;
  run_stretch(c, directory / "whole", 1, false, all, duration);
  run_stretch(c, directory / "resumed", 2, false, 1, duration);  // final.h5 is not there yet: it was stopped
  EXPECT_FALSE(std::filesystem::exists(directory / "resumed/final.h5"));
  run_stretch(c, directory / "resumed", 3, true, 1, duration);
  run_stretch(c, directory / "resumed", 1, true, all, duration);
  run_stretch(c, directory / "extended", 4, false, all, duration / 3.0);
  run_stretch(c, directory / "extended", 8, true, all, duration);
  for (const char* how : {"resumed", "extended"}) {
    // final.h5 holds every particle by its number, series.csv all digits; neither has a time stamp
    for (const char* file : {"final.h5", "series.csv"}) {
      const std::string whole = testing::content(directory / "whole" / file);
      EXPECT_FALSE(whole.empty());
      EXPECT_EQ(whole, testing::content(directory / how / file)) << how << ' ' << file;
    }
  }
}

}  // namespace
}  // namespace mpm
