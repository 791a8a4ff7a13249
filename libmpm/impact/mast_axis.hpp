#pragma once
/// The axis of a mast's overturning moment.

#include "libmpm/boundary/obstacle_spec.hpp"

namespace mpm {

/// x of the mast's own vertical axis, m: the centre of the area of its plan (every shape is centred at y = 0). Half the depth of a box,
/// the radius of a cylinder, two thirds of the depth of a wedge.
[[nodiscard]] double mast_axis(const ObstacleSpec& mast);

}  // namespace mpm
