#pragma once
/// Quads of floats side by side in one register, put together and parted without a way through memory.

#include <type_traits>
#include <utility>

#include "libmpm/base/lanes.hpp"

namespace mpm {

/// Four floats on a multiple of 16 bytes, whatever is there.
using AliasingQuad = float __attribute__((vector_size(16), may_alias));

/// How many quads a register holds: four or two.
inline constexpr int quad_count = lanes_of<SingleLanes> / 4;

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
