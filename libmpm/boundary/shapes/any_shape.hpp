#pragma once
/// The list of obstacle shapes. To add one: write its header against the concept `ObstacleShape`, add it to AnyShape. Keys, contact,
/// measurements and pictures follow from its parameters and its outline, the numerical uncertainty from its front.

#include <concepts>
#include <string_view>
#include <variant>

#include "libmpm/boundary/shapes/box.hpp"
#include "libmpm/boundary/shapes/cylinder.hpp"
#include "libmpm/boundary/shapes/wedge.hpp"

namespace mpm {

/// A shape is a struct of its parameters; `declare` (base/parameter.hpp) defines their keys.
template <class S>
concept ObstacleShape = std::default_initializable<S> && std::equality_comparable<S> && requires(const S shape) {
  { S::name } -> std::convertible_to<std::string_view>;  // value of [obstacle] shape
  { S::front } -> std::convertible_to<Front>;            // how it meets the flow
  { shape.width } -> std::convertible_to<double>;        // w, m: the width that corresponds to the paper's w, as in W(xi) and w/H
  { shape.outline() } -> std::same_as<Outline>;
};

namespace detail {
template <ObstacleShape... S>
using OneOfShapes = std::variant<S...>;
}  // namespace detail

/// One shape of the list, with its parameters.
using AnyShape = detail::OneOfShapes<BoxShape, CylinderShape, WedgeShape>;

/// Its cross-section in plan.
[[nodiscard]] inline Outline outline_of(const AnyShape& shape) {
  return std::visit([](const auto& s) { return s.outline(); }, shape);
}

}  // namespace mpm
