#include "libmpm/material/weakly_compressible_fluid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "libmpm/base/error.hpp"

namespace {

using namespace mpm;

WeaklyCompressibleFluid::Parameters fluid(int exponent, bool tension = false, double viscosity = 0.0) {
  WeaklyCompressibleFluid::Parameters spec;
  spec.density = 1000.0;
  spec.bulk_modulus = 4e5;
  spec.tait_exponent = exponent;
  spec.viscosity = viscosity;
  spec.carries_tension = tension;
  return spec;
}

Matrix3<double> stretch(double x) { return {{{x, 0.0, 0.0}, {0.0, x, 0.0}, {0.0, 0.0, x}}}; }

TEST(WeaklyCompressibleFluid, PressureIsThatOfTait) {
  for (const int n : {1, 2, 3, 7, 20}) {
    const WeaklyCompressibleFluid law(fluid(n));
    for (const double compression : {1e-12, 1e-6, 1e-3, 0.1, 0.4}) {
      MaterialState<double> s{};
      const double d = std::expm1(std::log1p(-compression) / 3.0);  // J = 1 - compression
      law.update_stress(s, stretch(d), 1e-3);
      const double j = 1.0 - compression, p = 4e5 / n * std::expm1(-n * std::log1p(-compression));
      // full relative precision, also where J - 1 is 1e-12: a few ulp a multiply-add, and those of d
      EXPECT_NEAR(-trace(s.stress) / 3.0, j * p, 3e-15 * (n + 1) * j * p) << n << " " << compression;
      EXPECT_EQ(s.stress.xx, s.stress.zz);
      EXPECT_EQ(s.stress.xy, 0.0);
      EXPECT_NEAR(law.volume_ratio(s), j, 1e-15);
    }
  }
}

TEST(WeaklyCompressibleFluid, VolumeFollowsTheDeterminantOverManySteps) {
  const WeaklyCompressibleFluid law(fluid(7, true));
  MaterialState<double> s{};
  for (int i = 0; i < 10000; ++i) law.update_stress(s, stretch(-1e-7), 1e-3);
  EXPECT_NEAR(s.internal, std::expm1(30000.0 * std::log1p(-1e-7)), 1e-15);  // round-off of 10^4 sums of 3e-7: below an ulp of 3e-3 each
}

TEST(WeaklyCompressibleFluid, StressIsTheDerivativeOfTheStoredEnergy) {
  // tau_m = J d psi/dJ, by central differences: truncation 1e-10 relative at a step of 1e-5 in J, round-off likewise
  for (const int n : {1, 2, 3, 7, 15})
    for (const double j : {-0.3, -0.05, -0.008, -1e-4, 0.02, 0.3}) {
      const WeaklyCompressibleFluid law(fluid(n, true));
      const double h = 1e-4 * std::fabs(j);
      const auto energy = [&](double x) { return law.stored_energy({{}, x}); };
      // Richardson's step on two central differences
      const double wide = (energy(j + 2.0 * h) - energy(j - 2.0 * h)) / (4.0 * h), near = (energy(j + h) - energy(j - h)) / (2.0 * h);
      const double p = law.pressure(j);
      EXPECT_NEAR(-(4.0 * near - wide) / 3.0, p, 2e-10 * std::fabs(p)) << n << " " << j;
      EXPECT_GT(energy(j), 0.0);
    }
}

TEST(WeaklyCompressibleFluid, EnergyKeepsItsPrecisionAtSmallStrain) {
  // psi -> K/2 (J - 1)^2
  for (const int n : {1, 2, 7}) {
    const WeaklyCompressibleFluid law(fluid(n, true));
    EXPECT_NEAR(law.stored_energy({{}, -1e-9}), 0.5 * 4e5 * 1e-18, 1e-7 * 0.5 * 4e5 * 1e-18) << n;  // next order: (n + 1)/3 (J - 1)
  }
}

TEST(WeaklyCompressibleFluid, TearsUnlessToldOtherwise) {
  const WeaklyCompressibleFluid tears(fluid(7)), pulls(fluid(7, true));
  MaterialState<double> a{}, b{};
  tears.update_stress(a, stretch(0.01), 1e-3);
  pulls.update_stress(b, stretch(0.01), 1e-3);
  EXPECT_EQ(norm2(a.stress), 0.0);
  EXPECT_EQ(tears.stored_energy(a), 0.0);
  EXPECT_GT(trace(b.stress), 0.0);
  EXPECT_EQ(a.internal, b.internal);
  tears.update_stress(a, stretch(1.0 / 1.01 - 1.0), 1e-3);  // closed again: J = 1
  EXPECT_NEAR(trace(a.stress), 0.0, 1e-9);
  tears.update_stress(a, stretch(-0.001), 1e-3);
  EXPECT_LT(trace(a.stress), 0.0);
}

/// A drop of spray may fly for any time.
TEST(WeaklyCompressibleFluid, SprayThatExpandsForeverStaysFinite) {
  const WeaklyCompressibleFluid law(fluid(7));
  MaterialState<double> s{};
  for (int i = 0; i < 2000; ++i) {  // J would be 2.2^2000
    law.update_stress(s, stretch(0.3), 1e-3);
    ASSERT_TRUE(std::isfinite(s.internal)) << i;
    ASSERT_EQ(norm2(s.stress), 0.0) << i;
  }
  for (int i = 0; i < 200 && s.internal > 0.0; ++i) law.update_stress(s, stretch(-0.03), 1e-3);
  EXPECT_LT(trace(s.stress), 0.0);  // compressed enough it carries pressure again
  law.update_stress(s, stretch(std::numeric_limits<double>::infinity()), 1e-3);
  EXPECT_TRUE(std::isnan(s.internal));  // a deformation that is not finite is still seen
}

/// The limit of the time step is that of the fluid without void.
TEST(WeaklyCompressibleFluid, VoidsAddNoViscousStress) {
  const double eta = 3.0, dt = 1e-3, gamma = 1e-6;
  const Matrix3<double> shear{{{0.0, 0.0, gamma}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}};
  MaterialState<double> torn{{}, 999.0}, stretched{{}, 0.5};
  WeaklyCompressibleFluid(fluid(7, false, eta)).update_stress(torn, shear, dt);
  EXPECT_NEAR(torn.stress.xz, eta * gamma / dt, 1e-12);
  WeaklyCompressibleFluid(fluid(7, true, eta)).update_stress(stretched, shear, dt);  // whole, so all of its volume is fluid
  EXPECT_NEAR(stretched.stress.xz, 1.5 * eta * gamma / dt, 1e-12);
}

TEST(WeaklyCompressibleFluid, ViscousStressIsNewtons) {
  // simple shear: tau_xz = eta gamma'; a rotation: none; an isotropic compression: none
  const double eta = 3.0, dt = 1e-3;
  const WeaklyCompressibleFluid law(fluid(7, false, eta));
  MaterialState<double> s{};
  const double gamma = 1e-6;
  law.update_stress(s, {{{0.0, 0.0, gamma}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}}, dt);
  EXPECT_NEAR(s.stress.xz, eta * gamma / dt, 1e-12);
  EXPECT_NEAR(s.stress.xx, 0.0, eta * gamma * gamma / dt);  // second order in the step
  MaterialState<double> turned{};
  const double c = std::cos(0.3) - 1.0, sn = std::sin(0.3);
  law.update_stress(turned, {{{c, -sn, 0.0}, {sn, c, 0.0}, {0.0, 0.0, 0.0}}}, dt);
  EXPECT_NEAR(std::sqrt(norm2(deviator(turned.stress))), 0.0, 1e-16 * eta / dt * 10.0);
  MaterialState<double> squeezed{};
  law.update_stress(squeezed, stretch(-1e-3), dt);
  EXPECT_NEAR(std::sqrt(norm2(deviator(squeezed.stress))), 0.0, 1e-9);
}

/// All numbers that a law may be computed with in double precision.
template <class T>
class WeaklyCompressibleFluidLanes : public testing::Test {};
using LaneNumbers = testing::Types<Lanes, LanePair, HalfPair>;
TYPED_TEST_SUITE(WeaklyCompressibleFluidLanes, LaneNumbers);

TYPED_TEST(WeaklyCompressibleFluidLanes, GiveTheSameAsAlone) {
  const WeaklyCompressibleFluid law(fluid(7, false, 2.0));
  std::mt19937_64 generator{3};
  std::uniform_real_distribution<double> uniform{-0.01, 0.01};
  MaterialState<TypeParam> lanes{};
  MaterialState<double> alone[lanes_of<TypeParam>]{};
  for (int step = 0; step < 100; ++step) {
    Matrix3<TypeParam> dl{};
    for (int i = 0; i < lanes_of<TypeParam>; ++i) {
      Matrix3<double> one{};
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) set_lane(dl.m[a][b], i, one.m[a][b] = uniform(generator));
      law.update_stress(alone[i], one, 1e-4);
    }
    law.update_stress(lanes, dl, 1e-4);
    for (int i = 0; i < lanes_of<TypeParam>; ++i) {
      ASSERT_NEAR(lane(lanes.stress.xx, i), alone[i].stress.xx, 1e-9);  // of stresses up to 4e4 Pa
      ASSERT_NEAR(lane(lanes.stress.yz, i), alone[i].stress.yz, 1e-9);
      ASSERT_NEAR(lane(lanes.internal, i), alone[i].internal, 1e-14);
    }
  }
}

