#pragma once
/// A particle in 96 bytes, as stored by a run in single precision.
///
/// Position. 32-bit fixed point relative to the block, in units of 2^-27 cell: the cell is the upper five bits, the offset within it the
/// lower 27. Both are exact, and a particle far from the origin is as precise as one near it.
///
/// Velocity. Relative to one velocity of the whole block (RecordFrame), which is held in double precision and renewed in every step. So
/// round-off is relative to the differences of velocity within four cells. In free flight only the block's velocity changes: small
/// increments, such as those of gravity, are not rounded away by addition to a large number.

#include <array>
#include <cstdint>
#include <type_traits>

#include "libmpm/base/types.hpp"
#include "libmpm/core/node_index.hpp"
#include "libmpm/core/particle.hpp"

namespace mpm {

/// The frame of reference of one block's records.
struct RecordFrame {
  Index3 block{};                ///< its coordinate
  double cell_size = 0.0;        ///< dx, m
  Vec3 velocity = Vec3::Zero();  ///< m/s: velocities of single records are relative to it; not used by double records
};

inline constexpr int position_bits = 27;                             ///< of the offset within a cell
inline constexpr double position_unit = 1.0 / (1 << position_bits);  ///< cells
inline constexpr std::uint64_t largest_single_id = 0xFFFFFFFF;       ///< identity numbers are 32 bits wide in a single record

/// Six quads of 32-bit numbers; the kernels load and store quads. Units as in Particle.
struct alignas(32) SingleRecord {
  std::array<std::int32_t, 3> position;  ///< (x/dx - 1/2 - first_node(block)) 2^27: 0 where the first cell of the block begins
  float volume;                          ///< V_0
  std::array<float, 3> velocity;         ///< relative to RecordFrame::velocity
  std::uint32_t id;                      ///< identity number
  std::array<float, 3> affine_x;         ///< first column of C
  float stress_xx;                       ///< of tau
  std::array<float, 3> affine_y;         ///< second column of C
  float stress_yy;                       ///< of tau
  std::array<float, 3> affine_z;         ///< third column of C
  float stress_zz;                       ///< of tau
  std::array<float, 3> stress_shear;     ///< of tau: xy xz yz
  float internal;                        ///< the law's internal variable
};
static_assert(sizeof(SingleRecord) == 96 && std::is_trivially_copyable_v<SingleRecord>);

/// Position of a record, m; exact except for its last bit. @{
inline Vec3 position_of(const SingleRecord& r, const RecordFrame& frame) {
  const auto along = [&](std::size_t axis) {
    return (first_node(frame.block[axis]) + 0.5 + position_unit * r.position[axis]) * frame.cell_size;
  };
  return {along(0), along(1), along(2)};
}
inline Vec3 position_of(const Particle& r, const RecordFrame& /*frame*/) { return position_of(r); }
/// @}

/// The particle of a record, exact except for the last bit of position and velocity. @{
Particle decode(const SingleRecord& r, const RecordFrame& frame);
inline const Particle& decode(const Particle& r, const RecordFrame& /*frame*/) { return r; }
/// @}

/// The record of a particle. A position is rounded within its cell, so that rounding never moves it to another cell.
/// @param cell  local base node x + 4 y + 16 z, or ParticleBin::left_block: then it may be anywhere within reach of a step
/// @throws ConfigError if the identity number is above largest_single_id
void encode(const Particle& p, int cell, const RecordFrame& frame, SingleRecord& r);
/// The particle itself is its record in double precision.
inline void encode(const Particle& p, int /*cell*/, const RecordFrame& /*frame*/, Particle& r) { r = p; }

/// Bytes of a stored particle.
constexpr std::size_t record_bytes(Precision precision) {
  return precision == Precision::single_precision ? sizeof(SingleRecord) : sizeof(Particle);
}

/// Calls f with a value of the type that a run stores (Particle or SingleRecord): how a kernel, a template over that type, is chosen.
template <class F>
decltype(auto) with_record_type(Precision precision, F&& f) {
  return precision == Precision::single_precision ? f(SingleRecord{}) : f(Particle{});
}

}  // namespace mpm
