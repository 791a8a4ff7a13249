#pragma once
/// The vector types of the kernels, workarounds for GCC on processors whose registers are shorter, and quads of floats side by side in one
/// register, put together and parted without a way through memory.

#include <cstdint>
#include <type_traits>
#include <utility>

#include <immintrin.h>

namespace mpm {

/// What a comparison of doubles puts into a lane.
#if defined(__clang__)
using MaskInteger = long long;
#else
using MaskInteger = std::int64_t;
#endif
using Lanes = double __attribute__((vector_size(64)));          ///< eight doubles
using LaneMask = MaskInteger __attribute__((vector_size(64)));  ///< all bits set where true
using HalfLanes = double __attribute__((vector_size(32)));      ///< four lanes: a grid node {p_x, p_y, p_z, m}
using HalfMask = MaskInteger __attribute__((vector_size(32)));  ///< all bits set where true

/// Whether the processor has registers of 64 bytes.
#if defined(__AVX512F__)
inline constexpr bool whole_registers = true;
#else
inline constexpr bool whole_registers = false;
#endif

/// As many floats as a register holds: sixteen, or eight where registers are shorter. GCC moves a vector that is longer than a register
/// through memory.
using SingleLanes = float __attribute__((vector_size(whole_registers ? 64 : 32)));
using SingleLaneMask = std::int32_t __attribute__((vector_size(sizeof(SingleLanes))));  ///< all bits set where true; or as many integers
using SingleQuad = float __attribute__((vector_size(16)));  ///< four lanes: a node's {p_x, p_y, p_z, m} in single precision
/// Doubles in such a register.
using DoubleLanes = std::conditional_t<whole_registers, Lanes, HalfLanes>;

/// A processor without registers of 64 bytes does arithmetic on Lanes by halves, but GCC takes comparisons, selections and shuffles of
/// them apart number by number. So these are written for one half, and by_halves() applies them to both.
namespace detail {
template <class V>
struct HalfType;
template <>
struct HalfType<Lanes> {
  using type = double __attribute__((vector_size(32), may_alias));
};
template <>
struct HalfType<LaneMask> {
  using type = MaskInteger __attribute__((vector_size(32), may_alias));
};
}  // namespace detail
/// The type of half a register.
template <class V>
using HalfOf = typename detail::HalfType<V>::type;
/// Half n of a register. @param n  0: the lower lanes, 1: the upper ones
template <class V>
inline __attribute__((always_inline)) const HalfOf<V>& half(const V& v, int n) {
  return reinterpret_cast<const HalfOf<V>*>(&v)[n];
}
/// The register with these halves.
template <class V>
inline __attribute__((always_inline)) V from_halves(HalfOf<V> low, HalfOf<V> high) {
  V v;
  auto* const to = reinterpret_cast<HalfOf<V>*>(&v);
  to[0] = low;
  to[1] = high;
  return v;
}
/// f(whole registers), or f(the halves of each) where registers are shorter than a Result. @tparam Result  of the whole
template <class Result, class F, class... V>
inline __attribute__((always_inline)) Result by_halves(F&& f, const V&... v) {
  if constexpr (whole_registers || sizeof(Result) <= sizeof(HalfLanes)) {
    return f(v...);
  } else {
    return from_halves<Result>(f(half(v, 0)...), f(half(v, 1)...));
  }
}
/// Shuffles both halves alike, or a register that is a half itself.
/// @tparam index  as of __builtin_shufflevector for one half: those of `a`, then those of `b`
template <int... index, class V>
inline __attribute__((always_inline)) V shuffle_halves(const V& a, const V& b) {
  constexpr int n = sizeof...(index);
  if constexpr (sizeof(V) == sizeof(HalfLanes)) {
    return __builtin_shufflevector(a, b, index...);
  } else if constexpr (whole_registers) {
    return __builtin_shufflevector(a, b, (index < n ? index : index + n)..., (index < n ? index + n : index + 2 * n)...);
  } else {
    return from_halves<V>(__builtin_shufflevector(half(a, 0), half(b, 0), index...),
                          __builtin_shufflevector(half(a, 1), half(b, 1), index...));
  }
}

/// Four floats on a multiple of 16 bytes, whatever is there.
using AliasingQuad = float __attribute__((vector_size(16), may_alias));

/// How many quads a register holds: four or two.
inline constexpr int quad_count = sizeof(SingleLanes) / sizeof(SingleQuad);

/// The same quad in all places.
inline SingleLanes repeat_quad(const SingleQuad& n) {
#if defined(__AVX512F__)  // from memory a load does it; of a shuffle GCC makes a load and a shuffle
  return reinterpret_cast<SingleLanes>(_mm512_broadcast_f32x4(n));
#else
  return __builtin_shufflevector(n, n, 0, 1, 2, 3, 0, 1, 2, 3);
#endif
}

/// The quads at some addresses. @param at  at(n) is the address of quad n
template <class At>
inline __attribute__((always_inline)) SingleLanes join_quads(At&& at) {
#if defined(__AVX512F__)  // loads that leave the other quads alone: no shuffle
  __m512 r = _mm512_castps128_ps512(*at(0));
  r = _mm512_mask_broadcast_f32x4(r, 0x00F0, *at(1));
  r = _mm512_mask_broadcast_f32x4(r, 0x0F00, *at(2));
  return reinterpret_cast<SingleLanes>(_mm512_mask_broadcast_f32x4(r, 0xF000, *at(3)));
#else
  const SingleQuad low = *at(0), high = *at(1);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}

/// Quad n of a register.
template <int n>
inline SingleQuad quad_of(const SingleLanes& v) {
  return __builtin_shufflevector(v, v, 4 * n, 4 * n + 1, 4 * n + 2, 4 * n + 3);
}

/// Calls f(std::integral_constant<int, n>) for every quad n of a register.
template <class F>
inline __attribute__((always_inline)) void for_each_quad(F&& f) {
  [&]<int... n>(std::integer_sequence<int, n...>) __attribute__((always_inline)) { (f(std::integral_constant<int, n>{}), ...); }
  (std::make_integer_sequence<int, quad_count>{});
}

}  // namespace mpm
