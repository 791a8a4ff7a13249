/// The library's step against a second formulation of the whole step: small avalanches, 50 steps of each and 250 of one.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "core/plain_step.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/core/stress_update.hpp"
#include "support/solver_states.hpp"

namespace mpm {
namespace {

using testing::affine_of;
using testing::position_of;
using testing::stress_of;
using testing::velocity_of;

/// A body of particles as the library's description of a staggered lattice says: layer n across the longest component of the velocity is
/// shifted within the cells of the lattice by the n-th point of the R2 sequence, less a half.
std::vector<plain::Particle> staggered_fill(const BodySpec& body, double spacing, double internal, bool mirror_y) {
  const double g = 1.32471795724474602596;
  const Vec3 size = body.max - body.min;
  const auto n = [&](int a) { return static_cast<int>(std::lround(size[a] / spacing)); };
  const Vec3 step(size.x() / n(0), size.y() / n(1), size.z() / n(2));
  std::vector<plain::Particle> all;
  for (int k = 0; k < n(2); ++k) {
    for (int j = 0; j < n(1); ++j) {
      for (int i = 0; i < n(0); ++i) {
        const auto fraction = [](double x) { return x - std::floor(x); };
        plain::Particle p;  // the velocity is along x
        double shift_y = fraction(0.5 + i / g) - 0.5;
        const double shift_z = fraction(0.5 + i / (g * g)) - 0.5;
        const double y = body.min.y() + (j + 0.5) * step.y();
        if (mirror_y && y < 0.0) continue;  // of a body that is symmetric about y = 0 the half
        p.x = Vec3(body.min.x() + (i + 0.5) * step.x(), y + shift_y * step.y(), body.min.z() + (k + 0.5 + shift_z) * step.z());
        p.v = body.velocity;
        p.internal = internal;
        p.volume = size.prod() / (n(0) * n(1) * n(2));
        all.push_back(p);
      }
    }
  }
  return all;
}

/// A slab of material on a floor and between side walls that runs against a mast. 0.25 m cells.
Case small_avalanche() {
  Case c;
  c.bodies.push_back({BodySpec::Shape::box, Vec3(-1.5, -1.25, 0.0), Vec3(0.0, 1.25, 0.75), Vec3(8.0, 0.0, 0.0)});
  WallSpec floor;
  floor.contact = Contact::separable;
  floor.friction = 0.2;
  c.walls.push_back(floor);
  for (const double side : {-1.25, 1.25}) {
    WallSpec wall;
    wall.point = Vec3(0.0, side, 0.0);
    wall.normal = Vec3(0.0, -side / 1.25, 0.0);
    wall.contact = Contact::slip;
    wall.friction = 0.1;
    c.walls.push_back(wall);
  }
  ObstacleSpec mast;
  mast.shape = BoxShape{.width = 1.25, .depth = 1.0};
  mast.friction = 0.3;
  c.obstacle = mast;
  c.domain.min = Vec3(-6.0, -4.0, -2.0);
  c.domain.max = Vec3(2.5, 4.0, 8.0);
  c.numerics.cell_size = 0.25;
  return c;
}

/// Largest differences of the particles of two runs, over the largest values.
struct Difference {
  double position = 0.0, velocity = 0.0, affine = 0.0, stress = 0.0, internal = 0.0, ratio = 0.0, impulse = 0.0;
};

/// What a run leaves, in the plain form.
struct Outcome {
  std::vector<plain::Particle> particles;
  std::vector<Vec3> impulses;
};
Difference difference(const Outcome& a, const Outcome& b) {
  Difference d;
  double v = 0.0, c = 0.0, t = 0.0, x = 0.0, j = 0.0, internal = 0.0;
  for (std::size_t i = 0; i < a.particles.size(); ++i) {
    const plain::Particle &p = a.particles[i], &q = b.particles[i];
    x = std::max(x, p.x.norm()), v = std::max(v, p.v.norm()), c = std::max(c, p.c.norm()), t = std::max(t, p.tau.norm());
    internal = std::max(internal, std::abs(p.internal));
    d.position = std::max(d.position, (p.x - q.x).norm());
    d.velocity = std::max(d.velocity, (p.v - q.v).norm());
    d.affine = std::max(d.affine, (p.c - q.c).norm());
    d.stress = std::max(d.stress, (p.tau - q.tau).norm());
    d.internal = std::max(d.internal, std::abs(p.internal - q.internal));
    d.ratio = std::max(d.ratio, std::abs(p.ratio / q.ratio - 1.0));
  }
  for (std::size_t i = 0; i < a.impulses.size(); ++i) {
    j = std::max(j, a.impulses[i].norm());
    d.impulse = std::max(d.impulse, (a.impulses[i] - b.impulses[i]).norm());
  }
  d.position /= x, d.velocity /= v, d.affine /= c, d.stress /= t, d.impulse /= j;
  d.internal /= std::max(internal, 1e-300);
  return d;
}

constexpr int steps = 50;        ///< in which the slab runs up the mast to 1 to 1.7 m
constexpr int many_steps = 250;  ///< of the default numerics: until the snow has been torn and falls

Outcome run_library(const Case& c, const CaseScene& scene, int count, std::vector<double>& step_sizes) {
  State state = make_state(c, scene);
  Outcome out;
  out.impulses.assign(scene.boundaries.size(), Vec3::Zero());
  for (int n = 0; n < count; ++n) {
    step_sizes.push_back(stable_time_step(state, scene));
    const StepReport report = step(state, scene, step_sizes.back());
    for (std::size_t b = 0; b < out.impulses.size(); ++b) out.impulses[b] += whole_force(report.impulses[b].linear, scene.mirror);
  }
  for (const Particle& p : testing::particles_by_id(state.grid)) {
    plain::Particle q;
    q.x = position_of(p), q.v = velocity_of(p), q.c = affine_of(p), q.tau = stress_of(p), q.internal = p.internal;
    q.ratio = volume_ratio(scene.material, p);
    out.particles.push_back(q);
  }
  return out;
}

/// @param round_off  velocities and elastic deformations are changed by up to so much of themselves in every step
Outcome run_plain(const Case& c, const CaseScene& scene, const plain::Law& law, double round_off, int count,
                  std::vector<double>& step_sizes) {
  plain::Solver solver(scene, law, c.numerics.cell_size);
  solver.particles = staggered_fill(c.bodies[0], 0.5 * c.numerics.cell_size, law.initial_internal, c.domain.mirror_y);
  solver.max_speed = c.bodies[0].velocity.norm();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int n = 0; n < count; ++n) {
    step_sizes.push_back(solver.stable_step());
    solver.step(step_sizes.back());
    if (round_off == 0.0) continue;
    for (plain::Particle& p : solver.particles) {
      for (int i = 0; i < 3; ++i) p.v[i] *= 1.0 + round_off * unit(random);
      const double rounded = 1.0 + round_off * unit(random);
      p.b_e *= rounded;
      p.ratio *= rounded;
    }
  }
  Outcome out{solver.particles, solver.impulses};
  for (Vec3& j : out.impulses) {  // of all parts: no net impulse across a mirror plane
    if (scene.mirror.x) j.x() = 0.0;
    if (scene.mirror.y) j.y() = 0.0;
  }
  return out;
}

/// Runs the same scene by both formulations. The bound on their difference is measured: ten times what changes of some round-offs of
/// velocities and deformations in every step make of the plain run. A node sums some hundred terms, and a return map takes some ten
/// operations, so that a step of the one formulation is some ten round-offs away from the other; growth is that of the flow, whatever
/// started it. The disturbance does not contain the round-off of the sums that are compared: 1e-13.
void expect_same(const Case& c, const plain::Law& law, bool flows = true, int count = steps) {
  const CaseScene scene = make_scene(c);
  std::vector<double> a, b, unused;
  const Outcome library = run_library(c, scene, count, a), second = run_plain(c, scene, law, 0.0, count, b);
  const Outcome disturbed = run_plain(c, scene, law, 16.0 * std::numeric_limits<double>::epsilon(), count, unused);
  ASSERT_EQ(library.particles.size(), second.particles.size());
  ASSERT_EQ(disturbed.particles.size(), second.particles.size());
  const Difference ours = difference(second, library), grown = difference(second, disturbed);
  const auto check = [&](const char* what, double difference, double growth) {
    EXPECT_LE(difference, 10.0 * growth + 1e-13) << what;
    EXPECT_LT(growth, 1e-7) << what << ": round-off has grown too much for a comparison";
    ::testing::Test::RecordProperty(what, fmt::format("{:.1e} of {:.1e}", difference, growth));
  };
  check("position", ours.position, grown.position);
  check("velocity", ours.velocity, grown.velocity);
  check("affine", ours.affine, grown.affine);
  check("stress", ours.stress, grown.stress);
  check("internal", ours.internal, grown.internal);
  check("ratio", ours.ratio, grown.ratio);
  check("impulse", ours.impulse, grown.impulse);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-9 * a[i]);
  // the scene has to be one: the last boundary takes momentum, what flows rises before it
  EXPECT_GT(second.impulses.back().norm(), 100.0);
  double highest = 0.0;
  for (const plain::Particle& p : second.particles) highest = std::max(highest, p.x.z());
  if (flows) {
    EXPECT_GT(highest, 0.9);
  }
}

