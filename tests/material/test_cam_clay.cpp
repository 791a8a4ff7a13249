#include "libmpm/material/cam_clay.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "libmpm/base/error.hpp"

namespace {

using namespace mpm;

CamClay::Parameters cam_clay(double slope, double beta, double xi, double p_c0 = 1e4) {
  CamClay::Parameters spec;
  spec.critical_state_slope = slope;
  spec.cohesion_beta = beta;
  spec.hardening_xi = xi;
  spec.preconsolidation_pressure = p_c0;
  return spec;
}

/// The paper's grid (Table 1) and its two rheologies of Sect. 4.2, at every compressibility.
std::vector<CamClay::Parameters> paper_grid() {
  std::vector<CamClay::Parameters> grid;
  for (const double xi : {0.05, 0.15, 0.5, 1.5, 5.0, 15.0}) {
    for (const double slope : {0.0, 0.4, 0.8, 1.2})
      for (const double beta : {0.0, 0.15, 0.3, 0.45}) grid.push_back(cam_clay(slope, beta, xi));
    grid.push_back(cam_clay(0.5, 0.15, xi));
    grid.push_back(cam_clay(0.9, 0.3, xi));
  }
  return grid;
}

double pressure(const MaterialState<double>& s) { return -trace(s.stress) / 3.0; }
double shear(const MaterialState<double>& s) { return std::sqrt(1.5 * norm2(deviator(s.stress))); }

Matrix3<double> isotropic(double stretch) {
  Matrix3<double> dl{};
  for (int i = 0; i < 3; ++i) dl.m[i][i] = stretch;
  return dl;
}
double determinant_of_increment(const Matrix3<double>& dl) {
  const auto& m = dl.m;
  const double xx = 1.0 + m[0][0], yy = 1.0 + m[1][1], zz = 1.0 + m[2][2];
  return xx * (yy * zz - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * zz - m[1][2] * m[2][0]) + m[0][2] * (m[1][0] * m[2][1] - yy * m[2][0]);
}

template <class T>
MaterialState<double> lane_of(const MaterialState<T>& s, int i) {
  const Sym3<T>& t = s.stress;
  return {{lane(t.xx, i), lane(t.yy, i), lane(t.zz, i), lane(t.xy, i), lane(t.xz, i), lane(t.yz, i)}, lane(s.internal, i)};
}
template <class T>
void set(MaterialState<T>& s, int i, const MaterialState<double>& v) {
  Sym3<T>& t = s.stress;
  set_lane(t.xx, i, v.stress.xx), set_lane(t.yy, i, v.stress.yy), set_lane(t.zz, i, v.stress.zz);
  set_lane(t.xy, i, v.stress.xy), set_lane(t.xz, i, v.stress.xz), set_lane(t.yz, i, v.stress.yz);
  set_lane(s.internal, i, v.internal);
}

/// Admissible states from expanded (X < 0) to strongly compacted, inside and on the surface and on the hydrostatic axis, and increments up
/// to +-0.5, each over several decades.
class Sampler {
 public:
  explicit Sampler(unsigned seed) : generator_(seed) {}
  double symmetric() { return uniform_(generator_); }

  MaterialState<double> state(const CamClay& law, const CamClay::Parameters& spec) {
    const double bulk = law.moduli().bulk(), x_0 = law.initial_internal();
    double x = symmetric() < -0.6 ? 0.1 * symmetric() : x_0 * std::pow(10.0, symmetric());
    if (law.preconsolidation_pressure(x) > 3.0 * bulk) x = x_0;
    MaterialState<double> s{{}, x};
    if (x <= 0.0) return s;
    const double p_c = law.preconsolidation_pressure(x), centre = 0.5 * (1.0 - spec.cohesion_beta) * p_c,
                 radius = 0.5 * (1.0 + spec.cohesion_beta) * p_c;
    const double angle = 3.14159 * symmetric(), r = symmetric() > 0.5 ? 1.0 : std::sqrt(std::fabs(symmetric()));
    const double p = centre + r * radius * std::cos(angle);
    const double q = symmetric() > 0.8
                         ? 0.0
                         : r * radius * std::fabs(std::sin(angle)) * spec.critical_state_slope / std::sqrt(1.0 + 2.0 * spec.cohesion_beta);
    const Sym3<double> direction = deviator(Sym3<double>{symmetric(), symmetric(), symmetric(), symmetric(), symmetric(), symmetric()});
    s.stress = (q / std::sqrt(1.5 * norm2(direction))) * direction;
    s.stress.xx -= p, s.stress.yy -= p, s.stress.zz -= p;
    return s;
  }

