#include "libmpm/driver/point_path.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "libmpm/base/error.hpp"
#include "libmpm/material/any_material.hpp"
#include "validation/harness/root.hpp"

namespace {

using namespace mpm;

PathSpec cam_clay_path(double slope, double beta, double xi, int steps, std::vector<PathSegment> segments) {
  PathSpec path;
  path.material.as<CamClay>().critical_state_slope = slope;
  path.material.as<CamClay>().cohesion_beta = beta;
  path.material.as<CamClay>().hardening_xi = xi;
  path.steps_per_segment = steps;
  path.segments = std::move(segments);
  return path;
}

TEST(PointPath, FirstRowIsTheReferenceState) {
  const auto rows = follow_path(cam_clay_path(0.8, 0.3, 5.0, 3, {StrainSegment{-0.012, 0.0}, StrainSegment{0.0, 0.05}}));
  ASSERT_EQ(rows.size(), 7u);
  const CamClay law(CamClay::Parameters{});
  EXPECT_EQ(rows[0].step, 0);
  EXPECT_EQ(rows[0].eps_v_plastic, -law.initial_internal());
  EXPECT_NEAR(rows[0].preconsolidation_pressure, 1e4, 1e4 * 1e-14);  // sinh(asinh(x)) to round-off
  EXPECT_EQ(rows[0].p, 0.0);
  EXPECT_EQ(rows[0].eps_q, 0.0);
  EXPECT_EQ(rows[6].step, 6);
  EXPECT_NEAR(rows[6].eps_v, -0.012, 1e-15);  // sum of logarithms of exact exponentials, about 10 ulp of the strain
  EXPECT_NEAR(rows[6].eps_q, 0.05, 1e-15);
}

TEST(PointPath, IsotropicCompressionIsExactForAnyNumberOfSteps) {
  // sinh(xi X) + X = e + X_0, p = p_c = K sinh(xi X)
  for (const double beta : {0.0, 0.3})
    for (const double slope : {0.0, 0.4, 1.2})
      for (const double xi : {0.05, 0.5, 5.0, 15.0})
        for (const int steps : {1, 7, 160}) {
          const double e = 0.08;
          const auto path = cam_clay_path(slope, beta, xi, steps, {StrainSegment{-e, 0.0}});
          const CamClay law(path.material.as<CamClay>());
          const double target = e + law.initial_internal();
          const double x = validation::root_between([&](double trial) { return std::sinh(xi * trial) + trial - target; }, 0.0, target);
          const auto last = follow_path(path).back();
          const double p = law.moduli().bulk() * std::sinh(xi * x);
          EXPECT_NEAR(last.p, p, 1e-12 * p) << "M " << slope << " beta " << beta << " xi " << xi << " steps " << steps;
          EXPECT_NEAR(last.preconsolidation_pressure, p, 1e-12 * p);
          EXPECT_NEAR(-last.eps_v_plastic, x, 1e-12 * x);
        }
}

TEST(PointPath, IsochoricShearEndsInTheCriticalState) {
  // (1 - beta)/2 sinh(xi X) + X = e + X_0, p = (1 - beta) p_c/2, q = M' p
  for (const double beta : {0.0, 0.15, 0.45})
    for (const double xi : {0.5, 5.0}) {
      const double slope = 0.8, e = 0.03;
      const auto path = cam_clay_path(slope, beta, xi, 200, {StrainSegment{-e, 0.0}, StrainSegment{0.0, 4.0}});
      const CamClay law(path.material.as<CamClay>());
      const double target = e + law.initial_internal();
      const double x =
          validation::root_between([&](double trial) { return 0.5 * (1.0 - beta) * std::sinh(xi * trial) + trial - target; }, 0.0, target);
      const auto last = follow_path(path).back();
      // The approach is exponential: by a shear strain of 4 the rest is far below 1e-10.
      const double p_c = law.preconsolidation_pressure(x), p = 0.5 * (1.0 - beta) * p_c;
      EXPECT_NEAR(last.preconsolidation_pressure, p_c, 1e-10 * p_c) << beta << " " << xi;
      EXPECT_NEAR(last.p, p, 1e-10 * p) << beta << " " << xi;
      EXPECT_NEAR(last.q, path.material.as<CamClay>().critical_state_ratio() * p, 1e-10 * p) << beta << " " << xi;
    }
}

TEST(PointPath, DrainedTriaxialTestEndsInTheCriticalState) {
  // Constant radial stress p_i: q = +-(p - p_i) 3, with q = M' p: p_f = 3 p_i/(3 - M') in compression, 3 p_i/(3 + M') in extension.
  const double p_i = 2e4;
  for (const double axial : {-3.0, 3.0}) {
    const auto path =
        cam_clay_path(0.8, 0.15, 5.0, 400, {StrainSegment{-0.05, 0.0}, TriaxialSegment{p_i, 0.0}, TriaxialSegment{p_i, axial}});
    const CamClay law(path.material.as<CamClay>());
    const double ratio = path.material.as<CamClay>().critical_state_ratio(), p_f = 3.0 * p_i / (axial < 0.0 ? 3.0 - ratio : 3.0 + ratio);
    const auto rows = follow_path(path);
    const auto& last = rows.back();
    // What remains of the exponential approach after an axial strain of 3 is seen between the last steps: below 1e-8.
    EXPECT_NEAR(last.p, p_f, 1e-7 * p_f);
    EXPECT_NEAR(last.q, ratio * last.p, 1e-7 * p_f);
    // The radial stress is held: q = 3 |p - p_i|.
    for (std::size_t i = 401; i < rows.size(); ++i) EXPECT_NEAR(rows[i].q, 3.0 * std::fabs(rows[i].p - p_i), 1e-8 * p_i);
  }
}

TEST(PointPath, YieldsInPureShearWhereTheCohesiveSurfaceCrossesZeroPressure) {
  // q = M p_c sqrt(beta/(1 + 2 beta)) at p = 0
  const double slope = 0.8, beta = 0.3;
  const auto rows = follow_path(cam_clay_path(slope, beta, 5.0, 20000, {StrainSegment{0.0, 0.02}}));
  const double expected = slope * 1e4 * std::sqrt(beta / (1.0 + 2.0 * beta));
  std::size_t first = 1;
  while (first < rows.size() && rows[first].eps_v_plastic == rows[0].eps_v_plastic) ++first;
  ASSERT_LT(first, rows.size());
  const double step = rows[1].q;  // elastic increment: what one step can miss by
  EXPECT_LE(rows[first - 1].q, expected);
  EXPECT_GE(rows[first - 1].q, expected - step);
}

TEST(PointPath, SimpleShearOfAHenckySolidMatchesTheExactSolution) {
  std::ifstream file(MPM_SOURCE_DIR "/reference_data/hencky_simple_shear/data.csv");
  ASSERT_TRUE(file);
  std::string line;
  std::getline(file, line), std::getline(file, line);
  int read = 0;
  double gamma = 0.0, tau12 = 0.0, tau11 = 0.0, tau22 = 0.0, q = 0.0;
  while (std::getline(file, line) && std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &gamma, &tau12, &tau11, &tau22, &q) == 5) {
    ++read;
    PathSpec path;
    path.material = HenckyElastic::Parameters{};
    path.steps_per_segment = 50;
    VelocityGradientSegment shear;
    shear.velocity_gradient(0, 1) = gamma;
    path.segments = {shear};
    const auto last = follow_path(path).back();
    // The table has 12 digits; 50 steps add a few 1e-15 of the strain each.
    EXPECT_NEAR(last.q, 1e3 * q, 2e-12 * 1e3 * q + 1e-9) << gamma;
    EXPECT_NEAR(last.p, 0.0, 1e-12 * 1e3 * q + 1e-9) << gamma;
    EXPECT_NEAR(last.eps_v, 0.0, 1e-14);
  }
  EXPECT_EQ(read, 7);
}

