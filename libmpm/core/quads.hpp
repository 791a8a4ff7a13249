#pragma once
/// Four quads of floats side by side in one register, put together and parted without a way through memory.

#include <type_traits>

#include "libmpm/base/lanes.hpp"

namespace mpm {

/// Four floats on a multiple of 16 bytes, whatever is there.
using AliasingQuad = float __attribute__((vector_size(16), may_alias));

/// The quads at four addresses.
inline __attribute__((always_inline)) SingleLanes join_quads(const AliasingQuad* a, const AliasingQuad* b, const AliasingQuad* c,
                                                             const AliasingQuad* d) {
#if defined(__AVX512F__)  // loads that leave the other quads alone: no shuffle
  __m512 r = _mm512_castps128_ps512(*a);
  r = _mm512_mask_broadcast_f32x4(r, 0x00F0, *b);
  r = _mm512_mask_broadcast_f32x4(r, 0x0F00, *c);
  return reinterpret_cast<SingleLanes>(_mm512_mask_broadcast_f32x4(r, 0xF000, *d));
#else
  const SingleQuad qa = *a, qb = *b, qc = *c, qd = *d;
  return from_halves<SingleLanes>(__builtin_shufflevector(qa, qb, 0, 1, 2, 3, 4, 5, 6, 7),
                                  __builtin_shufflevector(qc, qd, 0, 1, 2, 3, 4, 5, 6, 7));
#endif
}

/// Quad n of the four.
template <int n>
inline SingleQuad quad_of(const SingleLanes& v) {
  if constexpr (whole_registers) {
    return __builtin_shufflevector(v, v, 4 * n, 4 * n + 1, 4 * n + 2, 4 * n + 3);
  } else {
    return reinterpret_cast<const AliasingQuad*>(&v)[n];
  }
}

/// Calls f(std::integral_constant<int, n>) for n = 0, 1, 2, 3.
template <class F>
inline __attribute__((always_inline)) void for_each_quad(F&& f) {
  f(std::integral_constant<int, 0>{});
  f(std::integral_constant<int, 1>{});
  f(std::integral_constant<int, 2>{});
  f(std::integral_constant<int, 3>{});
}

}  // namespace mpm
