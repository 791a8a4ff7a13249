#include "mpm/materials/weakly_compressible_fluid.hpp"

#include <fmt/format.h>

#include "mpm/error.hpp"

namespace mpm {

WeaklyCompressibleFluid::WeaklyCompressibleFluid(const MaterialSpec& spec)
    : density_(spec.density),
      bulk_(spec.bulk_modulus),
      viscosity_(spec.viscosity),
      exponent_(spec.tait_exponent),
      carries_tension_(spec.carries_tension) {
  if (!(std::isfinite(density_) && density_ > 0.0))
    throw ConfigError(fmt::format("[material] density_kg_m3 = {}: a finite value above 0 is needed", density_));
  if (!(std::isfinite(bulk_) && bulk_ > 0.0))
    throw ConfigError(fmt::format("[material] bulk_modulus_pa = {}: a finite value above 0 is needed", bulk_));
  if (exponent_ < 1) throw ConfigError(fmt::format("[material] tait_exponent = {}: at least 1 is needed", exponent_));
  if (!(std::isfinite(viscosity_) && viscosity_ >= 0.0))
    throw ConfigError(fmt::format("[material] viscosity_pa_s = {}: a finite value of at least 0 is needed", viscosity_));
}

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
