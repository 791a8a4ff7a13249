#include "mpm/materials/any_material.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "mpm/error.hpp"

namespace mpm {

namespace {

template <class F, std::size_t... I>
void for_each_law(F f, std::index_sequence<I...>) {
  (f.template operator()<std::variant_alternative_t<I, AnyMaterial>>(), ...);
}
constexpr auto all_laws = std::make_index_sequence<std::variant_size_v<AnyMaterial>>{};

}  // namespace

AnyMaterial make_material(const MaterialSpec& spec) {
  std::optional<AnyMaterial> made;
  for_each_law(
      [&]<Material L>() {
        if (L::name == spec.model) made.emplace(L(spec));
      },
      all_laws);
  if (!made) {
    std::string known;
    for (const std::string& name : material_names()) known += (known.empty() ? "" : ", ") + name;
    throw ConfigError(fmt::format("[material] model = \"{}\": no such law; known: {}", spec.model, known));
  }
  return *made;
}

double density_of(const AnyMaterial& material) {
  return std::visit([](const auto& law) { return law.density(); }, material);
}
double viscosity_of(const AnyMaterial& material) {
  const auto* fluid = std::get_if<WeaklyCompressibleFluid>(&material);
  return fluid == nullptr ? 0.0 : fluid->viscosity();
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

std::vector<std::string> material_names() {
  std::vector<std::string> names;
  for_each_law([&]<Material L>() { names.emplace_back(L::name); }, all_laws);
  return names;
}

}  // namespace mpm
