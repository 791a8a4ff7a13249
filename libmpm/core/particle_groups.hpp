#pragma once
/// Common parts of both transfers: groups of particles of one cell in one register, four lanes each.
/// A Group is made for each kind of record, and the transfers are templates over it:
///   Group<Particle>      two particles in a Lanes,        {a_0 .. a_3 | b_0 .. b_3}; or one in a HalfLanes, where registers are shorter
///   Group<SingleRecord>  four particles in a SingleLanes, {a_0 .. a_3 | b_0 .. b_3 | c_0 .. c_3 | d_0 .. d_3}; or two, where registers are
///   shorter
/// For the sources of the transfers and of corrections that sum as they do.

#include <array>
#include <bit>
#include <concepts>
#include <type_traits>

#include "libmpm/base/bspline.hpp"
#include "libmpm/base/lanes.hpp"
#include "libmpm/base/registers.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

/// Four doubles without alignment.
using UnalignedHalf = double __attribute__((vector_size(32), aligned(8), may_alias));
/// Four doubles from any address.
inline HalfLanes load_half(const double* p) { return *reinterpret_cast<const UnalignedHalf*>(p); }
/// Four doubles to any address.
inline void store_half(double* p, HalfLanes v) { *reinterpret_cast<UnalignedHalf*>(p) = v; }

/// The same quad for all particles.
template <class V>
inline V repeat(HalfLanes n) {
  if constexpr (std::same_as<V, Lanes>) {
    return join(n, n);
  } else {
    return n;
  }
}

/// Component c of each particle in all four of its lanes.
/// @{
template <int c>
inline Lanes spread(const Lanes& v) {
  return shuffle_halves<c, c, c, c>(v, v);
}
template <int c>
inline HalfLanes spread(const HalfLanes& v) {
  return __builtin_shufflevector(v, v, c, c, c, c);
}
template <int c>
inline SingleLanes spread(const SingleLanes& v) {
  return shuffle_halves<c, c, c, c, 4 + c, 4 + c, 4 + c, 4 + c>(v, v);
}
/// @}

/// The columns of C and of tau, for all particles of a group; lane 3 is to be ignored.
template <class V>
struct TensorColumns {
  V cx, cy, cz;  ///< columns of C
  V tx, ty, tz;  ///< columns of tau
};

template <class Record>
struct Group;

/// {a, b, c, d} in every quad of a register.
template <class V>
constexpr V repeated(int a, int b, int c, int d) {
  using Number = std::remove_cvref_t<decltype(V{}[0])>;
  const auto w = Number(a), x = Number(b), y = Number(c), z = Number(d);
  if constexpr (quad_count == 2) {
    return V{w, x, y, z, w, x, y, z};
  } else {
    return V{w, x, y, z, w, x, y, z, w, x, y, z, w, x, y, z};
  }
}

/// Two particles in double precision. A lone one is beside padding, or beside itself.
struct ParticlePair {
  using Vector = Lanes;                                           ///< of all particles
  using Quad = HalfLanes;                                         ///< of one particle
  static constexpr int size = 2;                                  ///< particles
  static constexpr Lanes xyz = {1, 1, 1, 0, 1, 1, 1, 0};          ///< 1 in the lanes of a vector, 0 in the fourth
  static constexpr Lanes unit_x = {1, 0, 0, 0, 1, 0, 0, 0};       ///< 1 in the lanes of x
  static constexpr Lanes unit_y = {0, 1, 0, 0, 0, 1, 0, 0};       ///< 1 in the lanes of y
  static constexpr Lanes unit_z = {0, 0, 1, 0, 0, 0, 1, 0};       ///< 1 in the lanes of z
  static constexpr LaneMask mask_w = {0, 0, 0, -1, 0, 0, 0, -1};  ///< the fourth lanes

  const Particle* p[size];  ///< the particles

