#pragma once
/// Scalars, vectors and index types shared by every header. SI units throughout.
/// Axes: x downstream, y across, z up.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

namespace mpm {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Index3 = std::array<std::int32_t, 3>;

/// Width of a lane group: eight doubles, one AVX-512 register (two or four registers elsewhere).
inline constexpr int lane_count = 8;

}  // namespace mpm
