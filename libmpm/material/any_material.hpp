#pragma once
/// The list of laws. To add one: write its header against the concept `Material`, add it to this variant, add typical parameters to
/// tests/support/typical_materials.hpp. Keys, messages and the reference of `mpm schema` follow from the list.

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/material/cam_clay.hpp"
#include "libmpm/material/drucker_prager.hpp"
#include "libmpm/material/hencky_elastic.hpp"
#include "libmpm/material/weakly_compressible_fluid.hpp"

namespace mpm {

/// One law of the list.
using AnyMaterial = std::variant<CamClay, HenckyElastic, DruckerPrager, WeaklyCompressibleFluid>;

namespace detail {
template <class Laws>
struct ParametersOf;
template <Material... L>
struct ParametersOf<std::variant<L...>> {
  using type = std::variant<typename L::Parameters...>;
};
}  // namespace detail

/// [material]: which law, and its parameters.
struct MaterialParameters {
  typename detail::ParametersOf<AnyMaterial>::type law;  ///< the parameters of one law; the type says which

  /// Those of the first law of the list, with their defaults.
  MaterialParameters() = default;
  /// The law to which these parameters belong.
  template <MaterialParameterSet P>
  MaterialParameters(const P& parameters)
      : law(parameters) {}  // NOLINT(google-explicit-constructor): the parameters of a law are a material
  bool operator==(const MaterialParameters&) const = default;

  [[nodiscard]] std::string_view name() const;       ///< as in a case: "cohesive_cam_clay"
  [[nodiscard]] std::string_view equations() const;  ///< the law in formulas
  [[nodiscard]] double density() const;              ///< rho_0, kg/m^3
  void set_density(double density);                  ///< rho_0, kg/m^3

  /// The parameters of one law; std::bad_variant_access if it is another one.
  template <Material L>
  [[nodiscard]] typename L::Parameters& as() {
    return std::get<typename L::Parameters>(law);
  }
  /// The parameters of one law; std::bad_variant_access if it is another one.
  template <Material L>
  [[nodiscard]] const typename L::Parameters& as() const {
    return std::get<typename L::Parameters>(law);
  }
  /// The same, or null.
  template <Material L>
  [[nodiscard]] const typename L::Parameters* get_if() const {
    return std::get_if<typename L::Parameters>(&law);
  }

  // Properties of some laws; empty for the others.
  [[nodiscard]] std::optional<double> internal_friction() const;     ///< tan(phi') of the material within itself
  [[nodiscard]] std::optional<double> critical_state_ratio() const;  ///< M' = q/p at the critical state
  [[nodiscard]] std::optional<double> hardening_xi() const;          ///< xi
  [[nodiscard]] std::optional<double> cohesion_beta() const;         ///< beta = p_t / p_c
  [[nodiscard]] bool keeps_compaction() const;                       ///< whether compacted material stays denser

  /// [material] model, then the parameters of every law.
  template <class Table>
  static void declare(Table& table) {
    table.alternatives("model", &MaterialParameters::law, "Constitutive law");
  }
  void check(ParameterReport& report) const;  ///< the law's own check
};

/// @param states  precision in which states are stored between steps. @throws ConfigError if the law refuses its parameters
AnyMaterial make_material(const MaterialParameters& parameters, Precision states = Precision::double_precision);

double density_of(const AnyMaterial& material);           ///< rho_0, kg/m^3
double wave_speed_of(const AnyMaterial& material);        ///< of the fastest elastic wave, m/s
double bulk_speed_of(const AnyMaterial& material);        ///< sqrt(K/rho_0), m/s; 0 for a law that never bears tension
double initial_internal_of(const AnyMaterial& material);  ///< of a stress-free point
double viscosity_of(const AnyMaterial& material);         ///< eta, Pa s; 0 for a law without viscous stress
bool keeps_compaction(const AnyMaterial& material);       ///< whether compacted material stays denser
/// J = det F
double volume_ratio(const AnyMaterial& material, const MaterialState<double>& state);

/// A law as a user sees it.
struct LawInfo {
  std::string name, description;  ///< value of [material] model; one line
};
/// All laws, in the order of the variant.
std::vector<LawInfo> all_laws();

}  // namespace mpm
