#pragma once
/// The interface of a constitutive law. A law is independent of particles, grids and lanes:
/// it is a template over the number type, run with `double` (the specification) and with `Lanes`
/// or `LanePair` (eight or sixteen material points at once).
///
/// Requirements of the core on `update_stress`:
/// - It takes any finite increment dl and any state that it has returned. It never throws and has no state of its own.
/// - An invalid deformation (an inverted element, a number that is not finite) makes the stress or the internal variable of that lane NaN
///   and does not affect the other lanes. The step finds the NaN, stops, and names the particle.
/// - Lanes do not influence each other: the result of a point is the same, to the bit, in every lane and beside every neighbour.
///
/// History variables. A law has one, `internal`, the last of the 24 doubles of a particle's record (particle.hpp). The record is full:
/// three cache lines, each of them one vector load of the transfers; a single record is six quads. More variables in the record would
/// cost every law: a run chooses its law among AnyMaterial, so that the record would have room for the law with the most, and one law with
/// two variables would make every particle of every run 256 bytes in place of 192 (33 % more to move in each step), or double all
/// instances of the transfers, as the choice of precision does now. No law needs more today, and so there is no constant for it.
///
/// What a law with n > 1 variables takes, at no cost for the others: the variables beyond the first lie beside the records, not in them.
/// 1. `history_count` of the law, 1 where it is absent, and MaterialState<T, n> with an array beside `internal`; LawGroup in
///    stress_update.cpp gathers and stores n - 1 more lines from the bin. The transfers read none of them.
/// 2. ParticleBin (core/particle_bin.hpp) holds n - 1 further numbers a slot in pages of their own, moved by append, remove and restore.
///    Migrant and StoredBlock carry them from block to block. They are empty for laws with one variable.
/// 3. What copies records or particles copies them, too: parallel/ownership.cpp and driver/pieces.cpp (messages),
///    driver/checkpoint.cpp (a further dataset), io/snapshot.cpp (a dataset a variable; frames and final.h5).
/// 4. initial_internal becomes an array; volume_ratio and stored_energy take the whole state already.

#include <concepts>
#include <string_view>

#include "libmpm/base/lane_pair.hpp"
#include "libmpm/base/tensor.hpp"

