#pragma once
/// Sums over the 27 nodes of a particle's kernel, factored axis by axis, because both the weights and a linear field are: gather() sums
/// along x, then y, then z; add() distributes along z, then y, then x. V holds the particles of a group side by side, {v_x, v_y, v_z, m} of
/// each; a Node is a group of one.

#include "libmpm/core/particle_groups.hpp"

namespace mpm {

/// A node of a halo, for all particles of a group.
/// @{
template <OneRegister V>
inline const V& of_all(const V& node) {
  return node;
}
inline SingleLanes of_all(const SingleQuad& node) { return repeat_quad(node); }
/// @}

/// No prefetch during a loop over the planes of a kernel; the alternative is PrefetchGroup.
struct NoPrefetch {
  void request_rest(int /*plane*/) const {}  ///< as PrefetchGroup's
};

/// Sum w v and its first moments sum w v (i, j, k), i, j, k in 0 .. 2 counted from the base node.
template <class V>
struct Gathered {
  V v;        ///< sum w v
  V x, y, z;  ///< sums w v i, w v j, w v k
};

/// The sums of a group. @param node  base node of the particles' cell in a halo
template <class V, class HaloNode, class Prefetch>
inline __attribute__((always_inline)) Gathered<V> gather(const HaloNode* node, const BsplineWeights<V>& w, const Prefetch& prefetch) {
  const AxisWeights<V> wx = along<0>(w), wy = along<1>(w), wz = along<2>(w);
  const V wx2 = wx.w[2] + wx.w[2], wy2 = wy.w[2] + wy.w[2], wz2 = wz.w[2] + wz.w[2];
  V v[3], x[3], y[3];
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    V s[3], sx[3];
    prefetch.request_rest(k);
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const auto* row = node + halo_index(0, j, k);
      const V m = wx.w[1] * of_all(row[1]), last = of_all(row[2]);
      s[j] = wx.w[0] * of_all(row[0]) + m + wx.w[2] * last;
      sx[j] = m + wx2 * last;
    }
    const V m = wy.w[1] * s[1];
    v[k] = wy.w[0] * s[0] + m + wy.w[2] * s[2];
    y[k] = m + wy2 * s[2];
    x[k] = wy.w[0] * sx[0] + wy.w[1] * sx[1] + wy.w[2] * sx[2];
  }
  const V m = wz.w[1] * v[1];
  return {wz.w[0] * v[0] + m + wz.w[2] * v[2], wz.w[0] * x[0] + wz.w[1] * x[1] + wz.w[2] * x[2],
          wz.w[0] * y[0] + wz.w[1] * y[1] + wz.w[2] * y[2], m + wz2 * v[2]};
}

/// A linear field: a particle contributes wx_i wy_j wz_k (base + i ax + j ay + k az) to node (i, j, k) of its cell.
template <class V>
struct Linear {
  V base;        ///< at node (0, 0, 0)
  V ax, ay, az;  ///< its change from node to node along each axis
};

/// Adds the contributions of a group to the nine sums of plane k of its cell's nodes, node (i, j, k) at i + 3 j.
/// @param value  of the field at node (0, 0, k); @param wx, wy  weights along x and y; @param wz  weight of the plane
template <class V>
inline __attribute__((always_inline)) void add_plane(const Linear<V>& c, const V& value, const AxisWeights<V>& wx, const AxisWeights<V>& wy,
                                                     const V& wz, V* sum) {
  const V uy = wz * c.ay, ux = wz * c.ax;
  V value_j = wz * value;
#pragma GCC unroll 3
  for (int j = 0; j < 3; ++j) {
    const V t = wy.w[j] * value_j, tx = wy.w[j] * ux;
    const V t1 = t + tx, t2 = t1 + tx;
    V* const row = sum + 3 * j;
    row[0] += wx.w[0] * t;
    row[1] += wx.w[1] * t1;
    row[2] += wx.w[2] * t2;
    value_j += uy;
  }
}

/// Adds the contributions of a group to the 27 sums of its cell, node (i, j, k) at i + 3 j + 9 k.
template <class V>
inline __attribute__((always_inline)) void add(const Linear<V>& c, const BsplineWeights<V>& w, V (&sum)[27]) {
  const AxisWeights<V> wx = along<0>(w), wy = along<1>(w), wz = along<2>(w);
  V value = c.base;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    add_plane(c, value, wx, wy, wz.w[k], sum + 9 * k);
    value += c.az;
  }
}

/// Adds nine sums of a plane, each over the particles of a group, to the plane's nodes. @param node  the first of them in a halo
/// @{
inline __attribute__((always_inline)) void add_plane_sums(const Node* sum, Node* node) {
#pragma GCC unroll 9
  for (int n = 0; n < 9; ++n) node[halo_index(n % 3, n / 3, 0)] += sum[n];
}
inline __attribute__((always_inline)) void add_plane_sums(const Lanes* sum, Node* node) {
#pragma GCC unroll 9
  for (int n = 0; n < 9; ++n) node[halo_index(n % 3, n / 3, 0)] += lower_half(sum[n]) + upper_half(sum[n]);
}
#if defined(__AVX512F__)
/// A row of three nodes at a time; adds zero to the node behind them.
inline __attribute__((always_inline)) void add_plane_sums(const SingleLanes* sum, SingleQuad* node) {
  using UnalignedRow = float __attribute__((vector_size(64), aligned(16), may_alias));
  const auto low = [](SingleLanes a, SingleLanes b) {  // quarters 0 1 of each
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23);
  };
  const auto high = [](SingleLanes a, SingleLanes b) {  // quarters 2 3 of each
    return __builtin_shufflevector(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
  };
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
    const SingleLanes s0 = sum[3 * r], s1 = sum[3 * r + 1], s2 = sum[3 * r + 2], none{};
    const SingleLanes a = low(s0, s1) + high(s0, s1), b = low(s2, none) + high(s2, none);
    const SingleLanes even = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27);
    const SingleLanes odd = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31);
    *reinterpret_cast<UnalignedRow*>(node + halo_index(0, r, 0)) += even + odd;
  }
}
#else
/// The first two nodes of a row of three at a time.
inline __attribute__((always_inline)) void add_plane_sums(const SingleLanes* sum, SingleQuad* node) {
  using UnalignedTwo = float __attribute__((vector_size(32), aligned(16), may_alias));
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
    const SingleLanes s0 = sum[3 * r], s1 = sum[3 * r + 1];
    SingleQuad* const row = node + halo_index(0, r, 0);
    *reinterpret_cast<UnalignedTwo*>(row) +=
        __builtin_shufflevector(s0, s1, 0, 1, 2, 3, 12, 13, 14, 15) + __builtin_shufflevector(s0, s1, 4, 5, 6, 7, 8, 9, 10, 11);
    row[2] += quad_of<0>(sum[3 * r + 2]) + quad_of<1>(sum[3 * r + 2]);
  }
}
#endif
/// @}

/// Adds the 27 sums of a cell to its nodes. @param node  its base node in a halo
template <class V, class Quad>
inline __attribute__((always_inline)) void add_sums(const V (&sum)[27], Quad* node) {
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) add_plane_sums(sum + 9 * k, node + halo_index(0, 0, k));
}

}  // namespace mpm