/// The same on snow with these parameters. @param slope  M. @param beta  cohesion. @param xi  hardening
void expect_same_on_snow(Case c, double slope, double beta, double xi, int count = steps) {
  auto& snow = c.material.as<CamClay>();
  snow.critical_state_slope = slope;
  snow.cohesion_beta = beta;
  snow.hardening_xi = xi;
  const double e = snow.young_modulus, nu = snow.poisson_ratio, pc0 = snow.preconsolidation_pressure;
  expect_same(
      c,
      slope > 0.0 ? plain::cam_clay(snow.density, e, nu, slope, beta, xi, pc0) : plain::slippery_snow(snow.density, e, nu, beta, xi, pc0),
      true, count);
}

TEST(PlainStep, AgreesOnSnowWithTheDefaultNumerics) {
  const Case c = small_avalanche();
  EXPECT_EQ(c.numerics.transfer, Transfer::aflip);
  EXPECT_EQ(c.numerics.contact, ContactRule::surface);
  expect_same_on_snow(c, 0.8, 0.3, 0.5, many_steps);
}

TEST(PlainStep, AgreesOnHardSnowWithoutCohesion) { expect_same_on_snow(small_avalanche(), 0.4, 0.0, 5.0); }

TEST(PlainStep, AgreesOnSnowAgainstARoundMast) {
  Case c = small_avalanche();
  c.obstacle->shape = CylinderShape{.width = 1.25};
  expect_same_on_snow(c, 0.8, 0.3, 0.5);
}

