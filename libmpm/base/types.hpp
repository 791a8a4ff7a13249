#pragma once
/// Scalars, vectors and index types shared by every header. SI units throughout.
/// Axes: x downstream, y across, z up.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>

/// Everything of libmpm.
namespace mpm {

using Vec2 = Eigen::Vector2d;                ///< x, y in plan, m
using Vec3 = Eigen::Vector3d;                ///< position, velocity, force: x, y, z
using Mat3 = Eigen::Matrix3d;                ///< general 3x3 matrix (row, column)
using Index3 = std::array<std::int32_t, 3>;  ///< coordinates of a cell, node or block along x, y, z; may be negative

/// Mirror planes of a domain: only x >= 0 (y >= 0) is computed.
struct MirrorPlanes {
  bool x = false, y = false;  ///< plane x = 0, plane y = 0
  bool operator==(const MirrorPlanes&) const = default;

  /// Whether there is a plane across an axis, 0 or 1 (2: there is none).
  [[nodiscard]] bool across(int axis) const { return axis == 0 ? x : axis == 1 && y; }
  /// Parts of the whole domain for each computed one: 1, 2 or 4.
  [[nodiscard]] double parts() const { return (x ? 2.0 : 1.0) * (y ? 2.0 : 1.0); }
};

/// Bounds of the values in a case: wide enough for any laboratory or mountain, and narrow enough that volumes, counts and energies cannot
/// overflow.
/// @{
inline constexpr double longest_length = 1e5;  ///< m, of a length or a coordinate
inline constexpr double fastest_speed = 1e3;   ///< m/s
/// @}

/// Of the stored particles and of arithmetic on them. Nodes, boundaries and sums always have double precision.
enum class Precision : std::uint8_t {
  double_precision,  ///< 192 bytes a particle
  single_precision,  ///< 96 bytes a particle
};

/// As in cases and files.
constexpr std::string_view name_of(Precision precision) { return precision == Precision::single_precision ? "single" : "double"; }

}  // namespace mpm
