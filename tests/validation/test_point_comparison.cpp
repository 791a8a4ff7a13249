#include "validation/harness/point_comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "libmpm/base/error.hpp"

namespace mpm::validation {
namespace {

using Segment = ReferenceSegment;

const std::vector<Segment> compress_and_shear{Segment::strain_increment(-0.04, 0.0), Segment::strain_increment(0.0, 0.12)};

/// A short ladder: the order is clear already at 1280 steps for these materials.
ComparisonOptions brief() {
  ComparisonOptions options;
  options.samples = 160;
  options.finest = 1280;
  return options;
}

TEST(ComparePath, FindsFirstOrderOnACoaxialPath) {
  const PathComparison c = compare_path(with_plasticity({}, 0.8, 0.3, 5.0), compress_and_shear, brief());
  EXPECT_EQ(c.steps, (std::vector{160, 320, 640, 1280}));
  EXPECT_NEAR(c.tail_order(), 1.0, 0.05);
  EXPECT_NEAR(c.mean_order(), 1.0, 0.05);
  EXPECT_FALSE(c.jumps);
  EXPECT_FALSE(c.exact());
  EXPECT_EQ(c.finest.size(), c.reference.points.size());
}

TEST(ComparePath, ComparesTheTensorWherePrincipalAxesTurn) {
  Mat3 l = Mat3::Zero();
  l(0, 2) = 0.3;
  ComparisonOptions options = brief();
  options.general = true;
  const PathComparison c = compare_path(with_plasticity({}, 0.8, 0.3, 5.0), {compress_and_shear[0], Segment::general(l)}, options);
  EXPECT_NEAR(c.tail_order(), 1.0, 0.05);
  const PathRow& end = c.finest.back();
  const Mat3& tau = c.reference.points.back().stress;
  EXPECT_GT(std::abs(tau(0, 2)), 0.2 * end.q);  // the shear stress is there, and the same
  EXPECT_NEAR(end.stress.xz, tau(0, 2), 2.0 * c.error.back() * c.scale);
}

TEST(ComparePath, IsExactOnTheHydrostaticAxis) {
  const PathComparison c = compare_path(with_plasticity({}, 0.8, 0.15, 5.0), {Segment::strain_increment(0.03, 0.0)}, brief());
  EXPECT_TRUE(c.exact());
  EXPECT_TRUE(std::isnan(c.tail_order()));
}

TEST(ComparePath, SaysThatThePathJumps) {
  const PathComparison c = compare_path(with_plasticity({}, 0.8, 0.3, 5.0), {Segment::strain_increment(0.03, 0.0)}, brief());
  EXPECT_TRUE(c.jumps);
}

TEST(ComparePath, TakesMoreStepsWhereThePathComesCloseToAFold) {
  // oedometric, M 1.2, beta 0, xi 15: margin 0.0218, (0.1/0.0218)^2 = 21, so 32 times the steps
  const PathComparison c = compare_path(with_plasticity({}, 1.2, 0.0, 15.0), {Segment::strain_increment(-0.1, 0.2 / 3.0)},
                                        ComparisonOptions{false, 160, 160, 320});
  EXPECT_NEAR(c.reference.margin, 0.0218, 1e-3);
  EXPECT_EQ(c.steps.back(), 32 * 320);
}

TEST(ComparePath, RefusesSamplesThatNoStepEndsOn) {
  ComparisonOptions options = brief();
  options.samples = 7;
  EXPECT_THROW(compare_path(with_plasticity({}, 0.8, 0.3, 5.0), compress_and_shear, options), ConfigError);
}

TEST(IsotropicError, IsRoundOffForAnyHistoryAndSeesShear) {
  const std::vector<Segment> cycle{Segment::strain_increment(-0.05, 0.0), Segment::strain_increment(0.06, 0.0),
                                   Segment::strain_increment(-0.1, 0.0)};
  for (const double beta : {0.0, 0.15, 0.45}) EXPECT_LT(isotropic_error(with_plasticity({}, 0.8, beta, 5.0), cycle, {1, 7, 160}), 1e-12);
  EXPECT_LT(isotropic_error(with_plasticity({}, 0.0, 0.3, 5.0), compress_and_shear, {1, 160}), 1e-12);  // M = 0: no shear stress
  EXPECT_GT(isotropic_error(with_plasticity({}, 0.8, 0.3, 5.0), compress_and_shear, {160}), 0.1);
}

TEST(CompareForms, AgreeWhereverThePathIsPlastic) {
  const std::vector<Segment> reload{Segment::strain_increment(-0.05, 0.05), Segment::strain_increment(0.004, -0.004),
                                    Segment::strain_increment(-0.05, 0.05)};
  const CamClay model = reference_model(with_plasticity({}, 0.8, 0.3, 5.0));
  const FormDifference d = compare_forms(model, reload, coaxial_reference(model, reload));
  EXPECT_LT(d.largest, 1e-9);
  EXPECT_GT(d.points, 200);  // most of the first and the third segment, nothing of the second
  EXPECT_LT(d.points, 320);
}

TEST(ReferenceSegments, AreThoseOfTheLibrarysPath) {
  Mat3 l = Mat3::Zero();
  l(0, 1) = 2.0;
  PathSpec path;
  path.segments = {StrainSegment{-0.1, 0.2}, TriaxialSegment{2e4, -0.2}, VelocityGradientSegment{l, 0.25}};
  const auto segments = reference_segments(path);
  ASSERT_EQ(segments.size(), 3u);
  EXPECT_EQ(segments[0].d_eps_v, -0.1);
  EXPECT_EQ(segments[0].d_eps_q, 0.2);
  EXPECT_EQ(segments[1].radial_stress, 2e4);
  EXPECT_EQ(segments[1].d_eps_axial, -0.2);
  EXPECT_EQ(segments[2].gradient(0, 1), 0.5);
  const PathSpec back = library_path(path.material, segments, 10);
  EXPECT_EQ(std::get<VelocityGradientSegment>(back.segments[2]).velocity_gradient(0, 1) *
                std::get<VelocityGradientSegment>(back.segments[2]).time,
            0.5);
}

}  // namespace
}  // namespace mpm::validation
