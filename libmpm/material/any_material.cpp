#include "libmpm/material/any_material.hpp"

#include <type_traits>
#include <utility>

namespace mpm {

namespace {

/// Calls f with the type of every law.
template <class F, std::size_t... I>
void for_each_law(F f, std::index_sequence<I...>) {
  (f.template operator()<std::variant_alternative_t<I, AnyMaterial>>(), ...);
}
constexpr auto every_law = std::make_index_sequence<std::variant_size_v<AnyMaterial>>{};

/// f(alternative), or `otherwise` where f does not accept that alternative: where the return type of f does not exist for it.
template <class R, class F>
R where_it_exists(const auto& variant, const R& otherwise, F f) {
  return std::visit(
      [&](const auto& alternative) -> R {
        if constexpr (std::is_invocable_v<F, decltype(alternative)>) return f(alternative);
        return otherwise;
      },
      variant);
}

}  // namespace

std::string_view MaterialParameters::name() const {
  return std::visit([](const auto& p) { return std::string_view(p.name); }, law);
}
std::string_view MaterialParameters::equations() const {
  return std::visit([](const auto& p) { return std::string_view(p.equations); }, law);
}
double MaterialParameters::density() const {
  return std::visit([](const auto& p) { return p.density; }, law);
}
void MaterialParameters::set_density(double density) {
  std::visit([&](auto& p) { p.density = density; }, law);
}
std::optional<double> MaterialParameters::internal_friction() const {
  return where_it_exists(law, std::optional<double>(),
                         [](const auto& p) -> decltype(p.internal_friction()) { return p.internal_friction(); });
}
std::optional<double> MaterialParameters::critical_state_ratio() const {
  return where_it_exists(law, std::optional<double>(),
                         [](const auto& p) -> decltype(p.critical_state_ratio()) { return p.critical_state_ratio(); });
}
std::optional<double> MaterialParameters::hardening_xi() const {
  return where_it_exists(law, std::optional<double>(), [](const auto& p) -> decltype(p.hardening_xi) { return p.hardening_xi; });
}
std::optional<double> MaterialParameters::cohesion_beta() const {
  return where_it_exists(law, std::optional<double>(), [](const auto& p) -> decltype(p.cohesion_beta) { return p.cohesion_beta; });
}
bool MaterialParameters::keeps_compaction() const {
  return where_it_exists(law, false, [](const auto& p) -> decltype(p.keeps_compaction) { return p.keeps_compaction; });
}

void MaterialParameters::check(ParameterReport& report) const {
  std::visit(
      [&](const auto& p) {
        if constexpr (requires { p.check(report); }) p.check(report);
      },
      law);
}

AnyMaterial make_material(const MaterialParameters& parameters, Precision states) {
  std::optional<AnyMaterial> made;
  for_each_law(
      [&]<Material L>() {
        if (const auto* p = parameters.get_if<L>()) made.emplace(L(*p));
      },
      every_law);
  if (states == Precision::single_precision) {
    std::visit(
        [](auto& law) {
          if constexpr (requires { law.expect_single_states(); }) law.expect_single_states();
        },
        *made);
  }
  return *made;
}

double density_of(const AnyMaterial& material) {
  return std::visit([](const auto& law) { return law.density(); }, material);
}
double viscosity_of(const AnyMaterial& material) {
  return where_it_exists(material, 0.0, [](const auto& law) -> decltype(law.viscosity()) { return law.viscosity(); });
}
bool keeps_compaction(const AnyMaterial& material) {
  return std::visit([]<class Law>(const Law&) { return MaterialParameters(typename Law::Parameters{}).keeps_compaction(); }, material);
}
double wave_speed_of(const AnyMaterial& material) {
  return std::visit([](const auto& law) { return law.wave_speed(); }, material);
}
double bulk_speed_of(const AnyMaterial& material) {
  return std::visit([](const auto& law) { return law.bulk_speed(); }, material);
}
double initial_internal_of(const AnyMaterial& material) {
  return std::visit([](const auto& law) { return law.initial_internal(); }, material);
}
double volume_ratio(const AnyMaterial& material, const MaterialState<double>& state) {
  return std::visit([&](const auto& law) { return law.volume_ratio(state); }, material);
}

std::vector<LawInfo> all_laws() {
  std::vector<LawInfo> laws;
  for_each_law(
      [&]<Material L>() {
        laws.push_back({std::string(L::Parameters::name), std::string(L::Parameters::description)});
      },
      every_law);
  return laws;
}

}  // namespace mpm
