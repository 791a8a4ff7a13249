#include "validation/harness/shallow_flow.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/convergence.hpp"

namespace mpm::validation {
namespace {

constexpr double density = 300.0, gravity = 9.81, bulk = 4e5;

double lambert_w(double s) {
  double w = std::log1p(s);
  for (int i = 0; i < 60; ++i) w -= (w * std::exp(w) - s) / (std::exp(w) * (1.0 + w));
  return w;
}

TEST(HydrostaticColumn, OfElasticFluidHasLambertsHeightAndThrust) {
  // h = K/(rho0 g) (W + W^2/2), F = K^2/(rho0 g) (s W - s + e^W - 1), s = g mu/K, W = W(s)
  const HydrostaticColumn column(density, gravity, hencky_curve(bulk));
  for (const double mass : {10.0, 1000.0, 10000.0}) {
    const double s = gravity * mass / bulk, w = lambert_w(s);
    EXPECT_NEAR(column.height(mass), bulk / (density * gravity) * (w + 0.5 * w * w), 1e-9 * mass / density);
    EXPECT_NEAR(column.thrust(mass), bulk * bulk / (density * gravity) * (s * w - s + std::expm1(w)),
                1e-7 * gravity * mass * mass / density);
    EXPECT_NEAR(column.mass(column.height(mass)), mass, 1e-9 * mass);
  }
}

TEST(HydrostaticColumn, TaitFluidOfExponentOneHasALogarithmicHeight) {
  const HydrostaticColumn column(density, gravity, tait_curve(bulk, 1));  // J = 1/(1 + p/K)
  EXPECT_NEAR(column.height(2000.0), bulk / (density * gravity) * std::log1p(gravity * 2000.0 / bulk), 1e-9);
}

TEST(CompressionCurve, OfSnowIsElasticUpToPreconsolidationAndSofterBeyond) {
  const CompressionCurve elastic = hencky_curve(bulk), snow = snow_curve(bulk, 5.0, 1e4);
  EXPECT_DOUBLE_EQ(snow(9e3), elastic(9e3));
  EXPECT_LT(snow(2e4), elastic(2e4));
  // Kirchhoff p = J P = K sinh(xi X), X = X_0 + plastic part of x
  const double j = snow(2e4), p = j * 2e4;
  EXPECT_NEAR(-std::log(j), p / bulk + (std::asinh(p / bulk) - std::asinh(1e4 / bulk)) / 5.0, 1e-14);
}

TEST(ReflectedBore, IncompressibleLimitIsTheTextbookRelation) {
  const HydrostaticColumn column(density, gravity, hencky_curve(1e13));
  for (const double froude : {0.3, 1.0, 3.0}) {
    const double v = froude * std::sqrt(gravity * 2.0);
    const Bore bore = reflected_bore(column, 2.0 * density, v);
    const double r = bore.height / 2.0;
    EXPECT_NEAR((r - 1.0) * (r - 1.0) * (r + 1.0) / (2.0 * r), froude * froude, 1e-8 * froude * froude);
    EXPECT_NEAR(bore.speed, v / (r - 1.0), 1e-7 * bore.speed);
  }
}

TEST(ReflectedBore, BalancesMassAndMomentumOfACompressibleFluid) {
  const HydrostaticColumn column(density, gravity, snow_curve(bulk, 0.5, 1e4));
  const double mass = 2.0 * density, v = 8.0;
  const Bore bore = reflected_bore(column, mass, v);
  EXPECT_NEAR(mass * (v + bore.speed), bore.mass * bore.speed, 1e-9 * bore.mass * bore.speed);
  EXPECT_NEAR(mass * v * (v + bore.speed), bore.thrust - column.thrust(mass), 1e-8 * bore.thrust);
}

Case layer() {
  Case c;
  c.material = WeaklyCompressibleFluid::Parameters{};
  c.material.set_density(density);
  c.material.as<WeaklyCompressibleFluid>().bulk_modulus = bulk;
  c.numerics.cell_size = 0.25;
  c.numerics.gravity = gravity;
  c.bodies.push_back({BodySpec::Shape::box, Vec3(-1.0, 0.0, 0.0), Vec3(3.0, 0.25, 2.0), Vec3(-2.0, 0.0, 0.0)});
  return c;
}

TEST(StaggeredState, KeepsTheBoxAndTheMassOfEveryPlane) {
  const Case c = layer();
  const CaseScene scene = make_scene(c);
  const State plain = make_state(c, scene), staggered = staggered_state(c, scene, 2, 0);
  ASSERT_EQ(plain.grid.particle_count(), staggered.grid.particle_count());
  EXPECT_EQ(plain.next_id, staggered.next_id);
  EXPECT_EQ(plain.max_speed, staggered.max_speed);
  std::vector<Vec3> before(plain.next_id);
  plain.grid.for_each_particle([&](const Particle& p) { before[p.id] = Vec3(p.position[0], p.position[1], p.position[2]); });
  std::size_t moved = 0;
  staggered.grid.for_each_particle([&](const Particle& p) {
    EXPECT_EQ(p.position[0], before[p.id].x());
    EXPECT_EQ(p.position[1], before[p.id].y());
    EXPECT_GE(p.position[2], 0.0);
    EXPECT_LE(p.position[2], 2.0);
    moved += p.position[2] != before[p.id].z() ? 1 : 0;
  });
  EXPECT_GT(moved, plain.next_id * 9 / 10);
}

TEST(HydrostaticState, CarriesTheWeightAboveAndKeepsTheColumnsHeight) {
  const Case c = layer();
  const CaseScene scene = make_scene(c);
  const State state = hydrostatic_state(c, scene, 2, 0);
  const HydrostaticColumn column(density, gravity, tait_curve(bulk, c.material.as<WeaklyCompressibleFluid>().tait_exponent));
  double top = 0.0;
  state.grid.for_each_particle([&](const Particle& p) {
    const double pressure = -(p.stress[0] + p.stress[1] + p.stress[2]) / (3.0 * (1.0 + p.internal));
    const double mass_above = pressure / gravity;
    EXPECT_NEAR(p.position[2], column.height(2.0 * density) - column.height(mass_above), 1e-6);
    top = std::max(top, p.position[2]);
  });
  EXPECT_LT(top, column.height(2.0 * density));
}

TEST(DepthProfile, OfALayerIsItsMassPerArea) {
  const Case c = layer();
  const CaseScene scene = make_scene(c);
  const DepthProfile p = depth_profile(make_state(c, scene), density, -1.0, 3.0, 0.5, 0.25);
  for (std::size_t i = 0; i < p.mass.size(); ++i) EXPECT_NEAR(p.mass[i], 2.0 * density, 1e-9) << i;
}

TEST(LastCrossing, IsInterpolatedAndSeenFromTheFarEnd) {
  const DepthProfile p{1.0, 0.5, 1.0, {3.0, 1.0, 3.0, 1.0, 0.0}};
  EXPECT_DOUBLE_EQ(last_crossing(p, 2.0).value(), 2.25);
  EXPECT_FALSE(last_crossing(p, 4.0).has_value());
}

TEST(BatchMean, StandardErrorIsThatOfTheBatches) {
  const BatchMean m = batch_mean({1.0, 1.0, 3.0, 3.0}, 2);
  EXPECT_DOUBLE_EQ(m.mean, 2.0);
  EXPECT_DOUBLE_EQ(m.standard_error, 1.0);
  EXPECT_THROW(batch_mean({1.0}, 2), ConfigError);
}

TEST(FittedLine, OfPointsOnALineIsThisLine) {
  const Line line = fitted_line({0.0, 1.0, 3.0}, {1.0, 3.0, 7.0});
  EXPECT_NEAR(line.slope, 2.0, 1e-14);
  EXPECT_NEAR(line.at_zero, 1.0, 1e-14);
}

}  // namespace
}  // namespace mpm::validation
