#include "libmpm/material/hencky_elastic.hpp"

#include "libmpm/base/parameter.hpp"

namespace mpm {

HenckyModuli::HenckyModuli(const Parameters& p)
    : bulk_(p.young_modulus / (3.0 * (1.0 - 2.0 * p.poisson_ratio))),
      shear_(p.young_modulus / (2.0 * (1.0 + p.poisson_ratio))),
      density_(p.density) {}

double HenckyModuli::wave_speed() const { return std::sqrt((bulk_ + 4.0 / 3.0 * shear_) / density_); }

double HenckyModuli::stored_energy(const Sym3<double>& stress) const {
  const HenckyStrain<double> eps = strain(stress);
  return 0.5 * bulk_ * eps.volumetric * eps.volumetric + shear_ * norm2(eps.deviator);
}

HenckyElastic::HenckyElastic(const Parameters& parameters) : moduli_(checked(parameters)) {}

}  // namespace mpm
