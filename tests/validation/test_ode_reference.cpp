#include "validation/harness/ode_reference.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "libmpm/base/error.hpp"
#include "validation/harness/sundials.hpp"

namespace mpm::validation {
namespace {

using Segment = ReferenceSegment;

/// The paper's snow: E = 1 MPa, nu = 0.1, p_c0 = 10 kPa.
CamClay snow(double m, double beta, double xi) { return CamClay::from_young(1.0e6, 0.1, m, beta, xi, 1.0e4); }

const double shares[] = {0.0, 0.15, 0.3};

TEST(OdeIntegrator, StopsAtARootToTheTolerance) {
  OdeIntegrator ode(
      2,
      [](double, const double* y, double* d) {
        d[0] = y[1];
        d[1] = -y[0];
      },
      1e-13, 1e-16);
  ode.start(0.0, std::array{0.0, 1.0}, 10.0, [](double, const double* y, double* g) { g[0] = y[0] - 0.5; }, {-1});
  const auto stop = ode.advance(10.0);
  EXPECT_EQ(stop.root, 0);
  EXPECT_NEAR(stop.time, 5.0 * M_PI / 6.0, 1e-10);  // the falling crossing, not the rising one at pi/6
}

TEST(OdeIntegrator, HandsOnWhatTheRatesThrow) {
  OdeIntegrator ode(
      1, [](double, const double*, double*) { throw ConfigError("from inside"); }, 1e-8, 1e-8);
  ode.start(0.0, std::array{0.0}, 1.0, {}, {});
  EXPECT_THROW(ode.advance(1.0), ConfigError);
}

TEST(DaeIntegrator, SolvesAnIndexOneSystem) {
  // y' = -z, z = y: exponential decay
  const auto states = integrate_dae(
      [](double, const double* y, const double* d, double* r) {
        r[0] = d[0] + y[1];
        r[1] = y[0] - y[1];
      },
      [](double, double c, const double*, const double*, double* rows) {
        rows[0] = c, rows[1] = 1.0;
        rows[2] = 1.0, rows[3] = -1.0;
      },
      0.0, {1.0, 1.0}, {-1.0, -1.0}, std::array{0.5, 1.0}, 1e-11, 1e-14);
  EXPECT_NEAR(states[1][0], std::exp(-1.0), 1e-9);  // BDF of order 5 near its tolerance: two decades of accumulation
}

TEST(CoaxialReference, IsotropicCompressionIsTheClosedForm) {
  for (const double xi : {0.05, 0.5, 5.0, 15.0})
    for (const double beta : shares) {
      const CamClay m = snow(0.8, beta, xi);
      const auto path = coaxial_reference(m, {Segment::strain_increment(-0.1, 0.0)});
      const auto& end = path.points.back();
      const double x = exact::isotropic_compression(m, 0.1);
      EXPECT_NEAR(end.internal / x, 1.0, 1e-10);
      EXPECT_NEAR(end.p / m.preconsolidation(x), 1.0, 1e-10);
      EXPECT_EQ(end.q, 0.0);
      ASSERT_EQ(path.events.size(), 1u);
      // onset at p = p_c0, that is e = p_c0/K of the 0.1
      EXPECT_NEAR(path.events[0].time, 1.0e4 / m.bulk_modulus / 0.1, 1e-10);
      EXPECT_LT(path.drift, 1e-9);
    }
}

TEST(CoaxialReference, EndlessIsochoricShearReachesTheCriticalState) {
  for (const double m_slope : {0.4, 0.8, 1.2})
    for (const double beta : shares) {
      const CamClay m = snow(m_slope, beta, 5.0);
      const auto path = coaxial_reference(m, {Segment::strain_increment(-0.02, 0.0), Segment::strain_increment(0.0, 3.0)});
      const auto& end = path.points.back();
      const double x = exact::isochoric_critical_state(m, 0.02), pc = m.preconsolidation(x);
      EXPECT_NEAR(end.internal / x, 1.0, 1e-10) << m_slope << ' ' << beta;
      EXPECT_NEAR(end.p / (0.5 * (1.0 - beta) * pc), 1.0, 1e-9);
      EXPECT_NEAR(end.q / end.p, exact::critical_ratio(m), 1e-9);
      EXPECT_LT(path.drift, 1e-9);
    }
}

TEST(CoaxialReference, DrainedTriaxialReachesItsCriticalStateInCompressionAndExtension) {
  // M' < 1.5, else extension has no critical state at positive axial stress
  const CamClay m = snow(0.8, 0.15, 5.0);
  const double ratio = exact::critical_ratio(m);
  const auto isotropic = Segment::strain_increment(-0.02, 0.0);
  const double pi = coaxial_reference(m, {isotropic}).points.back().p;
  for (const double axial : {-4.0, 4.0}) {
    const auto path = coaxial_reference(m, {isotropic, Segment::drained(pi, axial)});
    const auto& end = path.points.back();
    EXPECT_NEAR(end.p, axial < 0 ? 3.0 * pi / (3.0 - ratio) : 3.0 * pi / (3.0 + ratio), 1e-6 * pi);  // approached exponentially
    EXPECT_NEAR(end.p - end.q_signed / 3.0, pi, 1e-9 * pi);                                          // the radial stress is held
    EXPECT_EQ(end.q_signed > 0, axial < 0);
    EXPECT_LT(path.drift, 1e-9);
  }
}

TEST(CoaxialReference, UnloadsElasticallyAndReloadsToTheSameSurface) {
  const CamClay m = snow(0.8, 0.3, 5.0);
  const auto path = coaxial_reference(
      m, {Segment::strain_increment(-0.05, 0.02), Segment::strain_increment(0.01, -0.005), Segment::strain_increment(-0.01, 0.005)});
  const auto n = ReferenceOptions{}.samples_per_segment;
  const auto &a = path.points[n], &b = path.points[2 * n], &c = path.points[3 * n];
  EXPECT_NEAR(b.p - a.p, -m.bulk_modulus * 0.01, 1e-9 * a.p);
  EXPECT_NEAR(b.q_signed - a.q_signed, -3.0 * m.shear_modulus * 0.005, 1e-9 * a.p);
  EXPECT_NEAR(c.p, a.p, 1e-8 * a.p);
  EXPECT_NEAR(c.internal, a.internal, 1e-8 * a.internal);
}

TEST(CoaxialReference, HydrostaticTensionSoftensToTheApexSolution) {
  const CamClay m = snow(0.8, 0.15, 5.0);  // beta xi < 1 and p_c0 small: no snap-back
  const auto path = coaxial_reference(m, {Segment::strain_increment(0.004, 0.0)});
  const auto& end = path.points.back();
  const double x = exact::tension_apex(m, -0.004, m.initial_internal());
  ASSERT_GT(x, 0.0);
  EXPECT_NEAR(end.internal / x, 1.0, 1e-9);
  EXPECT_NEAR(end.p / (-0.15 * m.preconsolidation(x)), 1.0, 1e-9);
}

TEST(CoaxialReference, TensionExhaustsTheStrengthAndRecompactionRestoresIt) {
  const CamClay m = snow(0.8, 0.1, 5.0);
  const auto path = coaxial_reference(m, {Segment::strain_increment(0.05, 0.0), Segment::strain_increment(-0.15, 0.0)});
  ASSERT_EQ(path.events.size(), 3u);
  EXPECT_EQ(path.events[0].event, PathEvent::onset);
  EXPECT_EQ(path.events[1].event, PathEvent::exhaustion);
  EXPECT_EQ(path.events[2].event, PathEvent::recompaction);
  const auto& loose = path.points[ReferenceOptions{}.samples_per_segment];
  EXPECT_EQ(loose.p, 0.0);
  EXPECT_NEAR(loose.internal, m.initial_internal() - 0.05, 1e-12);
  const double x = exact::isotropic_compression(m, 0.1);
  EXPECT_NEAR(path.points.back().internal / x, 1.0, 1e-9);
  EXPECT_NEAR(path.points.back().p / m.preconsolidation(x), 1.0, 1e-9);
}

TEST(CoaxialReference, RecompactionWithShearStaysOnTheSurfaceFromTheFirstPointOn) {
  const CamClay m = snow(0.8, 0.1, 5.0);
  const auto path = coaxial_reference(m, {Segment::strain_increment(0.05, 0.0), Segment::strain_increment(-0.1, 0.06)});
  EXPECT_LT(path.drift, 1e-9);
  EXPECT_GT(path.points.back().q, 0.1 * path.points.back().p);
}

TEST(CoaxialReference, SnapBackAtTheTensionApexLandsOnTheStableRoot) {
  const CamClay m = snow(0.8, 0.3, 5.0);  // beta xi = 1.5: all strength is lost at once
  const auto path = coaxial_reference(m, {Segment::strain_increment(0.02, 0.0)});
  ASSERT_EQ(path.events.size(), 2u);
  EXPECT_EQ(path.events[1].event, PathEvent::snap_back);
  EXPECT_EQ(path.points.back().p, 0.0);
  EXPECT_NEAR(path.points.back().internal, m.initial_internal() - 0.02, 1e-12);

  // beta xi < 1, but p_c0 = 1.5 K: the apex is on the falling part of X - beta sinh(xi X), and some strength survives
  const CamClay strong = CamClay::from_young(1e6, 0.1, 0.8, 0.15, 5.0, 6.25e5);
  const auto second = coaxial_reference(strong, {Segment::strain_increment(0.23, 0.0)});
  ASSERT_GE(second.events.size(), 2u);
  EXPECT_EQ(second.events[1].event, PathEvent::snap_back);
  const double e = -0.23 * second.events[1].time;
  EXPECT_GT(second.events[1].internal_after, 0.0);
  EXPECT_NEAR(second.events[1].internal_after, exact::tension_apex(strong, e, second.events[1].internal_before), 1e-10);
  const double x = exact::tension_apex(strong, -0.23, second.events[1].internal_after);
  EXPECT_NEAR(second.points.back().internal, x, 1e-9);
}

TEST(GeneralReference, YieldsAgainWithinTheFirstInstantOfAReversal) {
  // At the start of the last two segments the point unloads for 1e-7 of the segment only, from a round-off above the surface.
  for (const double beta : {0.0, 0.45}) {
    const auto shear = [](int i, double gamma) {
      Mat3 l = Mat3::Zero();
      l(i, 2) = gamma;
      return Segment::general(l);
    };
    const CamClay m = snow(0.8, beta, 0.05);
    const auto path = general_reference(
        m, {Segment::strain_increment(-0.04, 0.0), shear(0, 0.1), shear(1, 0.1), shear(0, -0.1), shear(1, -0.1)}, {1e-13, 640});
    EXPECT_TRUE(path.points.back().plastic);
    for (const ReferencePoint& r : path.points) ASSERT_LE(m.yield(r.p, r.q, r.internal), 1e-9 * r.preconsolidation * r.preconsolidation);
  }
}

TEST(GeneralReference, AgreesWithTheCoaxialFormOnFixedPrincipalAxes) {
  const CamClay m = snow(0.8, 0.3, 5.0);
  const std::vector<Segment> path{Segment::strain_increment(-0.02, 0.0), Segment::strain_increment(0.0, 0.08),
                                  Segment::strain_increment(-0.03, -0.05)};
  const auto a = coaxial_reference(m, path), b = general_reference(m, path);
  const double scale = a.points.back().preconsolidation;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    ASSERT_NEAR(a.points[i].p, b.points[i].p, 1e-8 * scale) << i;
    ASSERT_NEAR(a.points[i].q, b.points[i].q, 1e-8 * scale) << i;
    ASSERT_NEAR(a.points[i].internal, b.points[i].internal, 1e-9) << i;
    ASSERT_LT((a.points[i].stress - b.points[i].stress).norm(), 1e-8 * scale) << i;
  }
  EXPECT_LT(b.drift, 1e-9);
}

TEST(GeneralReference, DoesNotDependOnTheFrame) {
  const CamClay m = snow(0.4, 0.15, 5.0);
  Mat3 l;
  l << -0.02, 0.10, 0.03, -0.04, 0.01, 0.0, 0.05, 0.02, -0.03;
  const Mat3 r = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const auto a = general_reference(m, {Segment::general(l)}), b = general_reference(m, {Segment::general(Mat3(r * l * r.transpose()))});
  EXPECT_NEAR(a.points.back().p, b.points.back().p, 1e-8 * a.points.back().preconsolidation);
  EXPECT_NEAR(a.points.back().q, b.points.back().q, 1e-8 * a.points.back().preconsolidation);
}

TEST(GeneralReference, RigidRotationChangesNothing) {
  const CamClay m = snow(0.8, 0.3, 5.0);
  Mat3 spin = Mat3::Zero();
  spin(0, 1) = -2.0;
  spin(1, 0) = 2.0;
  const auto path = general_reference(m, {Segment::strain_increment(-0.002, 0.002), Segment::general(spin)});
  const auto n = ReferenceOptions{}.samples_per_segment;
  EXPECT_NEAR(path.points.back().p, path.points[n].p, 1e-10 * m.preconsolidation_pressure);
  EXPECT_NEAR(path.points.back().q, path.points[n].q, 1e-10 * m.preconsolidation_pressure);
}

TEST(GeneralReference, ElasticSimpleShearIsTheClosedForm) {
  // Hencky: S = asinh(gamma/2)/sqrt(1 + gamma^2/4), tau12 = 2 G S, tau11 = -tau22 = G gamma S, hence q = sqrt(3) G S sqrt(gamma^2 + 4)
  const CamClay m = CamClay::from_young(1e6, 0.1, 1.2, 0.3, 5.0, 1e9);  // so strong that it stays elastic
  Mat3 l = Mat3::Zero();
  const double gamma = 0.8;
  l(0, 1) = gamma;
  const auto path = general_reference(m, {Segment::general(l)});
  const double s = std::asinh(gamma / 2) / std::sqrt(1 + gamma * gamma / 4);
  EXPECT_NEAR(path.points.back().q, std::sqrt(3.0) * m.shear_modulus * s * std::sqrt(gamma * gamma + 4.0), 1e-10 * m.shear_modulus);
  EXPECT_NEAR(path.points.back().p, 0.0, 1e-10 * m.bulk_modulus);
}

TEST(GeneralReference, PlasticSimpleShearReachesTheCriticalRatioWithoutDrift) {
  const CamClay m = snow(0.8, 0.15, 5.0);
  Mat3 l = Mat3::Zero();
  l(0, 2) = 4.0;
  const auto path = general_reference(m, {Segment::strain_increment(-0.02, 0.0), Segment::general(l)});
  EXPECT_NEAR(path.points.back().q / path.points.back().p, exact::critical_ratio(m), 1e-6);  // approached exponentially
  EXPECT_LT(path.drift, 1e-9);
}

TEST(DaeReference, AgreesWithTheRateFormTo1em8) {
  for (const double beta : shares) {
    const CamClay m = snow(0.8, beta, 5.0);
    const auto cvode = coaxial_reference(m, {Segment::strain_increment(-0.03, 0.0), Segment::strain_increment(-0.02, 0.10)});
    const auto n = ReferenceOptions{}.samples_per_segment;
    const auto ida = dae_reference(m, cvode.points[n], -0.02, 0.10, n);
    for (std::size_t i = 0; i < n; ++i) {
      const auto &a = cvode.points[n + 1 + i], &b = ida[i];
      ASSERT_NEAR(a.p, b.p, 1e-8 * a.preconsolidation);
      ASSERT_NEAR(a.q, b.q, 1e-8 * a.preconsolidation);
      ASSERT_NEAR(a.internal, b.internal, 1e-8 * a.internal);
    }
  }
}

TEST(DaeReference, StartsFromAPointThatIsOffTheSurfaceByRoundOff) {
  const CamClay m = snow(0.8, 0.3, 5.0);
  const auto cvode = coaxial_reference(m, {Segment::strain_increment(-0.03, 0.0), Segment::strain_increment(-0.02, 0.10)});
  const auto n = ReferenceOptions{}.samples_per_segment;
  ReferencePoint start = cvode.points[n + n / 2];
  start.q *= 1.0 + 1e-11, start.q_signed *= 1.0 + 1e-11;
  const auto ida = dae_reference(m, start, -0.01, 0.05, 10);
  EXPECT_NEAR(ida.back().p, cvode.points.back().p, 1e-8 * cvode.points.back().p);
}

TEST(NearestLanding, LiesOnTheSurfaceOrLosesAllStress) {
  const CamClay m = snow(0.8, 0.15, 1.5);
  const double x = m.initial_internal(), pc = m.preconsolidation_pressure;
  const Landing kept = nearest_landing(m, -0.16 * pc, 0.1 * pc, x);
  EXPECT_GT(kept.internal, 0.0);
  EXPECT_LT(kept.internal, x);
  EXPECT_NEAR(m.yield(kept.p, kept.q, kept.internal), 0.0, 1e-12 * pc * pc);
  EXPECT_NEAR(kept.p, -0.16 * pc - m.bulk_modulus * (kept.internal - x), 1e-10 * pc);
  const CamClay brittle = snow(0.8, 0.45, 15.0);
  const Landing lost = nearest_landing(brittle, -pc, 0.1 * pc, brittle.initial_internal());
  EXPECT_EQ(lost.p, 0.0);
  EXPECT_EQ(lost.q, 0.0);
  EXPECT_NEAR(lost.internal, brittle.initial_internal() - pc / brittle.bulk_modulus, 1e-15);
}

TEST(Exact, IsotropicHistoryFollowsBothApexes) {
  const CamClay m = snow(0.8, 0.15, 5.0);
  const double x0 = m.initial_internal();
  EXPECT_EQ(exact::isotropic(m, 0.01, x0), x0);  // elastic: p_c0/K = 0.024
  EXPECT_EQ(exact::isotropic(m, 0.05, x0), exact::isotropic_compression(m, 0.05));
  const double compacted = exact::isotropic(m, 0.05, x0);
  EXPECT_EQ(exact::isotropic(m, 0.045, compacted), compacted);  // unloads elastically
  const double pulled = exact::isotropic(m, -0.004, x0);
  EXPECT_NEAR(pulled - 0.15 * std::sinh(5.0 * pulled), -0.004 + x0, 1e-15);
  EXPECT_NEAR(exact::isotropic(m, -0.1, x0), x0 - 0.1, 1e-15);  // expanded: no stress
  EXPECT_NEAR(exact::isotropic(m, -0.09, x0 - 0.1), x0 - 0.09, 1e-15);
}

TEST(Exact, HenckySimpleShearIsTheStressOfItsStretch) {
  // b = F F^T, tau = G log b
  for (const double gamma : {0.01, 0.7, 3.0}) {
    Mat3 f = Mat3::Identity();
    f(0, 1) = gamma;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(Mat3(f * f.transpose()));
    const Mat3 tau =
        2.5 * (eigen.eigenvectors() * eigen.eigenvalues().array().log().matrix().asDiagonal() * eigen.eigenvectors().transpose());
    EXPECT_LT((exact::hencky_simple_shear(2.5, gamma) - tau).norm(), 1e-12);
  }
}

TEST(Reference, RefusesWhatHasNoRateForm) {
  EXPECT_THROW(coaxial_reference(snow(0.0, 0.3, 5.0), {Segment::strain_increment(-0.1, 0.0)}), ConfigError);
  EXPECT_THROW(coaxial_reference(snow(0.8, 0.3, 5.0), {Segment::general(Mat3::Identity())}), ConfigError);
  EXPECT_THROW(coaxial_reference(snow(0.8, 0.3, 5.0), {Segment::drained(1e4, -0.1)}), ConfigError);  // starts from no radial stress
  EXPECT_THROW(general_reference(snow(0.8, 0.3, 5.0), {Segment::drained(1e4, -0.1)}), ConfigError);
}

}  // namespace
}  // namespace mpm::validation