  [[nodiscard]] Lanes position() const { return join(load_half(p[0]->position), load_half(p[1]->position)); }  ///< x y z V
  [[nodiscard]] Lanes velocity() const { return join(load_half(p[0]->velocity), load_half(p[1]->velocity)); }  ///< lane 3: of no meaning
  /// C and tau.
  [[nodiscard]] TensorColumns<Lanes> tensors() const {
    const Particle &a = *p[0], &b = *p[1];
    const Lanes sa = *reinterpret_cast<const Lanes*>(a.affine + 8),
                sb = *reinterpret_cast<const Lanes*>(b.affine + 8);  // c8 xx yy zz xy xz yz h
    return {join(load_half(a.affine), load_half(b.affine)),
            join(load_half(a.affine + 3), load_half(b.affine + 3)),
            join(load_half(a.affine + 6), load_half(b.affine + 6)),
            __builtin_shufflevector(sa, sb, 1, 4, 5, 0, 9, 12, 13, 8),
            __builtin_shufflevector(sa, sb, 4, 2, 6, 0, 12, 10, 14, 8),
            __builtin_shufflevector(sa, sb, 5, 6, 3, 0, 13, 14, 11, 8)};
  }
  /// @param to  where each goes; @param x lane 3: the volume; @param cx,cy,cz columns of the affine matrix. Reads the previous values.
  static inline __attribute__((always_inline)) void store(Particle* const (&to)[size], const ParticlePair& from, Lanes x, Lanes v, Lanes cx,
                                                          Lanes cy, Lanes cz) {
    Particle &a = *to[0], &b = *to[1];
    v = select(mask_w, from.velocity(), v);  // lane 3: the identity number
    store_half(a.position, lower_half(x));
    store_half(b.position, upper_half(x));
    store_half(a.velocity, lower_half(v));
    store_half(b.velocity, upper_half(v));
    const double keep_a = a.stress[0], keep_b = b.stress[0];  // the store of column z reaches one double too far
    store_half(a.affine, lower_half(cx));
    store_half(b.affine, upper_half(cx));
    store_half(a.affine + 3, lower_half(cy));
    store_half(b.affine + 3, upper_half(cy));
    store_half(a.affine + 6, lower_half(cz));
    store_half(b.affine + 6, upper_half(cz));
    a.stress[0] = keep_a;
    b.stress[0] = keep_b;
  }
  /// The largest of the lanes that hold a speed.
  static double largest(Lanes speed_squared) { return max(speed_squared[0], speed_squared[4]); }
  /// Cells along x, y and z of each particle, a byte each; limited to the range of a byte.
  static std::array<std::uint32_t, size> bytes_of(LaneMask cells) {
    const std::uint64_t bytes = saturated_bytes(cells);
    return {static_cast<std::uint32_t>(bytes), static_cast<std::uint32_t>(bytes >> 32)};
  }
};

/// One particle in double precision.
struct LoneParticle {
  using Vector = HalfLanes;                          ///< of the particle
  using Quad = HalfLanes;                            ///< of one particle
  static constexpr int size = 1;                     ///< particles
  static constexpr HalfLanes xyz = {1, 1, 1, 0};     ///< 1 in the lanes of a vector, 0 in the fourth
  static constexpr HalfLanes unit_x = {1, 0, 0, 0};  ///< 1 in the lane of x
  static constexpr HalfLanes unit_y = {0, 1, 0, 0};  ///< 1 in the lane of y
  static constexpr HalfLanes unit_z = {0, 0, 1, 0};  ///< 1 in the lane of z
  static constexpr HalfMask mask_w = {0, 0, 0, -1};  ///< the fourth lane

  const Particle* p[size];  ///< the particle

  [[nodiscard]] HalfLanes position() const { return load_half(p[0]->position); }  ///< x y z V
  [[nodiscard]] HalfLanes velocity() const { return load_half(p[0]->velocity); }  ///< lane 3: of no meaning
  /// C and tau.
  [[nodiscard]] TensorColumns<HalfLanes> tensors() const {
    const double* const c = p[0]->affine;
    const HalfLanes s = load_half(c + 8), t = load_half(c + 12);  // c8 xx yy zz, xy xz yz h
    return {load_half(c),
            load_half(c + 3),
            load_half(c + 6),
            __builtin_shufflevector(s, t, 1, 4, 5, 0),
            __builtin_shufflevector(s, t, 4, 2, 6, 0),
            __builtin_shufflevector(s, t, 5, 6, 3, 0)};
  }
  /// As ParticlePair::store.
  static inline __attribute__((always_inline)) void store(Particle* const (&to)[size], const LoneParticle& from, HalfLanes x, HalfLanes v,
                                                          HalfLanes cx, HalfLanes cy, HalfLanes cz) {
    Particle& a = *to[0];
    store_half(a.position, x);
    store_half(a.velocity, select(mask_w, from.velocity(), v));  // lane 3: the identity number
    const double keep = a.stress[0];                             // the store of column z reaches one double too far
    store_half(a.affine, cx);
    store_half(a.affine + 3, cy);
    store_half(a.affine + 6, cz);
    a.stress[0] = keep;
  }
  /// The lane that holds a speed.
  static double largest(HalfLanes speed_squared) { return speed_squared[0]; }
  /// As ParticlePair::bytes_of.
  static std::array<std::uint32_t, size> bytes_of(HalfMask cells) { return {saturated_bytes(cells)}; }
};

