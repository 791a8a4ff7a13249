#include "libmpm/base/tensor.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

namespace {

using namespace mpm;
using Mat3l = Eigen::Matrix<long double, 3, 3>;

template <class F>
Mat3l isotropic_function(const Mat3l& a, F f) {
  const Eigen::SelfAdjointEigenSolver<Mat3l> solver(a);
  return solver.eigenvectors() * solver.eigenvalues().unaryExpr(f).asDiagonal() * solver.eigenvectors().transpose();
}
Mat3l matrix(const HenckyStrain<double>& e) {
  const long double m = e.volumetric / 3.0L;
  const auto& d = e.deviator;
  Mat3l r;
  r << d.xx + m, d.xy, d.xz, d.xy, d.yy + m, d.yz, d.xz, d.yz, d.zz + m;
  return r;
}
Mat3l trial_in_long_double(const HenckyStrain<double>& eps, const Matrix3<double>& dl) {
  Mat3l f = Mat3l::Identity();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) f(i, j) += dl.m[i][j];
  const Mat3l b = f * isotropic_function(matrix(eps), [](long double x) { return std::exp(2.0L * x); }) * f.transpose();
  return isotropic_function(b, [](long double x) { return 0.5L * std::log(x); });
}

struct Sample {
  HenckyStrain<double> eps;
  Matrix3<double> dl;
};
class Sampler {
 public:
  Sample operator()(double strain, double increment) {
    Sample s{};
    const Sym3<double> e{u(), u(), u(), u(), u(), u()};
    s.eps = {strain * trace(e), strain * deviator(e)};
    for (auto& row : s.dl.m)
      for (double& entry : row) entry = increment * u();
    return s;
  }

 private:
  double u() { return uniform_(generator_); }
  std::mt19937_64 generator_{5};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

double largest_entry(const Mat3l& a) { return static_cast<double>(a.cwiseAbs().maxCoeff()); }

/// tau = K tr eps I + 2 G dev eps with nu = 0.1 and G = 1: K/G = 1.1.
Mat3l stress(const Mat3l& eps) {
  const long double bulk = 2.2L / 2.4L;
  return (bulk - 2.0L / 3.0L) * eps.trace() * Mat3l::Identity() + 2.0L * eps;
}

TEST(HenckyTrial, StressErrorIsAtRoundOffFromTinyToLargeStrains) {
  // Demand: |error of tau| <= 1e-12 max(|tau|, 2e-3 G), through all tiers: both series and the eigenvalues, in both number types.
  Sampler sample;
  for (const double strain : {0.0, 1e-9, 1e-5, 1e-3, 0.01, 0.03, 0.1, 0.3})
    for (const double increment : {1e-9, 1e-5, 1e-3, 0.01, 0.03, 0.1, 0.3}) {
      for (int group = 0; group < 40; ++group) {
        Sample s[lanes_of<Lanes>];
        HenckyStrain<Lanes> eps{};
        Matrix3<Lanes> dl{};
        for (int i = 0; i < lanes_of<Lanes>; ++i) {
          s[i] = sample(strain, increment);
          eps.volumetric[i] = s[i].eps.volumetric;
          const auto& d = s[i].eps.deviator;
          eps.deviator.xx[i] = d.xx, eps.deviator.yy[i] = d.yy, eps.deviator.zz[i] = d.zz;
          eps.deviator.xy[i] = d.xy, eps.deviator.xz[i] = d.xz, eps.deviator.yz[i] = d.yz;
          for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) dl.m[a][b][i] = s[i].dl.m[a][b];
        }
        const HenckyStrain<Lanes> lanes = hencky_trial(eps, dl);
        for (int i = 0; i < lanes_of<Lanes>; ++i) {
          const Mat3l reference = trial_in_long_double(s[i].eps, s[i].dl);
          const double allowed = 1e-12 * std::max(largest_entry(stress(reference)), 2e-3);
          const auto& d = lanes.deviator;
          const HenckyStrain<double> one = hencky_trial(s[i].eps, s[i].dl);
          const HenckyStrain<double> of_lanes{lanes.volumetric[i], {d.xx[i], d.yy[i], d.zz[i], d.xy[i], d.xz[i], d.yz[i]}};
          // The inverse of b_e amplifies round-off where the increment nearly collapses a direction.
          const double smallest = static_cast<double>(Eigen::SelfAdjointEigenSolver<Mat3l>(reference).eigenvalues()(0));
          const double conditioning = std::max(1.0, 1e-2 * std::exp(-2.0 * smallest));
          ASSERT_LE(largest_entry(stress(matrix(one)) - stress(reference)), allowed * conditioning) << strain << " " << increment;
          ASSERT_LE(largest_entry(stress(matrix(of_lanes)) - stress(reference)), allowed * conditioning) << strain << " " << increment;
        }
      }
    }
}

