#pragma once
/// Scalars, vectors and index types shared by every header. SI units throughout.
/// Axes: x downstream, y across, z up.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

/// Everything of libmpm.
namespace mpm {

using Vec2 = Eigen::Vector2d;                ///< x, y in plan, m
using Vec3 = Eigen::Vector3d;                ///< position, velocity, force: x, y, z
using Mat3 = Eigen::Matrix3d;                ///< general 3x3 matrix (row, column)
using Index3 = std::array<std::int32_t, 3>;  ///< coordinates of a cell, node or block along x, y, z; may be negative

/// Width of a lane group: eight doubles, one AVX-512 register (two or four registers elsewhere).
inline constexpr int lane_count = 8;

}  // namespace mpm
