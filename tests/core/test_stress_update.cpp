#include "libmpm/core/stress_update.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "support/solver_states.hpp"

namespace mpm {
namespace {

using testing::affine_of;
using testing::cam_clay_snow;
using testing::elastic_snow;
using testing::particle_at;

constexpr double dx = 0.25, dt = 1e-3;

/// The specification: the law itself, one point at a time, in double.
Particle updated_alone(const AnyMaterial& material, Particle p) {
  const Mat3 c = affine_of(p);
  Matrix3<double> dl;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) dl.m[i][j] = dt * c(i, j);
  }
  MaterialState<double> state{{p.stress[0], p.stress[1], p.stress[2], p.stress[3], p.stress[4], p.stress[5]}, p.internal};
  std::visit([&](const auto& law) { law.update_stress(state, dl, dt); }, material);
  const Sym3<double>& s = state.stress;
  const double stress[6] = {s.xx, s.yy, s.zz, s.xy, s.xz, s.yz};
  std::copy_n(stress, 6, p.stress);
  p.internal = state.internal;
  return p;
}

Particle random_particle(std::uint64_t id, std::mt19937_64& random, double internal) {
  Particle p = particle_at({0.5, 0.5, 0.5}, id);
  testing::randomise(p, random);
  for (double& s : p.stress) s *= 0.1;
  p.internal = internal;
  return p;
}

class UpdateStress : public ::testing::TestWithParam<MaterialParameters> {};
INSTANTIATE_TEST_SUITE_P(Laws, UpdateStress, ::testing::Values(elastic_snow(), cam_clay_snow(0.8, 0.3), cam_clay_snow(0.0, 0.0)),
                         [](const auto& law) { return std::string(law.param.name()) + std::to_string(law.index); });

TEST_P(UpdateStress, GivesEveryParticleWhatTheLawGivesItAlone) {
  const AnyMaterial material = make_material(GetParam());
  const double internal = std::visit([](const auto& law) { return law.initial_internal(); }, material);
  std::mt19937_64 random(21);
  for (const int count : {1, 2, 7, 8, 9, 15, 16, 17, 31, 32, 33, 100}) {  // around groups of lanes and the 32 records of a page
    Grid grid(dx);
    std::vector<Particle> expected;
    for (int i = 0; i < count; ++i) {
      const Particle p = random_particle(static_cast<std::uint64_t>(i), random, internal);
      grid.insert(p);
      expected.push_back(updated_alone(material, p));
    }
    grid.refresh();
    EXPECT_TRUE(update_stress(grid, grid.occupied_blocks()[0], material, dt));
    const auto stored = testing::stored_particles(grid);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      // lanes and double take other series and iterate to the same root: some hundred ulp of the elastic trial stress, K |dl| = 4e5 Pa 0.05
      for (int n = 0; n < 6; ++n) EXPECT_NEAR(stored[i].stress[n], expected[i].stress[n], 1e-6) << count << ' ' << i << ' ' << n;
      EXPECT_NEAR(stored[i].internal, expected[i].internal, 1e-11);
      Particle rest = stored[i];  // nothing else changed
      std::copy_n(expected[i].stress, 6, rest.stress);
      rest.internal = expected[i].internal;
      EXPECT_TRUE(testing::same_bytes(rest, expected[i]));
    }
  }
}

TEST_P(UpdateStress, ReportsAnInvertedParticleWhereverItStands) {
  const AnyMaterial material = make_material(GetParam());
  const double internal = std::visit([](const auto& law) { return law.initial_internal(); }, material);
  std::mt19937_64 random(22);
  constexpr int count = 19;
  for (int bad = 0; bad < count; ++bad) {
    Grid grid(dx);
    for (int i = 0; i < count; ++i) {
      Particle p = random_particle(static_cast<std::uint64_t>(i), random, internal);
      if (i == bad) testing::set_affine(p, Mat3(Mat3::Identity() * (-2.0 / dt)));  // det (I + dl) = -1
      grid.insert(p);
    }
    grid.refresh();
    EXPECT_FALSE(update_stress(grid, grid.occupied_blocks()[0], material, dt)) << bad;
  }
}

TEST_P(UpdateStress, IsNotDisturbedByWhatARemovedParticleLeftBehind) {
  const AnyMaterial material = make_material(GetParam());
  Grid grid(dx);
  for (std::uint64_t i = 0; i < 3; ++i) grid.insert(particle_at({0.5, 0.5, 0.5}, i));
  Particle poison = particle_at({0.5, 0.5, 0.5}, 3);
  std::fill_n(poison.affine, 9, std::nan(""));
  std::fill_n(poison.stress, 6, HUGE_VAL);
  grid.insert(poison);
  grid.refresh();
  const auto b = grid.occupied_blocks()[0];
  grid.remove(b, 3);
  grid.refresh();
  EXPECT_TRUE(update_stress(grid, b, material, dt));
}

TEST(VolumeRatioAndEnergy, OfOneParticleAreThoseOfTheLaw) {
  // uniaxial strain e: tr eps = e, J = exp(e), psi = 1/2 (K + 4G/3) e^2
  const AnyMaterial material = make_material(elastic_snow());
  const auto& moduli = std::get<HenckyElastic>(material).moduli();
  const double e = -0.01, oedometric = moduli.bulk() + 4.0 / 3.0 * moduli.shear();
  Particle p = particle_at({0.5, 0.5, 0.5}, 0, 2e-3);
  p.stress[2] = oedometric * e;
  p.stress[0] = p.stress[1] = (moduli.bulk() - 2.0 / 3.0 * moduli.shear()) * e;
  EXPECT_NEAR(volume_ratio(material, p), std::exp(e), 1e-14);
  EXPECT_NEAR(stored_energy(material, p), 2e-3 * 0.5 * oedometric * e * e, 1e-13);  // 0.1 J, in double
}

}  // namespace
}  // namespace mpm