  Matrix3<double> increment() {
    const double size = 0.5 * std::pow(10.0, -3.5 * std::fabs(symmetric()));
    if (symmetric() > 0.8) return isotropic(size * symmetric());
    Matrix3<double> dl = isotropic(symmetric() > 0.0 ? size * symmetric() : 0.0);
    for (auto& row : dl.m)
      for (double& entry : row) entry = std::clamp(entry + size * symmetric(), -0.5, 0.5);
    return dl;
  }

 private:
  std::mt19937_64 generator_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

/// Numbers that the return map is computed with.
template <class T>
class CamClayLanes : public testing::Test {};
using LaneNumbers = testing::Types<Lanes, HalfPair>;
TYPED_TEST_SUITE(CamClayLanes, LaneNumbers);

TYPED_TEST(CamClayLanes, StayOnOrInsideYieldSurfaceForAnyTrialState) {
  Sampler sample(7);
  const auto grid = paper_grid();
  const int groups = 100000 / static_cast<int>(grid.size()) / lanes_of<TypeParam> + 1;
  for (const CamClay::Parameters& spec : grid) {
    const CamClay law(spec);
    const double bulk = law.moduli().bulk(), g = law.moduli().shear();
    for (int group = 0; group < groups; ++group) {
      MaterialState<double> before[lanes_of<TypeParam>];
      Matrix3<double> dl[lanes_of<TypeParam>];
      MaterialState<TypeParam> in_lanes{};
      Matrix3<TypeParam> dl_lanes{};
      for (int i = 0; i < lanes_of<TypeParam>; ++i) {
        before[i] = sample.state(law, spec);
        dl[i] = sample.increment();
        set(in_lanes, i, before[i]);
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) set_lane(dl_lanes.m[a][b], i, dl[i].m[a][b]);
      }
      law.update_stress(in_lanes, dl_lanes, 1.0);
      for (int i = 0; i < lanes_of<TypeParam>; ++i) {
        const double det = determinant_of_increment(dl[i]);
        MaterialState<double> after = before[i];
        law.update_stress(after, dl[i], 1.0);
        const MaterialState<double> vectorised = lane_of(in_lanes, i);
        if (det <= 0.0) {  // inverted: reported as NaN, by both
          ASSERT_TRUE(std::isnan(pressure(after)) && std::isnan(pressure(vectorised)));
          continue;
        }
        const auto where = [&] {
          return ::testing::Message() << "M " << spec.critical_state_slope << " beta " << spec.cohesion_beta << " xi " << spec.hardening_xi
                                      << " X " << before[i].internal << " -> " << after.internal << ", lanes " << vectorised.internal;
        };
        const double p = pressure(after), q = shear(after), p_c = law.preconsolidation_pressure(after.internal);
        ASSERT_TRUE(std::isfinite(p + q + after.internal)) << where();

        // On or inside. Round-off of the trial strain (up to about 1, hence about 1e-15 K in p and q) times the slope of y, about 2 p_c;
        // and the share 1e-13 of p_c^2 by which a state may exceed the surface without yielding.
        const double trial_error = 1e-14 * bulk;
        if (spec.critical_state_slope > 0.0) {
          ASSERT_LE(law.yield_function(after), 10.0 * trial_error * p_c + 1e-12 * p_c * p_c + trial_error * trial_error) << where();
        } else {
          ASSERT_LE(p - p_c, trial_error + 1e-12 * p_c) << where();
          ASSERT_LE(-p - spec.cohesion_beta * p_c, trial_error + 1e-12 * p_c) << where();
          if (after.internal != before[i].internal) {
            ASSERT_LE(q, trial_error) << where();
          }
        }
        // Plastic work of the step, p dX + q d(eps_q^P).
        const double q_trial = shear({law.moduli().stress(hencky_trial(law.moduli().strain(before[i].stress), dl[i])), 0.0});
        const double work = p * (after.internal - before[i].internal) + q * (q_trial - q) / (3.0 * g);
        ASSERT_GE(work, -trial_error * (p_c + q)) << where();
        // J: the increment's determinant. A determinant that is small by cancellation loses digits: b_e's smallest eigenvalue goes with
        // det^2 here.
        ASSERT_NEAR(law.volume_ratio(after) / law.volume_ratio(before[i]) / det, 1.0, 1e-13 / (det * det)) << where();
        // Both number types: the same root, to the convergence of either (1e-14) and the conditioning of a trial strain up to 1 over p_c/K.
        const double scale = std::max(p_c, 1e-3 * bulk);
        ASSERT_NEAR(vectorised.internal, after.internal, 1e-11 * std::max(std::fabs(after.internal), 1e-3)) << where();
        ASSERT_NEAR(vectorised.stress.xx, after.stress.xx, 1e-11 * scale) << where();
        ASSERT_NEAR(vectorised.stress.yz, after.stress.yz, 1e-11 * scale) << where();
        // Deterministic to the bit.
        MaterialState<double> again = before[i];
        law.update_stress(again, dl[i], 1.0);
        ASSERT_EQ(again.internal, after.internal);
        ASSERT_EQ(again.stress.xy, after.stress.xy);
      }
    }
  }
}

/// The nearest number that single precision holds.
double rounded(double x) { return static_cast<double>(static_cast<float>(x)); }

TEST(CamClaySingle, GivesTheStateOfDoublePrecisionOrLeavesItAlone) {
  constexpr int lanes = lanes_of<SinglePair>;
  Sampler sample(11);
  int updated = 0, left_alone = 0;
  for (const CamClay::Parameters& spec : paper_grid()) {
    CamClay law(spec);
    law.expect_single_states();
    const double bulk = law.moduli().bulk();
    for (int group = 0; group < 40; ++group) {
      MaterialState<double> before[lanes];
      Matrix3<double> dl[lanes];
      MaterialState<SinglePair> state{};
      Matrix3<SinglePair> dl_lanes{};
      for (int i = 0; i < lanes; ++i) {
        set(state, i, sample.state(law, spec));
        before[i] = lane_of(state, i);
        dl[i] = sample.increment();
        for (int a = 0; a < 3; ++a) {
          for (int b = 0; b < 3; ++b) {
            dl[i].m[a][b] = rounded(1e-2 * dl[i].m[a][b]);  // of a step: a longer one goes near an apex more often
            set_lane(dl_lanes.m[a][b], i, dl[i].m[a][b]);
          }
        }
      }
      const bool done = law.try_update_stress(state, dl_lanes, 1.0);
      ++(done ? updated : left_alone);
      for (int i = 0; i < lanes; ++i) {
        const MaterialState<double> after = lane_of(state, i);
        if (!done) {
          ASSERT_EQ(after.internal, before[i].internal);
          ASSERT_EQ(after.stress.xx, before[i].stress.xx);
          continue;
        }
        MaterialState<double> expected = before[i];
        law.update_stress(expected, dl[i], 1.0);
        // Some round-offs of the trial stress, and of the 1e-6 of the surface by which a state may be outside it without yielding.
        const double size = std::fabs(before[i].stress.xx) + std::fabs(before[i].stress.yy) + std::fabs(before[i].stress.zz) +
                            law.preconsolidation_pressure(expected.internal) + 5e-3 * bulk;
        ASSERT_NEAR(after.stress.xx, expected.stress.xx, 3e-6 * size) << "xi " << spec.hardening_xi << " beta " << spec.cohesion_beta;
        ASSERT_NEAR(after.stress.yz, expected.stress.yz, 3e-6 * size);
        ASSERT_NEAR(after.internal, expected.internal, 3e-6 * (std::fabs(expected.internal) + size / bulk));
      }
    }
  }
  EXPECT_GT(updated, 0);
  EXPECT_GT(left_alone, 0);
}

TEST(CamClayReturnMap, LandsOnTheLargestRootBelowAtAnIsotropicTensionApex) {
  // q = 0, tension: X - beta sinh(xi max(X, 0)) = X_n + p_tr/K, the largest root below X_n (here by a scan), also across snap-back.
  for (const double slope : {0.0, 0.8})
    for (const double beta : {0.0, 0.15, 0.45})
      for (const double xi : {0.5, 5.0, 15.0}) {
        const CamClay law(cam_clay(slope, beta, xi));
        const double bulk = law.moduli().bulk(), x_n = 3.0 * law.initial_internal();
        const double p_t = -beta * law.preconsolidation_pressure(x_n);
        for (const double beyond : {1e-6, 1e-3, 1e-2, 0.1}) {
          MaterialState<double> s{{-p_t, -p_t, -p_t, 0.0, 0.0, 0.0}, x_n};
          law.update_stress(s, isotropic(std::expm1(beyond / 3.0)), 1.0);
          const double target = x_n + p_t / bulk - beyond;
          const auto f = [&](double x) { return x - beta * std::sinh(xi * std::max(x, 0.0)) - target; };
          double high = x_n, low = x_n;
          const double stride = (x_n - std::min(target, 0.0)) / 20000.0;
          while (f(low) > 0.0) high = low, low -= stride;
          for (int i = 0; i < 100; ++i) (f(0.5 * (low + high)) > 0.0 ? high : low) = 0.5 * (low + high);
          EXPECT_NEAR(s.internal, high, 1e-12 * std::max(x_n, std::fabs(high)))
              << "M " << slope << " beta " << beta << " xi " << xi << " by " << beyond;
          EXPECT_NEAR(pressure(s), -beta * law.preconsolidation_pressure(high), 1e-12 * bulk);
          if (high <= 0.0) {
            EXPECT_EQ(pressure(s), 0.0);
          }
          EXPECT_NEAR(shear(s), 0.0, 1e-12 * bulk);
        }
      }
}

TEST(CamClayReturnMap, LandsOnTheNearestAdmissibleRootInTension) {
  // The first sign change of the residual below X_n, by a scan that is independent of the search in the law.
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int kept = 0, lost = 0;
  for (int k = 0; k < 300; ++k) {
    const double slope = 0.4 + 0.8 * uniform(generator), beta = 0.15 + 0.3 * uniform(generator), xi = k % 2 ? 15.0 : 3.0;
    const CamClay law(cam_clay(slope, beta, xi));
    const double bulk = law.moduli().bulk(), g = law.moduli().shear(), x_n = law.initial_internal() * (0.5 + 2.0 * uniform(generator));
    const double p_c = law.preconsolidation_pressure(x_n), p_tr = -p_c * beta * (0.2 + uniform(generator)), q_tr = p_c * uniform(generator);
    const auto residual = [&](double x) {  // y at the state that the flow rule reaches with X = x
      const double p = p_tr - bulk * (x - x_n), p_x = law.preconsolidation_pressure(x),
                   y_p = slope * slope * (2.0 * p - (1.0 - beta) * p_x);
      if (!(y_p < 0.0)) return -1.0;  // past the critical state
      const double q = q_tr / (1.0 + 6.0 * g * (1.0 + 2.0 * beta) * (x - x_n) / y_p);
      return q * q * (1.0 + 2.0 * beta) + slope * slope * (p + beta * p_x) * (p - p_x);
    };
    if (!(residual(x_n) > 0.0)) continue;
    const double end = std::max(x_n - 0.5 * ((1.0 - beta) * p_c - 2.0 * p_tr) / bulk, 0.0);  // past the critical state
    const int points = 40000;
    double high = x_n, low = x_n;
    for (int i = 1; i <= points && residual(low) > 0.0; ++i) high = low, low = x_n + (end - x_n) * i / points;
    const bool found = residual(low) <= 0.0 && low > 0.0;
    for (int i = 0; i < 100; ++i) (residual(0.5 * (low + high)) > 0.0 ? high : low) = 0.5 * (low + high);
    const double expected = found ? high : x_n + p_tr / bulk;
    kept += found, lost += !found;
    // Zero increment from a state outside the surface: exactly the trial state above.
    const double s12 = q_tr / std::sqrt(3.0);
    MaterialState<double> s{{-p_tr, -p_tr, -p_tr, s12, 0.0, 0.0}, x_n};
    law.update_stress(s, Matrix3<double>{}, 1.0);
    EXPECT_NEAR(s.internal, expected, 1e-10 * x_n)
        << "M " << slope << " beta " << beta << " xi " << xi << " p_tr/p_c " << p_tr / p_c << " q_tr/p_c " << q_tr / p_c;
  }
  EXPECT_GT(kept, 10);
  EXPECT_GT(lost, 10);
}

TEST(CamClayReturnMap, ExpandedMaterialCarriesNoStressUntilFullyRecompacted) {
  for (const double slope : {0.0, 0.8}) {
    const CamClay law(cam_clay(slope, 0.3, 5.0));
    MaterialState<double> s{{}, -0.05};
    law.update_stress(s, isotropic(std::expm1(-0.04 / 3.0)), 1.0);
    EXPECT_EQ(norm2(s.stress), 0.0);
    EXPECT_NEAR(s.internal, -0.01, 1e-15);  // a few ulp of 0.05
    law.update_stress(s, isotropic(std::expm1(-0.02 / 3.0)), 1.0);
    EXPECT_GT(pressure(s), 0.0);
    EXPECT_GT(s.internal, 0.0);
    EXPECT_NEAR(pressure(s) / law.moduli().bulk() + s.internal, 0.01, 1e-15);
  }
}

TEST(CamClayReturnMap, WithoutFrictionKeepsPressureAndLosesShear) {
  const CamClay law(cam_clay(0.0, 0.3, 5.0));
  MaterialState<double> s{{-3e3, -3e3, -3e3, 0.0, 0.0, 0.0}, law.initial_internal()};
  Matrix3<double> dl{};
  dl.m[0][1] = 0.01;
  law.update_stress(s, dl, 1.0);
  // Simple shear of a compressed point is isochoric: the pressure stays, X stays, q is gone.
  EXPECT_NEAR(pressure(s), 3e3, 1e-9);
  EXPECT_EQ(s.internal, law.initial_internal());
  EXPECT_NEAR(shear(s), 0.0, 1e-9);
}

TEST(CamClayReturnMap, IsContinuousAsFrictionVanishes) {
  // The limit M -> 0+ of the map is the map at M = 0.
  const CamClay none(cam_clay(0.0, 0.3, 5.0)), little(cam_clay(1e-6, 0.3, 5.0));
  for (const double volume : {-0.05, -0.01, 0.002, 0.03}) {
    MaterialState<double> a{{}, none.initial_internal()}, b = a;
    Matrix3<double> dl = isotropic(volume);
    dl.m[0][1] = 0.01;
    none.update_stress(a, dl, 1.0);
    little.update_stress(b, dl, 1.0);
    EXPECT_NEAR(pressure(a), pressure(b), 1e-5 * 1e4) << volume;  // q of order M p_c, and its plastic volume change
    EXPECT_NEAR(a.internal, b.internal, 1e-5);
  }
}

TEST(CamClay, RefusesNonsense) {
  EXPECT_THROW(CamClay(cam_clay(-0.1, 0.3, 5.0)), ConfigError);
  EXPECT_THROW(CamClay(cam_clay(0.8, 1.0, 5.0)), ConfigError);
  EXPECT_THROW(CamClay(cam_clay(0.8, -0.1, 5.0)), ConfigError);
  EXPECT_THROW(CamClay(cam_clay(0.8, 0.3, 0.0)), ConfigError);
  EXPECT_THROW(CamClay(cam_clay(0.8, 0.3, 5.0, -1.0)), ConfigError);
}

TEST(CamClay, CriticalStateRatioIsTheOneOfThePaper) {
  // M' of Eq. 2, values of the trial table: M 0.4, beta 0.15 -> 0.475; 0.8, 0.3 -> 1.175; 1.2, 0.3 -> 1.762 (three digits)
  EXPECT_NEAR(cam_clay(0.4, 0.15, 5.0).critical_state_ratio(), 0.475, 5e-4);
  EXPECT_NEAR(cam_clay(0.8, 0.3, 5.0).critical_state_ratio(), 1.175, 5e-4);
  EXPECT_NEAR(cam_clay(1.2, 0.3, 5.0).critical_state_ratio(), 1.762, 5e-4);
}

}  // namespace
