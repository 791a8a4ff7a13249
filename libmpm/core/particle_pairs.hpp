#pragma once
/// What both transfers share: two particles of one cell side by side in a Lanes, {a_0 .. a_3 | b_0 .. b_3}, and the block's halo of nodes.
/// For particle_to_grid.cpp and grid_to_particle.cpp only.

#include <type_traits>

#include "libmpm/base/bspline.hpp"
#include "libmpm/base/lanes.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

/// Four doubles that lie anywhere.
using UnalignedNode = double __attribute__((vector_size(32), aligned(8), may_alias));
/// Four doubles from any address.
inline Node load_half(const double* p) { return *reinterpret_cast<const UnalignedNode*>(p); }
/// Four doubles to any address.
inline void store_half(double* p, Node v) { *reinterpret_cast<UnalignedNode*>(p) = v; }

/// {a_0 .. a_3 | b_0 .. b_3}
inline Lanes load_pair(const double* a, const double* b) { return join(load_half(a), load_half(b)); }
/// The same node for both particles.
inline Lanes twice(Node n) { return __builtin_shufflevector(n, n, 0, 1, 2, 3, 0, 1, 2, 3); }

/// Component c of each particle in all four of its lanes.
template <int c>
inline Lanes spread(Lanes v) {
  return __builtin_shufflevector(v, v, c, c, c, c, 4 + c, 4 + c, 4 + c, 4 + c);
}

inline constexpr Lanes lanes_xyz = {1, 1, 1, 0, 1, 1, 1, 0};    ///< 1 in the lanes of a vector, 0 in the fourth
inline constexpr LaneMask mask_w = {0, 0, 0, -1, 0, 0, 0, -1};  ///< the fourth lanes

/// 0, 1, 2 along an axis: the weight of each node, for both particles, in all components.
struct AxisWeights {
  Lanes w[3];  ///< of nodes base, base + 1, base + 2
};
/// The weights of one axis out of those of all three.
template <int axis>
inline AxisWeights along(const BsplineWeights<Lanes>& w) {
  return {{spread<axis>(w.n0), spread<axis>(w.n1), spread<axis>(w.n2)}};
}

/// The pair that comes sixteen places after order[n], in the next bin behind the end of this one: slots are visited by cell, an order the
/// hardware cannot guess. A core can wait for some sixteen cache lines at a time, and the six of a pair are asked for one or two at a time
/// all through the work on another pair.
class PrefetchPair {
 public:
  /// Looks up the two addresses; reads no particle.
  PrefetchPair(const ParticleBin& bin, const ParticleBin& next, int n) {
    const int count = bin.count(), next_last = next.count() - 1;
    const auto place = [&](int m) {
      if (m < count) [[likely]]
        return reinterpret_cast<const char*>(&bin[bin.order[static_cast<std::size_t>(m)]]);
      return reinterpret_cast<const char*>(&next[next.order[static_cast<std::size_t>(m - count < next_last ? m - count : next_last)]]);
    };
    a_ = place(n + 16);
    b_ = place(n + 17);
  }
  /// Line 0 of both.
  void request_first() const {
    __builtin_prefetch(a_);
    __builtin_prefetch(b_);
  }
  /// The others, in three portions. @param k 0, 1, 2
  void request_rest(int k) const {
    if (k < 2) __builtin_prefetch(a_ + 64 * (k + 1));
    if (k > 0) __builtin_prefetch(b_ + 64 * k);
  }

 private:
  const char *a_, *b_;
};

inline constexpr int batch_pairs = 16;  ///< that a transfer takes through its passes together

/// A particle without mass: fills the second half of a pair when a cell holds an odd number.
inline const Particle padding_particle{};

/// Index of a node in Halo. @param x, y, z  in [0, 6)
constexpr int halo_index(int x, int y, int z) { return x + halo_edge * (y + halo_edge * z); }

/// Corner of a cell in grid coordinates, for both particles of a pair; lane 3 is zero.
inline Lanes cell_corner(const Index3& block, int cell) {
  constexpr double edge = block_edge;
  const Lanes c = {edge * block[0] + (cell & 3), edge * block[1] + (cell >> 2 & 3), edge * block[2] + (cell >> 4), 0, 0, 0, 0, 0};
  return __builtin_shufflevector(c, c, 0, 1, 2, 3, 0, 1, 2, 3);
}

/// Index in Halo of the base node of a cell. @param cell  x + 4 y + 16 z
inline int first_halo_node(int cell) { return halo_index(cell & 3, cell >> 2 & 3, cell >> 4); }

/// Calls f(grid row, halo row, count) for every run of nodes that the halo shares with one block's storage.
/// @param neighbour  numbers of those blocks, by neighbour_slot
template <class NodesOf, class HaloNode, class F>
inline void for_each_halo_row(const std::array<std::int32_t, 27>& neighbour, NodesOf&& nodes_of, HaloNode* halo, F&& f) {
  for (int bz = 0; bz < 2; ++bz) {
    for (int by = 0; by < 2; ++by) {
      auto* near = nodes_of(neighbour[static_cast<std::size_t>(neighbour_slot(0, by, bz))]).node;
      auto* far = nodes_of(neighbour[static_cast<std::size_t>(neighbour_slot(1, by, bz))]).node;
      for (int z = 0; z < (bz == 0 ? 4 : 2); ++z) {
        for (int y = 0; y < (by == 0 ? 4 : 2); ++y) {
          HaloNode* row = halo + halo_index(0, 4 * by + y, 4 * bz + z);
          f(near + 4 * y + 16 * z, row, std::integral_constant<int, 4>{});
          f(far + 4 * y + 16 * z, row + 4, std::integral_constant<int, 2>{});
        }
      }
    }
  }
}

}  // namespace mpm