TEST(PlainStep, AgreesOnSandWithNodalContactApicAndAMirrorPlane) {
  Case c = small_avalanche();
  DruckerPrager::Parameters sand;
  sand.friction_angle = 0.5;
  sand.cone_matching = ConeMatching::simple_shear;
  c.material = sand;
  c.numerics.contact = ContactRule::nodal;
  c.numerics.transfer = Transfer::apic;
  c.domain.mirror_y = true;
  c.walls.erase(c.walls.begin() + 1);  // the side at y = -1.25 is beyond the mirror plane
  expect_same(c, plain::drucker_prager(sand.density, sand.young_modulus, sand.poisson_ratio, std::sqrt(3.0) * std::tan(0.5)));
}

TEST(PlainStep, AgreesOnAnElasticBodyWithFlip) {
  Case c = small_avalanche();
  HenckyElastic::Parameters rubber;
  c.material = rubber;
  c.numerics.transfer = Transfer::flip;
  c.numerics.flip_ratio = 0.95;
  expect_same(c, plain::elastic(rubber.density, rubber.young_modulus, rubber.poisson_ratio), false);
}

TEST(PlainStep, AgreesOnSnowWithoutFriction) { expect_same_on_snow(small_avalanche(), 0.0, 0.15, 0.5); }

plain::Law law_of(const WeaklyCompressibleFluid::Parameters& fluid) {
  return plain::fluid(fluid.density, fluid.bulk_modulus, fluid.tait_exponent, fluid.carries_tension);
}

TEST(PlainStep, AgreesOnAFluidThatTears) {
  Case c = small_avalanche();
  const WeaklyCompressibleFluid::Parameters fluid;
  c.material = fluid;
  expect_same(c, law_of(fluid));
}

TEST(PlainStep, AgreesOnAFluidThatIsPulledInASliceOneCellWideBeforeATravellingWall) {
  Case c = small_avalanche();
  WeaklyCompressibleFluid::Parameters fluid;
  fluid.carries_tension = true;
  fluid.tait_exponent = 1;
  c.material = fluid;
  c.obstacle.reset();
  c.bodies[0].min.y() = 0.25;
  c.bodies[0].max.y() = 0.5;
  c.walls[1].point.y() = 0.25;  // so near to one another the sides cannot act on columns of nodes
  c.walls[2].point.y() = 0.5;
  WallSpec piston;
  piston.point = Vec3(0.3, 0.0, 0.0);
  piston.normal = -Vec3::UnitX();
  piston.contact = Contact::slip;
  piston.velocity = Vec3(-1.0, 0.0, 0.0);
  c.walls.push_back(piston);
  expect_same(c, law_of(fluid));
}

TEST(PlainStep, AgreesOnAFluidBetweenTwoMirrorPlanes) {
  Case c = small_avalanche();
  const WeaklyCompressibleFluid::Parameters fluid;
  c.material = fluid;
  c.obstacle.reset();
  c.domain.mirror_x = c.domain.mirror_y = true;
  c.bodies[0].min.x() = 0.0;
  c.bodies[0].max.x() = 1.5;
  WallSpec end;
  end.point = Vec3(1.75, 0.0, 0.0);
  end.normal = -Vec3::UnitX();
  end.contact = Contact::separable;
  c.walls[1] = end;                                                  // the side at y = -1.25 is beyond the mirror plane
  std::rotate(c.walls.begin(), c.walls.begin() + 1, c.walls.end());  // the floor is the last
  expect_same(c, law_of(fluid));
}

TEST(PlainStep, FindsTheElasticStateOfAStress) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const plain::Law law = plain::elastic(300.0, 1e6, 0.1);
  for (int i = 0; i < 20; ++i) {
    plain::Particle p;
    for (double& c : p.c.reshaped()) c = 100.0 * unit(random);
    law.update(p, 1e-3);  // strains of 10 %
    EXPECT_LT((law.elastic_state(p.tau) - p.b_e).norm(), 1e-13) << "the round-off of two decompositions of a matrix near 1";
    EXPECT_NEAR(p.ratio, std::sqrt(p.b_e.determinant()), 1e-14) << "without plasticity J^2 = det b_e";
  }
}

}  // namespace
}  // namespace mpm
