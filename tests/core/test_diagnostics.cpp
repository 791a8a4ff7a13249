#include "libmpm/core/diagnostics.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <cstring>

#include "libmpm/core/stress_update.hpp"
#include "support/solver_states.hpp"

namespace mpm {
namespace {

using testing::position_of;
using testing::velocity_of;

State random_state(const Scene&, std::size_t count, bool half) {
  std::mt19937_64 random(41);
  std::uniform_real_distribution<double> place(-2.0, 2.0);
  State state(0.25);
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 x(place(random), place(random), place(random));
    if (half) x.y() = std::abs(x.y());
    Particle p = testing::particle_at(x, i);
    testing::randomise(p, random);
    state.grid.insert(p);
  }
  state.grid.refresh();
  return state;
}

TEST(Totals, AreTheSumsOverTheParticles) {
  for (const Transfer transfer : {Transfer::apic, Transfer::flip}) {
    Case c = testing::empty_case();
    c.numerics.transfer = transfer;
    c.numerics.slope = 0.3;
    const CaseScene scene = make_scene(c);
    const State state = random_state(scene, 2000, false);
    Totals expected;
    double size = 0.0;
    for (const Particle& p : testing::stored_particles(state.grid)) {
      const double m = 300.0 * p.volume;
      const Mat3 c_p = testing::affine_of(p);
      const Vec3 axial(c_p(2, 1) - c_p(1, 2), c_p(0, 2) - c_p(2, 0), c_p(1, 0) - c_p(0, 1));
      ++expected.particles;
      expected.mass += m;
      expected.centre += m * position_of(p);
      expected.momentum += m * velocity_of(p);
      expected.momentum_scale += m * velocity_of(p).norm();
      expected.angular_momentum += position_of(p).cross(m * velocity_of(p));
      if (transfer == Transfer::apic) {
        expected.angular_momentum += m * 0.25 * 0.25 / 4.0 * axial;
        for (int i = 0; i < 9; ++i) expected.affine_energy += 0.5 * m * 0.25 * 0.25 / 4.0 * p.affine[i] * p.affine[i];
      }
      expected.angular_momentum_scale += m * position_of(p).norm() * velocity_of(p).norm();
      expected.kinetic_energy += 0.5 * m * velocity_of(p).squaredNorm();
      expected.potential_energy -= m * 9.81 * (std::sin(0.3) * p.position[0] - std::cos(0.3) * p.position[2]);
      expected.elastic_energy += stored_energy(scene.material, p);
      size += m * (velocity_of(p).norm() * (1.0 + position_of(p).norm()) + 20.0);
    }
    const Totals t = totals(state, scene);
    const double tolerance = 1e-13 * size;  // sums of 2000 terms in another order
    EXPECT_EQ(t.particles, expected.particles);
    EXPECT_NEAR(t.mass, expected.mass, 1e-13 * expected.mass);
    EXPECT_LE((t.momentum - expected.momentum).norm(), tolerance);
    EXPECT_LE((t.angular_momentum - expected.angular_momentum).norm(), tolerance);
    EXPECT_LE((t.centre - expected.centre / expected.mass).norm(), 1e-13 * size / expected.mass);
    EXPECT_NEAR(t.momentum_scale, expected.momentum_scale, 1e-13 * expected.momentum_scale);
    EXPECT_NEAR(t.angular_momentum_scale, expected.angular_momentum_scale, 1e-13 * expected.angular_momentum_scale);
    EXPECT_NEAR(t.kinetic_energy, expected.kinetic_energy, 1e-13 * expected.kinetic_energy);
    EXPECT_NEAR(t.affine_energy, expected.affine_energy, 1e-13 * expected.affine_energy);
    EXPECT_NEAR(t.elastic_energy, expected.elastic_energy, 1e-13 * expected.elastic_energy);
    EXPECT_NEAR(t.potential_energy, expected.potential_energy, 10.0 * tolerance);
  }
}

TEST(Totals, HaveTheSameBitsOnAnyNumberOfThreads) {
  const CaseScene scene = make_scene(testing::empty_case());
  const State state = random_state(scene, 3000, false);
  const Totals one = totals(state, scene);
  for (const int threads : {2, 3, 4}) {
    omp_set_num_threads(threads);
    const Totals t = totals(state, scene);
    EXPECT_EQ(t.mass, one.mass);
    EXPECT_EQ(t.momentum, one.momentum);
    EXPECT_EQ(t.angular_momentum, one.angular_momentum);
    EXPECT_EQ(t.kinetic_energy, one.kinetic_energy);
    EXPECT_EQ(t.elastic_energy, one.elastic_energy);
    EXPECT_EQ(t.potential_energy, one.potential_energy);
  }
  omp_set_num_threads(1);
}

TEST(Totals, OfAMirroredPartCompleteToThoseOfTheWhole) {
  const CaseScene scene = make_scene(testing::empty_case());
  const State part = random_state(scene, 500, true);
  State whole(0.25);
  for (Particle p : testing::stored_particles(part.grid)) {
    whole.grid.insert(p);
    p.position[1] *= -1.0;  // the image: y of vectors, xy and yz of tensors change sign
    p.velocity[1] *= -1.0;
    for (const int n : {1, 3, 5, 7}) p.affine[n] *= -1.0;
    for (const int n : {3, 5}) p.stress[n] *= -1.0;
    whole.grid.insert(p);
  }
  whole.grid.refresh();
  const Totals expected = totals(whole, scene), t = whole_of_mirrored(totals(part, scene), {false, true});
  const double size = expected.mass * 20.0;
  EXPECT_EQ(t.particles, expected.particles);
  EXPECT_NEAR(t.mass, expected.mass, 1e-13 * expected.mass);
  EXPECT_LE((t.momentum - expected.momentum).norm(), 1e-13 * size);
  EXPECT_LE((t.angular_momentum - expected.angular_momentum).norm(), 1e-13 * size);
  EXPECT_LE((t.centre - expected.centre).norm(), 1e-13 * size / expected.mass);
  EXPECT_NEAR(t.momentum_scale, expected.momentum_scale, 1e-13 * expected.momentum_scale);
  EXPECT_NEAR(t.angular_momentum_scale, expected.angular_momentum_scale, 1e-13 * expected.angular_momentum_scale);
  EXPECT_NEAR(t.kinetic_energy, expected.kinetic_energy, 1e-13 * expected.kinetic_energy);
  EXPECT_NEAR(t.affine_energy, expected.affine_energy, 1e-13 * expected.affine_energy);
  EXPECT_NEAR(t.elastic_energy, expected.elastic_energy, 1e-13 * expected.elastic_energy);
  EXPECT_NEAR(t.potential_energy, expected.potential_energy, 1e-13 * size * 10.0);
}

TEST(WholeForceAndMoment, AddTheImagesInTheMirrorPlanes) {
  const Vec3 force(1.0, 2.0, 3.0), at(4.0, 5.0, 6.0), moment = at.cross(force);
  for (const bool x : {false, true}) {
    for (const bool y : {false, true}) {
      Vec3 f = Vec3::Zero(), m = Vec3::Zero();
      for (const double sx : {1.0, -1.0}) {
        for (const double sy : {1.0, -1.0}) {
          if ((sx < 0.0 && !x) || (sy < 0.0 && !y)) continue;
          const Vec3 image(sx * force.x(), sy * force.y(), force.z());
          f += image;
          m += Vec3(sx * at.x(), sy * at.y(), at.z()).cross(image);
        }
      }
      EXPECT_EQ(whole_force(force, {x, y}), f);
      EXPECT_EQ(whole_moment(moment, {x, y}), m);
    }
  }
}

}  // namespace
}  // namespace mpm
