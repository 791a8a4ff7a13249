#pragma once
/// Hencky elasticity: Saint-Venant-Kirchhoff in logarithmic strain, the elastic part of every law here.

#include <cmath>
#include <string_view>

#include "libmpm/base/parameter.hpp"
#include "libmpm/material/concept.hpp"

namespace mpm {

/// tau = K tr(eps) I + 2 G dev(eps), eps = 1/2 log b_e; stored energy per reference volume psi = 1/2 K tr(eps)^2 + G dev(eps):dev(eps).
/// The stress is linear in the strain, so that the stress is the only state.
class HenckyModuli {
 public:
  /// Elastic parameters of every law with this elastic part.
  struct Parameters {
    double density = 300.0;        ///< rho_0, kg/m^3
    double young_modulus = 1.0e6;  ///< E, Pa
    double poisson_ratio = 0.1;    ///< nu
    bool operator==(const Parameters&) const = default;

    /// These without the other parameters of a law, for another law with the same elastic part.
    [[nodiscard]] const Parameters& moduli() const { return *this; }

    /// The keys of density and elastic moduli (base/parameter.hpp).
    template <class Table>
    static void declare(Table& table) {
      declare_density(table, &Parameters::density);
      table.add("young_modulus_pa", &Parameters::young_modulus).unit("Pa").range(1.0, 1e12).text("Young's modulus E");
      table.add("poisson_ratio", &Parameters::poisson_ratio).below(0.0, 0.5).text("Poisson's ratio nu");
    }
  };

  /// The parameters are not checked; the law that contains them does that.
  explicit HenckyModuli(const Parameters& p)
      : bulk_(p.young_modulus / (3.0 * (1.0 - 2.0 * p.poisson_ratio))),
        shear_(p.young_modulus / (2.0 * (1.0 + p.poisson_ratio))),
        density_(p.density) {}

  [[nodiscard]] double bulk() const { return bulk_; }        ///< K = E / (3 (1 - 2 nu)), Pa
  [[nodiscard]] double shear() const { return shear_; }      ///< G = E / (2 (1 + nu)), Pa
  [[nodiscard]] double density() const { return density_; }  ///< rho_0, kg/m^3
  /// c_P = sqrt((K + 4G/3) / rho_0), m/s
  [[nodiscard]] double wave_speed() const { return std::sqrt((bulk_ + 4.0 / 3.0 * shear_) / density_); }
  [[nodiscard]] double bulk_speed() const { return std::sqrt(bulk_ / density_); }  ///< sqrt(K / rho_0), m/s

  /// eps of a Kirchhoff stress in Pa.
  template <LaneNumber T>
  [[nodiscard]] HenckyStrain<T> strain(const Sym3<T>& stress) const {
    const T mean = trace(stress) * (1.0 / 3.0);
    return {mean * (1.0 / bulk_),
            broadcast<T>(0.5 / shear_) * Sym3<T>{stress.xx - mean, stress.yy - mean, stress.zz - mean, stress.xy, stress.xz, stress.yz}};
  }
  /// Kirchhoff stress tau in Pa of a strain.
  template <LaneNumber T>
  [[nodiscard]] Sym3<T> stress(const HenckyStrain<T>& strain) const {
    Sym3<T> tau = broadcast<T>(2.0 * shear_) * strain.deviator;
    const T mean = bulk_ * strain.volumetric;
    tau.xx += mean, tau.yy += mean, tau.zz += mean;
    return tau;
  }
  /// psi, J/m^3 of reference volume.
  [[nodiscard]] double stored_energy(const Sym3<double>& stress) const {
    const HenckyStrain<double> eps = strain(stress);
    return 0.5 * bulk_ * eps.volumetric * eps.volumetric + shear_ * norm2(eps.deviator);
  }

 private:
  double bulk_, shear_, density_;
};

/// The law without plasticity. The internal variable stays 0.
class HenckyElastic {
 public:
  /// Density and elastic moduli.
  struct Parameters : HenckyModuli::Parameters {
    static constexpr std::string_view name = "hencky_elastic";  ///< value of [material] model
    static constexpr std::string_view description =
        "Saint-Venant-Kirchhoff elasticity in Hencky strain";  ///< one line for the reference of keys
    /// The law in formulas, for exported cases.
    static constexpr std::string_view equations =
        "Kirchhoff stress tau = K tr(eps) I + 2 G dev(eps) with the Hencky strain eps = 1/2 ln(F F^T); K = E/(3 (1 - 2 nu)), G "
        "= E/(2 (1 + nu)); Cauchy stress sigma = tau/J, J = det F. internal: not used.";
    bool operator==(const Parameters&) const = default;
  };

  /// Beside what every law has.
  static constexpr OptionalMembers has{.try_update_stress = true};

  /// @throws ConfigError if a parameter is out of range
  explicit HenckyElastic(const Parameters& parameters) : moduli_(checked(parameters)) {}

  /// Exact for any increment. The result is NaN in a lane whose deformation is inverted or not finite.
  template <LaneNumber T>
  void update_stress(MaterialState<T>& state, const Matrix3<T>& dl, double /*dt*/) const {
    state.stress = moduli_.stress(hencky_trial(moduli_.strain(state.stress), dl));
  }
  /// The same in single precision, which always suffices.
  bool try_update_stress(MaterialState<SinglePair>& state, const Matrix3<SinglePair>& dl, double dt) const {
    update_stress(state, dl, dt);
    return true;
  }
  /// J = exp(tr eps)
  template <LaneNumber T>
  [[nodiscard]] T volume_ratio(const MaterialState<T>& state) const {
    return exp(moduli_.strain(state.stress).volumetric);
  }
  [[nodiscard]] double density() const { return moduli_.density(); }        ///< rho_0, kg/m^3
  [[nodiscard]] double initial_internal() const { return 0.0; }             ///< unused
  [[nodiscard]] double wave_speed() const { return moduli_.wave_speed(); }  ///< c_P, m/s
  [[nodiscard]] double bulk_speed() const { return moduli_.bulk_speed(); }  ///< sqrt(K/rho_0), m/s
  /// psi, J/m^3 of reference volume.
  [[nodiscard]] double stored_energy(const MaterialState<double>& state) const { return moduli_.stored_energy(state.stress); }
  [[nodiscard]] const HenckyModuli& moduli() const { return moduli_; }  ///< the elastic part

 private:
  HenckyModuli moduli_;
};

static_assert(Material<HenckyElastic>);

}  // namespace mpm