/// Particles in double precision: as many as a register holds. GCC moves what is longer than a register through memory.
template <>
struct Group<Particle> : std::conditional_t<whole_registers, ParticlePair, LoneParticle> {};

/// Particles in single precision: as many as a register holds.
template <>
struct Group<SingleRecord> {
  using Vector = SingleLanes;                                                      ///< of all particles
  using Quad = SingleQuad;                                                         ///< of one particle
  static constexpr int size = quad_count;                                          ///< particles
  static constexpr SingleLanes xyz = repeated<SingleLanes>(1, 1, 1, 0);            ///< 1 in the lanes of a vector, 0 in the fourth
  static constexpr SingleLanes unit_x = repeated<SingleLanes>(1, 0, 0, 0);         ///< 1 in the lanes of x
  static constexpr SingleLanes unit_y = repeated<SingleLanes>(0, 1, 0, 0);         ///< 1 in the lanes of y
  static constexpr SingleLanes unit_z = repeated<SingleLanes>(0, 0, 1, 0);         ///< 1 in the lanes of z
  static constexpr SingleLaneMask mask_w = repeated<SingleLaneMask>(0, 0, 0, -1);  ///< the fourth lanes

  const SingleRecord* p[size];  ///< the particles

  /// Quad n of all particles. @param n  0 position, 1 velocity, 2 3 4 columns of C with the normal stresses, 5 shear stresses
  template <int n>
  [[nodiscard]] SingleLanes quad() const {
    return join_quads([&](int i) { return reinterpret_cast<const AliasingQuad*>(p[i]) + n; });
  }
  [[nodiscard]] SingleLanes position() const { return quad<0>(); }  ///< x y z as integers, V as a number
  [[nodiscard]] SingleLanes velocity() const { return quad<1>(); }  ///< lane 3: of no meaning
  /// C and tau.
  [[nodiscard]] TensorColumns<SingleLanes> tensors() const {
    const SingleLanes cx = quad<2>(), cy = quad<3>(), cz = quad<4>(), s = quad<5>();  // s: xy xz yz h
    return {cx,
            cy,
            cz,
            shuffle_halves<3, 8, 9, 3, 7, 12, 13, 7>(cx, s),
            shuffle_halves<8, 3, 10, 3, 12, 7, 14, 7>(cy, s),
            shuffle_halves<9, 10, 3, 3, 13, 14, 7, 7>(cz, s)};
  }
  /// @param to  where each goes; @param x lane 3: the volume; @param cx,cy,cz columns of the affine matrix
  static inline __attribute__((always_inline)) void store(SingleRecord* const (&to)[size], const Group& /*from*/, SingleLanes x,
                                                          SingleLanes v, SingleLanes cx, SingleLanes cy, SingleLanes cz) {
    store_quads<0>(to, x);
    store_vectors<1>(to, v);
    store_vectors<2>(to, cx);
    store_vectors<3>(to, cy);
    store_vectors<4>(to, cz);
  }
  /// The largest of the lanes that hold a speed.
  static double largest(SingleLanes speed_squared) {
    float most = speed_squared[0];
    for (int i = 1; i < size; ++i) most = max(most, speed_squared[4 * i]);
    return double{most};
  }
  /// Cells along x, y and z of each particle, a byte each; limited to the range of a byte.
  static std::array<std::uint32_t, size> bytes_of(SingleLaneMask cells) { return saturated_bytes(cells); }

 private:
  static float max(float a, float b) { return a > b ? a : b; }
  template <int n>
  static inline __attribute__((always_inline)) void store_quads(SingleRecord* const (&to)[size], SingleLanes v) {
    for_each_quad([&](auto i) { reinterpret_cast<AliasingQuad*>(to[i])[n] = quad_of<i>(v); });
  }
  /// Keeps the fourth number of each quad.
  template <int n>
  static inline __attribute__((always_inline)) void store_vectors(SingleRecord* const (&to)[size], SingleLanes v) {
    for_each_quad([&](auto i) {
      const SingleQuad q = quad_of<i>(v);
#if defined(__AVX512VL__)
      _mm_mask_store_ps(reinterpret_cast<AliasingQuad*>(to[i]) + n, 7, q);
#else
      AliasingQuad& kept = reinterpret_cast<AliasingQuad*>(to[i])[n];
      kept = __builtin_shufflevector(q, SingleQuad(kept), 0, 1, 2, 7);
#endif
    });
  }
};

/// The three weights along an axis: of each node, for all particles of a group, in all components.
template <class V>
struct AxisWeights {
  V w[3];  ///< of nodes base, base + 1, base + 2
};
/// The weights of one axis out of those of all three.
template <int axis, class V>
inline AxisWeights<V> along(const BsplineWeights<V>& w) {
  return {{spread<axis>(w.n0), spread<axis>(w.n1), spread<axis>(w.n2)}};
}