TEST(PointPath, BackwardEulerConvergesAtFirstOrder) {
  // Non-proportional loading: compression, then shear with some compaction. Error against Richardson's extrapolation from the finest pair.
  const auto end = [](int steps) {
    const auto row = follow_path(cam_clay_path(0.8, 0.3, 5.0, steps, {StrainSegment{-0.02, 0.005}, StrainSegment{-0.004, 0.03}})).back();
    return std::array{row.p, row.q, row.preconsolidation_pressure};
  };
  const auto n80 = end(80), n160 = end(160), n320 = end(320);
  for (int i = 0; i < 3; ++i) {
    const double order = std::log2((n160[i] - n80[i]) / (n320[i] - n160[i]));
    EXPECT_GT(order, 0.9) << i;  // backward Euler; 0.98 to 1.15 is usual between 80 and 160 steps
    EXPECT_LT(order, 1.15) << i;
  }
}

TEST(PointPath, StrideKeepsEveryFewRowsAndChangesNothing) {
  const auto path = cam_clay_path(0.8, 0.3, 5.0, 12, {StrainSegment{-0.04, 0.0}, StrainSegment{0.0, 0.05}});
  const auto all = follow_path(path), some = follow_path(path, 4);
  ASSERT_EQ(some.size(), 7u);
  for (std::size_t i = 0; i < some.size(); ++i) {
    EXPECT_EQ(some[i].step, static_cast<int>(4 * i));
    EXPECT_EQ(some[i].p, all[4 * i].p);
    EXPECT_EQ(some[i].stress.zz, all[4 * i].stress.zz);
  }
  EXPECT_NEAR(some[6].stress.xx - some[6].stress.zz, some[6].q, 1e-12 * some[6].q);  // the axis z carries the larger pressure
  EXPECT_THROW(follow_path(path, 5), ConfigError);
  EXPECT_THROW(follow_path(path, 0), ConfigError);
}

TEST(PointPath, RefusesNonsense) {
  PathSpec path = cam_clay_path(0.8, 0.3, 5.0, 0, {StrainSegment{-0.01, 0.0}});
  EXPECT_THROW(follow_path(path), ConfigError);
  path.steps_per_segment = 10;
  path.segments = {VelocityGradientSegment{Mat3::Zero(), 0.0}};
  EXPECT_THROW(follow_path(path), ConfigError);
  path.segments = {};
  EXPECT_THROW(follow_path(path), ConfigError);
  path.segments = {TriaxialSegment{-1e9, -0.01}};  // a tension no cam clay can carry
  EXPECT_THROW(follow_path(path), UnstableError);
}

}  // namespace