TEST(HenckyTrial, KeepsRelativePrecisionForSmallStrains) {
  Sampler sample;
  for (const double size : {1e-12, 1e-8, 1e-5}) {
    const Sample s = sample(size, size);
    const Mat3l reference = trial_in_long_double(s.eps, s.dl);
    // long double itself rounds 1 + 2 eps to 1e-19.
    EXPECT_LE(largest_entry(matrix(hencky_trial(s.eps, s.dl)) - reference), 1e-14 * largest_entry(reference) + 1e-18) << size;
  }
}

TEST(HenckyTrial, InvertedOrSenselessIncrementsGiveNaNInTheirLaneOnly) {
  Matrix3<Lanes> dl{};
  dl.m[0][0] = broadcast<Lanes>(0.01);
  for (int a = 0; a < 3; ++a) dl.m[a][a][1] = -2.0;  // f = -I: b_e alone would not show it
  dl.m[2][2][3] = -1.5;                              // one direction inverted
  dl.m[0][1][4] = std::numeric_limits<double>::quiet_NaN();
  dl.m[0][1][6] = std::numeric_limits<double>::infinity();
  const HenckyStrain<Lanes> trial = hencky_trial(HenckyStrain<Lanes>{}, dl);
  for (int i = 0; i < lanes_of<Lanes>; ++i) {
    const bool fault = i == 1 || i == 3 || i == 4 || i == 6;
    EXPECT_EQ(std::isnan(trial.volumetric[i]) || std::isnan(trial.deviator.xx[i]), fault) << i;
    if (!fault) {
      EXPECT_NEAR(trial.volumetric[i], std::log1p(0.01), 1e-15);
    }
  }
}

TEST(HenckyTrial, ExpAndLogAreInverse) {
  Sampler sample;
  for (const double size : {1e-10, 1e-4, 0.02, 0.2}) {
    const HenckyStrain<double> eps = sample(size, 0.0).eps;
    const HenckyStrain<double> back = half_log_identity_plus(exp_minus_identity(eps));
    EXPECT_LE(largest_entry(matrix(back) - matrix(eps)), 2e-14 * largest_entry(matrix(eps))) << size;  // 3e-15 of truncation and a few ulp
  }
}

TEST(Tensor, ExponentialOfAMatrix) {
  Mat3 symmetric, turn, shear = Mat3::Zero();
  symmetric << 0.3, -0.2, 0.1, -0.2, -0.4, 0.5, 0.1, 0.5, 0.2;
  turn << 0.0, -2.0, 1.0, 2.0, 0.0, -0.5, -1.0, 0.5, 0.0;
  shear(0, 1) = 7.0;
  for (const double scale : {1e-9, 0.1, 1.0, 10.0}) {
    const Mat3 e = exp_minus_identity(Mat3(scale * symmetric));
    const Mat3l exact = isotropic_function(Mat3l((scale * symmetric).cast<long double>()), [](long double x) { return std::expm1(x); });
    EXPECT_LT((e.cast<long double>() - exact).norm(), 1e-14L * exact.norm()) << scale;
    const double angle = scale * std::sqrt(0.5) * turn.norm();  // Rodrigues
    const Mat3 k = scale / angle * turn, rotation = std::sin(angle) * k + 2.0 * std::pow(std::sin(0.5 * angle), 2) * k * k;
    EXPECT_LT((exp_minus_identity(Mat3(scale * turn)) - rotation).norm(), 1e-13 * std::min(1.0, angle)) << scale;
    EXPECT_LT((exp_minus_identity(Mat3(scale * shear)) - scale * shear).norm(), 1e-15 * scale) << scale;
  }
}

}  // namespace
