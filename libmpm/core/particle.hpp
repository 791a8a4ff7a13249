#pragma once
/// One material point: everything the step reads and writes, in three cache lines; and in 96 bytes, as stored by a run in single precision.
///
/// The stress is stored, not b_e: for every law here the elastic Hencky strain is a linear function of the
/// Kirchhoff stress, so that particle_to_grid needs no material and the stored numbers keep full relative
/// precision however small the strain is (b_e would lose it in 1 + 2 eps).

#include <array>
#include <cstdint>
#include <type_traits>

#include "libmpm/base/types.hpp"
#include "libmpm/core/node_index.hpp"

namespace mpm {

/// Layout is relied on by particle_groups.hpp and stress_update.cpp (offsets in doubles):
///   0 position(3) volume | 4 velocity(3) id | 8 affine(9) | 17 stress(6) | 23 internal
/// so that each cache line is one 8-lane load, and the vectors are 4-lane loads.
struct alignas(64) Particle {
  double position[3];  ///< m
  double volume;       ///< reference (initial) volume V_0, m^3; mass = rho_0 V_0
  double velocity[3];  ///< m/s
  std::uint64_t id;    ///< identity number, unique in a run, never reused; below 2^52
  double affine[9];    ///< velocity gradient C, 1/s, by columns: affine[3 j + i] = dv_i/dx_j
  double stress[6];    ///< Kirchhoff stress tau, Pa, tension positive: xx yy zz xy xz yz
  double internal;     ///< the law's internal variable (cam_clay: X = -eps_v^P, dimensionless)
};

static_assert(sizeof(Particle) == 192 && std::is_trivially_copyable_v<Particle>);

/// x, m.
inline Vec3 position_of(const Particle& p) { return {p.position[0], p.position[1], p.position[2]}; }
/// Whether position, velocity, C, stress and internal variable are finite.
[[nodiscard]] bool all_finite(const Particle& p);
/// v, m/s.
inline Vec3 velocity_of(const Particle& p) { return {p.velocity[0], p.velocity[1], p.velocity[2]}; }

/// The frame of reference of one block's records.
struct RecordFrame {
  Index3 block{};                ///< its coordinate
  double cell_size = 0.0;        ///< dx, m
  Vec3 velocity = Vec3::Zero();  ///< m/s: velocities of single records are relative to it; not used by double records
};

inline constexpr int position_bits = 27;                             ///< of the offset within a cell
inline constexpr double position_unit = 1.0 / (1 << position_bits);  ///< cells
inline constexpr std::uint64_t largest_single_id = 0xFFFFFFFF;       ///< identity numbers are 32 bits wide in a single record

/// A particle in single precision: six quads of 32-bit numbers; the kernels load and store quads. Units as in Particle.
///
/// Position. 32-bit fixed point relative to the block, in units of 2^-27 cell: the cell is the upper five bits, the offset within it the
/// lower 27. Both are exact, and a particle far from the origin is as precise as one near it.
///
/// Velocity. Relative to one velocity of the whole block (RecordFrame), which is held in double precision and renewed in every step. So
/// round-off is relative to the differences of velocity within four cells. In free flight only the block's velocity changes: small
/// increments, such as those of gravity, are not rounded away by addition to a large number.
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
