#include "mpm/materials/hencky_elastic.hpp"

#include <fmt/format.h>

#include "mpm/error.hpp"

namespace mpm {

HenckyModuli::HenckyModuli(const MaterialSpec& spec)
    : bulk_(spec.young_modulus / (3.0 * (1.0 - 2.0 * spec.poisson_ratio))),
      shear_(spec.young_modulus / (2.0 * (1.0 + spec.poisson_ratio))),
      density_(spec.density) {
  if (!(std::isfinite(spec.young_modulus) && spec.young_modulus > 0.0))
    throw ConfigError(fmt::format("[material] young_modulus_pa = {}: a finite value above 0 is needed", spec.young_modulus));
  if (!(spec.poisson_ratio > -1.0 && spec.poisson_ratio < 0.5))
    throw ConfigError(
        fmt::format("[material] poisson_ratio = {}: a value between -1 and 0.5 (both excluded) is needed", spec.poisson_ratio));
  if (!(std::isfinite(spec.density) && spec.density > 0.0))
    throw ConfigError(fmt::format("[material] density_kg_m3 = {}: a finite value above 0 is needed", spec.density));
}

double HenckyModuli::wave_speed() const { return std::sqrt((bulk_ + 4.0 / 3.0 * shear_) / density_); }

double HenckyModuli::stored_energy(const Sym3<double>& stress) const {
  const HenckyStrain<double> eps = strain(stress);
  return 0.5 * bulk_ * eps.volumetric * eps.volumetric + shear_ * norm2(eps.deviator);
}

}  // namespace mpm