TEST(WeaklyCompressibleFluid, AnInvertedPointIsSeen) {
  const WeaklyCompressibleFluid law(fluid(7));
  MaterialState<double> s{};
  law.update_stress(s, stretch(-1.5), 1e-3);
  EXPECT_TRUE(std::isnan(s.internal));
}

TEST(WeaklyCompressibleFluid, WaveSpeedIsThatOfSoundAtRest) { EXPECT_DOUBLE_EQ(WeaklyCompressibleFluid(fluid(7)).wave_speed(), 20.0); }

TEST(WeaklyCompressibleFluid, RefusesNonsense) {
  for (const auto& change : {+[](WeaklyCompressibleFluid::Parameters& s) { s.bulk_modulus = 0.0; },
                             +[](WeaklyCompressibleFluid::Parameters& s) { s.bulk_modulus = std::nan(""); },
                             +[](WeaklyCompressibleFluid::Parameters& s) { s.tait_exponent = 0; },
                             +[](WeaklyCompressibleFluid::Parameters& s) { s.viscosity = -1.0; },
                             +[](WeaklyCompressibleFluid::Parameters& s) { s.density = 0.0; }}) {
    WeaklyCompressibleFluid::Parameters spec = fluid(7);
    change(spec);
    EXPECT_THROW(WeaklyCompressibleFluid{spec}, ConfigError);
  }
}

}  // namespace
