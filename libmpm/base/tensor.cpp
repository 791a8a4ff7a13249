#include "libmpm/base/tensor.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace mpm {

Mat3 exp_minus_identity(const Mat3& a) {
  constexpr int terms = 16;  // of the series, for entries whose sum is below 1/2: the next one is below round-off
  int exponent = 0;
  std::frexp(a.cwiseAbs().sum(), &exponent);
  const int halvings = std::max(0, exponent + 1);
  const Mat3 x = a * std::ldexp(1.0, -halvings);
  Mat3 term = x, e = x;
  for (int n = 2; n <= terms; ++n) {
    term = term * x / n;
    e += term;
  }
  for (int i = 0; i < halvings; ++i) e = e * e + 2.0 * e;  // exp(2 x) - I = (e + I)^2 - I
  return e;
}

namespace detail {
namespace {

/// V diag(f(lambda_i)) V^T
template <class F>
Sym3<double> isotropic_function(const Sym3<double>& a, F f) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix3d m;
  m << a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz;
  if (!m.allFinite()) return {nan, nan, nan, nan, nan, nan};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m);
  const Eigen::Matrix3d r = solver.eigenvectors() * solver.eigenvalues().unaryExpr(f).asDiagonal() * solver.eigenvectors().transpose();
  return {r(0, 0), r(1, 1), r(2, 2), r(0, 1), r(0, 2), r(1, 2)};
}

}  // namespace

Sym3<double> exp_minus_identity_by_eigenvalues(const Sym3<double>& a) {
  return isotropic_function(a, [](double x) { return std::expm1(x); });
}

Sym3<double> half_log_identity_plus_by_eigenvalues(const Sym3<double>& a) {
  return isotropic_function(a, [](double x) { return x > -1.0 ? 0.5 * std::log1p(x) : std::numeric_limits<double>::quiet_NaN(); });
}

}  // namespace detail
}  // namespace mpm
