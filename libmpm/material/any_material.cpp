#include "libmpm/material/any_material.hpp"

#include <utility>

namespace mpm {

namespace {

/// Calls f with the type of every law.
template <class F, std::size_t... I>
void for_each_law(F f, std::index_sequence<I...>) {
  (f.template operator()<std::variant_alternative_t<I, AnyMaterial>>(), ...);
}
constexpr auto every_law = std::make_index_sequence<std::variant_size_v<AnyMaterial>>{};

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
  return std::visit(
      [](const auto& p) -> std::optional<double> {
        if constexpr (requires { p.internal_friction(); }) return p.internal_friction();
        return std::nullopt;
      },
      law);
}
std::optional<double> MaterialParameters::critical_state_ratio() const {
  return std::visit(
      [](const auto& p) -> std::optional<double> {
        if constexpr (requires { p.critical_state_ratio(); }) return p.critical_state_ratio();
        return std::nullopt;
      },
      law);
}
std::optional<double> MaterialParameters::hardening_xi() const {
  return std::visit(
      [](const auto& p) -> std::optional<double> {
        if constexpr (requires { p.hardening_xi; }) return p.hardening_xi;
        return std::nullopt;
      },
      law);
}
bool MaterialParameters::keeps_compaction() const {
  return std::visit(
      [](const auto& p) {
        if constexpr (requires { p.keeps_compaction; }) return p.keeps_compaction;
        return false;
      },
      law);
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
  return std::visit(
      [](const auto& law) {
        if constexpr (requires { law.viscosity(); }) return law.viscosity();
        return 0.0;
      },
      material);
}
double wave_speed_of(const AnyMaterial& material) {
  return std::visit([](const auto& law) { return law.wave_speed(); }, material);
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