namespace mpm {

class ParameterReport;

/// State of one material point (or of eight, in lanes).
template <class T>
struct MaterialState {
  Sym3<T> stress;  ///< Kirchhoff stress tau, Pa, tension positive
  T internal;      ///< the law's history variable
};

/// @param state    state at t_n; on return, at t_n+1
/// @param dl       dt * velocity gradient (dimensionless), so that F_n+1 = (I + dl) F_n
/// @param dt       time step, s (rate-dependent laws)
/// A law computes with the number type T.
template <class L, class T>
concept UpdatesStress = requires(const L law, MaterialState<T>& state, const Matrix3<T>& dl, double dt) {
  { law.update_stress(state, dl, dt) } -> std::same_as<void>;
  { law.volume_ratio(state) } -> std::same_as<T>;  // J = det F relative to the reference state
};

/// Parameters of a law, in SI units; `declare` (base/parameter.hpp) defines their keys.
template <class P>
concept MaterialParameterSet = std::default_initializable<P> && std::equality_comparable<P> && requires(const P p) {
  { P::name } -> std::convertible_to<std::string_view>;         // value of [material] model
  { P::description } -> std::convertible_to<std::string_view>;  // one line
  // The law in formulas for users of other solvers, to whom cases are exported: the stress, and what `internal` holds. Symbols are those of
  // the keys.
  { P::equations } -> std::convertible_to<std::string_view>;
  { p.density } -> std::convertible_to<double>;  // rho_0, kg/m^3
};

/// A law may offer single precision: try_update_stress computes the same as update_stress, or returns false and leaves the state unchanged
/// if single precision does not suffice for one of the points. The core then calls update_stress in double precision.
template <class L>
concept UpdatesStressInSingle = requires(const L law, MaterialState<SinglePair>& state, const Matrix3<SinglePair>& dl, double dt) {
  { law.try_update_stress(state, dl, dt) } -> std::same_as<bool>;
};

/// The members that a law may have in addition. It lists those that it has as `static constexpr OptionalMembers has{.viscosity = true}`;
/// the concept Material compares the list with the members, so that a misspelt one is an error and not an absent one.
struct OptionalMembers {
  bool try_update_stress = false;          ///< UpdatesStressInSingle
  bool expect_single_states = false;       ///< (): called once if states are rounded to single precision between steps, for a law that
                                           ///< compares a state with its own earlier result
  bool viscosity = false;                  ///< (), Pa s: eta of viscous stress, which limits the time step
  bool yield_function = false;             ///< (state), Pa^2, <= 0 inside: a column of `mpm point`, as the next two
  bool preconsolidation_pressure = false;  ///< (internal), Pa
  bool plastic_volume_strain = false;      ///< (state)
  bool internal_friction = false;          ///< Parameters: (), tan(phi') of the material within itself
  bool critical_state_ratio = false;       ///< Parameters: (), M' = q/p at the critical state
  bool hardening_xi = false;               ///< Parameters: xi
  bool cohesion_beta = false;              ///< Parameters: beta
  bool keeps_compaction = false;           ///< Parameters: true if compacted material stays denser
  bool check = false;                      ///< Parameters: (ParameterReport&)
  bool operator==(const OptionalMembers&) const = default;
};

/// The members that a law really has.
template <class L, class P = typename L::Parameters>
consteval OptionalMembers members_of() {
  OptionalMembers has{.try_update_stress = UpdatesStressInSingle<L>};
  has.expect_single_states = requires(L law) { law.expect_single_states(); };
  has.viscosity = requires(const L law) { law.viscosity(); };
  has.yield_function = requires(const L law, MaterialState<double> state) { law.yield_function(state); };
  has.preconsolidation_pressure = requires(const L law) { law.preconsolidation_pressure(0.0); };
  has.plastic_volume_strain = requires(const L law, MaterialState<double> state) { law.plastic_volume_strain(state); };
  has.internal_friction = requires(const P p) { p.internal_friction(); };
  has.critical_state_ratio = requires(const P p) { p.critical_state_ratio(); };
  has.hardening_xi = requires(const P p) { p.hardening_xi; };
  has.cohesion_beta = requires(const P p) { p.cohesion_beta; };
  has.keeps_compaction = requires(const P p) { p.keeps_compaction; };
  has.check = requires(const P p, ParameterReport& report) { p.check(report); };
  return has;
}

/// A law is made from its Parameters; the constructor throws ConfigError for parameters out of range: it reads them through `checked`
/// (base/parameter.hpp, included by the header of the law, or by a source file beside it).
template <class L>
concept Material = MaterialParameterSet<typename L::Parameters> && std::constructible_from<L, const typename L::Parameters&> &&
                       UpdatesStress<L, double> && UpdatesStress<L, Lanes> && UpdatesStress<L, LanePair> && L::has == members_of<L>() &&
                   requires(const L law) {
  { law.density() } -> std::same_as<double>;           // rho_0, kg/m^3
  { law.initial_internal() } -> std::same_as<double>;  // history variable of the stress-free reference state
  { law.wave_speed() } -> std::same_as<double>;        // c_P = sqrt((K + 4G/3)/rho_0), m/s
  { law.bulk_speed() } -> std::same_as<double>;        // sqrt(K/rho_0), m/s; 0 for a law that never bears tension
  // elastic energy per reference volume, J/m^3
  { law.stored_energy(MaterialState<double>{}) } -> std::same_as<double>;
};

/// The one parameter that all laws share.
template <class Table, class Base>
void declare_density(Table& table, double Base::*density) {
  table.add("density_kg_m3", density).unit("kg/m^3").range(1.0, 1e5).text("Initial density rho_0");
}

}  // namespace mpm
