#include "libmpm/material/weakly_compressible_fluid.hpp"

#include "libmpm/base/parameter.hpp"

namespace mpm {

WeaklyCompressibleFluid::WeaklyCompressibleFluid(const Parameters& p)
    : density_(checked(p).density),
      bulk_(p.bulk_modulus),
      viscosity_(p.viscosity),
      exponent_(p.tait_exponent),
      carries_tension_(p.carries_tension) {}

// psi n/K = ((1 + r)^m - 1)/m - r/(1 + r) with m = n - 1, whose terms of first order cancel: by binomials,
// r^2 (sum_{k=2}^m C(m,k)/m r^(k-2) + 1/(1 + r)). For n = 1 it is ln(1 + r) - r/(1 + r) = sum_{k>=2} (-1)^k (k - 1)/k r^k.
double WeaklyCompressibleFluid::stored_energy(const MaterialState<double>& state) const {
  const double j = state.internal, r = -j / (1.0 + j);
  if (j > 0.0 && !carries_tension_) return 0.0;
  if (exponent_ == 1) {
    if (std::fabs(r) > 0.01) return bulk_ * (j - std::log1p(j));
    double sum = 0.0;
    for (int k = 9; k >= 2; --k) sum = (k % 2 == 0 ? 1.0 : -1.0) * (k - 1.0) / k + sum * r;  // 0.01^8 is round-off
    return bulk_ * r * r * sum;
  }
  const int m = exponent_ - 1;
  double sum = 0.0, binomial = 1.0;  // C(m, k), from k = m down
  for (int k = m; k >= 2; --k) {
    sum = sum * r + binomial / m;
    binomial *= static_cast<double>(k) / (m - k + 1);
  }
  return bulk_ / exponent_ * r * r * (sum + 1.0 / (1.0 + r));
}

}  // namespace mpm
