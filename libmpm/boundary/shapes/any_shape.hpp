#pragma once
/// The list of obstacle shapes. To add one: write its header against the concept `ObstacleShape`, add it to AnyShape, add a typical one to
/// tests/support/typical_shapes.hpp. Keys, contact, measurements and pictures follow from its parameters and its outline, the numerical
/// uncertainty from its front.

#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "libmpm/boundary/shapes/box.hpp"
#include "libmpm/boundary/shapes/cylinder.hpp"
#include "libmpm/boundary/shapes/wedge.hpp"

namespace mpm {

/// A shape is a struct of its parameters; `declare` (base/parameter.hpp) defines their keys.
template <class S>
concept ObstacleShape = std::default_initializable<S> && std::equality_comparable<S> && requires(const S shape) {
  { S::name } -> std::convertible_to<std::string_view>;         // value of [obstacle] shape
  { S::description } -> std::convertible_to<std::string_view>;  // some words for the reference of [obstacle] shape
  { shape.front() } -> std::same_as<Front>;                     // how it meets the flow
  { shape.width } -> std::convertible_to<double>;               // w, m: the width that corresponds to the paper's w, as in W(xi) and w/H
  { shape.outline() } -> std::same_as<Outline>;
};

/// One shape of the list, with its parameters.
using AnyShape = std::variant<BoxShape, CylinderShape, WedgeShape>;

/// Name and description of every shape, for the reference of keys: "box: rectangle in plan; cylinder: ...".
[[nodiscard]] inline std::string shape_descriptions() {
  std::string all;
  const auto append = [&]<class S>(std::type_identity<S>) {
    all += (all.empty() ? "" : "; ") + std::string(S::name) + ": " + std::string(S::description);
  };
  [&]<class... S>(std::type_identity<std::variant<S...>>) { (append(std::type_identity<S>{}), ...); }(std::type_identity<AnyShape>{});
  return all;
}

/// Its cross-section in plan.
[[nodiscard]] inline Outline outline_of(const AnyShape& shape) {
  return std::visit([](const auto& s) { return s.outline(); }, shape);
}

}  // namespace mpm