/// Prefetches the group 16 places ahead in cell order (in the next bin if needed), because the hardware cannot predict it: one or
/// two cache lines at a time during the work on another group, because a core has some 16 outstanding loads. Its functions are inlined
/// always: GCC takes one that only prefetches for one without effect, and removes the calls that it has not inlined.
template <class Record>
class PrefetchGroup {
 public:
  PrefetchGroup() = default;  ///< no addresses: to be assigned before it is used
  /// Looks up the addresses; reads no particle.
  PrefetchGroup(const ParticleBin& bin, const ParticleBin& next, int n) {
    const int count = bin.count(), next_last = next.count() - 1;
    const auto place = [&](int m) {
      if (m < count) [[likely]]
        return reinterpret_cast<const char*>(&bin.record<Record>(bin.order[static_cast<std::size_t>(m)]));
      return reinterpret_cast<const char*>(
          &next.record<Record>(next.order[static_cast<std::size_t>(m - count < next_last ? m - count : next_last)]));
    };
#pragma GCC unroll 4
    for (int i = 0; i < size; ++i) at_[i] = place(n + 16 + i);
  }
  /// Requests the first line of each.
  __attribute__((always_inline)) void request_first() const {
#pragma GCC unroll 4
    for (int i = 0; i < size; ++i) __builtin_prefetch(at_[i]);
  }
  /// Requests the other lines, in three portions. @param k 0, 1, 2
  __attribute__((always_inline)) void request_rest(int k) const {
    if constexpr (std::same_as<Record, Particle>) {  // two more lines each
      if (k < 2) __builtin_prefetch(at_[0] + 64 * (k + 1));
      if (size > 1 && k > 0) __builtin_prefetch(at_[size - 1] + 64 * k);
    } else if (k < 2) {  // one more: 96 bytes on a multiple of 32 lie in two lines
#pragma GCC unroll 2
      for (int i = 0; i < size / 2; ++i) __builtin_prefetch(at_[size / 2 * k + i] + 64);
    }
  }

 private:
  static constexpr int size = Group<Record>::size;
  const char* at_[size];
};

/// Groups that a transfer takes through its passes together: those of 32 particles.
template <class Record>
inline constexpr int batch_of = 32 / Group<Record>::size;

/// A particle without mass: fills a group when a cell does not.
template <class Record>
inline const Record padding_record{};

/// The group at order[n], padded from `end` on.
template <class Record>
inline __attribute__((always_inline)) Group<Record> group_at(const ParticleBin& bin, int n, int end) {
  Group<Record> g;
#pragma GCC unroll 4
  for (int i = 0; i < Group<Record>::size; ++i)
    g.p[i] = i == 0 || n + i < end ? &bin.record<Record>(bin.order[static_cast<std::size_t>(n + i)]) : &padding_record<Record>;
  return g;
}

/// Corner of a cell in grid coordinates, for each particle of a group; lane 3 is zero.
template <class V>
inline V cell_corner(const Index3& block, int cell) {
  const auto [x, y, z] = node_index(block, cell);
  return repeat<V>(HalfLanes{1.0 * x, 1.0 * y, 1.0 * z, 0.0});
}

/// Offsets of particles from the base node of their cell, in cells.
/// @{
template <class Record>
class CellOffset;
/// From positions in m.
template <>
class CellOffset<Particle> {
 public:
  using Vector = Group<Particle>::Vector;  ///< of all particles of a group
  /// Of one cell. @param cell  x + 4 y + 16 z
  CellOffset(const Grid& grid, const Index3& block, int cell)
      : inverse_dx_(grid.inverse_cell_size()), corner_(cell_corner<Vector>(block, cell)) {}
  /// In [1/2, 3/2]; lane 3 is of no meaning.
  [[nodiscard]] Vector operator()(Vector position) const { return position * inverse_dx_ - corner_; }

 private:
  double inverse_dx_;
  Vector corner_;
};
/// From positions in fixed point, which hold the offset from the cell's edge.
template <>
class CellOffset<SingleRecord> {
 public:
  /// Of any cell.
  CellOffset(const Grid& /*grid*/, const Index3& /*block*/, int /*cell*/) {}
  /// In [1/2, 3/2]; lane 3 is of no meaning.
  [[nodiscard]] SingleLanes operator()(SingleLanes position) const {
    const SingleLaneMask within = std::bit_cast<SingleLaneMask>(position) & ((1 << position_bits) - 1);
    return __builtin_convertvector(within, SingleLanes) * static_cast<float>(position_unit) + 0.5F;
  }
};
/// @}

}  // namespace mpm
