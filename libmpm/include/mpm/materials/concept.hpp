#pragma once
/// What a constitutive law has to offer. A law knows its formula and nothing of particles, grids or lanes:
/// it is a template over the number type, run with `double` (the specification) and with `Lanes`
/// or `LanePair` (eight or sixteen material points at once).

#include <concepts>
#include <string_view>

#include "mpm/lanes.hpp"
#include "mpm/tensor.hpp"

namespace mpm {

/// State of one material point (or of eight, in lanes).
template <class T>
struct MaterialState {
  Sym3<T> stress;  ///< Kirchhoff stress tau, Pa, tension positive
  T internal;      ///< the law's scalar internal variable
};

/// @param state    state at t_n; on return, at t_n+1
/// @param dl       dt * velocity gradient (dimensionless), so that F_n+1 = (I + dl) F_n
/// @param dt       time step, s (rate-dependent laws)
template <class L, class T>
concept UpdatesStress = requires(const L law, MaterialState<T>& state, const Matrix3<T>& dl, double dt) {
  { law.update_stress(state, dl, dt) } -> std::same_as<void>;
  { law.volume_ratio(state) } -> std::same_as<T>;  // J = det F relative to the reference state
};

template <class L>
concept Material = UpdatesStress<L, double> && UpdatesStress<L, Lanes> && UpdatesStress<L, LanePair> && requires(const L law) {
  { L::name } -> std::convertible_to<std::string_view>;
  { law.density() } -> std::same_as<double>;                               // rho_0, kg/m^3
  { law.initial_internal() } -> std::same_as<double>;                      // internal variable of the stress-free reference state
  { law.wave_speed() } -> std::same_as<double>;                            // c_P = sqrt((K + 4G/3)/rho_0), m/s
  { law.stored_energy(MaterialState<double>{}) } -> std::same_as<double>;  // elastic energy per reference volume, J/m^3
};

}  // namespace mpm
