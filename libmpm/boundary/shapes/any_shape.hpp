#pragma once
/// The list of obstacle shapes. To add one: write its header against the concept `ObstacleShape`, add it to this variant. Keys, contact,
/// measurements and pictures follow from its parameters and its outline.

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
  { shape.width } -> std::convertible_to<double>;        // w, m: the width that corresponds to the paper's w, as in W(xi) and w/H
  { shape.outline() } -> std::same_as<Outline>;
};

/// One shape of the list, with its parameters.
using AnyShape = std::variant<BoxShape, CylinderShape, WedgeShape>;

static_assert(ObstacleShape<BoxShape> && ObstacleShape<CylinderShape> && ObstacleShape<WedgeShape>);

}  // namespace mpm
