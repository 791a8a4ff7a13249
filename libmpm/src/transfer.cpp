#include "mpm/transfer.hpp"

#include <omp.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "mpm/bspline.hpp"
#include "mpm/lanes.hpp"

namespace mpm {

namespace {

// --- pairs: {a_0 .. a_3 | b_0 .. b_3} -----------------------------------------------------------------------------------

using UnalignedNode = double __attribute__((vector_size(32), aligned(8), may_alias));
inline Node load_half(const double* p) { return *reinterpret_cast<const UnalignedNode*>(p); }
inline void store_half(double* p, Node v) { *reinterpret_cast<UnalignedNode*>(p) = v; }

inline Lanes load_pair(const double* a, const double* b) { return join(load_half(a), load_half(b)); }
inline Lanes twice(Node n) { return __builtin_shufflevector(n, n, 0, 1, 2, 3, 0, 1, 2, 3); }

/// Component c of each particle in all four of its lanes.
template <int c>
inline Lanes spread(Lanes v) {
  return __builtin_shufflevector(v, v, c, c, c, c, 4 + c, 4 + c, 4 + c, 4 + c);
}

constexpr Lanes lanes_xyz = {1, 1, 1, 0, 1, 1, 1, 0};
constexpr LaneMask mask_w = {0, 0, 0, -1, 0, 0, 0, -1};

/// 0, 1, 2 along an axis: the weight of each node, for both particles, in all components.
struct AxisWeights {
  Lanes w[3];
};
template <int axis>
inline AxisWeights along(const BsplineWeights<Lanes>& w) {
  return {{spread<axis>(w.n0), spread<axis>(w.n1), spread<axis>(w.n2)}};
}

/// The pair that comes sixteen places after order[n], in the next bin behind the end of this one: slots are visited by cell, an order the
/// hardware cannot guess. A core can wait for some sixteen cache lines at a time, and the six of a pair are asked for one or two at a time
/// all through the work on another pair.
class LaterPair {
 public:
  LaterPair(const ParticleBin& bin, const ParticleBin& next, int n) {
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
  void ask_first() const {
    __builtin_prefetch(a_);
    __builtin_prefetch(b_);
  }
  /// The others, in three portions. @param k 0, 1, 2
  void ask_rest(int k) const {
    if (k < 2) __builtin_prefetch(a_ + 64 * (k + 1));
    if (k > 0) __builtin_prefetch(b_ + 64 * k);
  }

 private:
  const char *a_, *b_;
};

constexpr int batch_pairs = 16;  ///< that a transfer takes through its passes together

/// A particle without mass: fills the second half of a pair when a cell holds an odd number.
const Particle nobody{};

constexpr int halo_index(int x, int y, int z) { return x + halo_edge * (y + halo_edge * z); }

/// Corner of a cell in grid coordinates, for both particles of a pair; lane 3 is zero.
inline Lanes cell_corner(const Index3& block, int cell) {
  const Lanes c = {4.0 * block[0] + (cell & 3), 4.0 * block[1] + (cell >> 2 & 3), 4.0 * block[2] + (cell >> 4), 0, 0, 0, 0, 0};
  return __builtin_shufflevector(c, c, 0, 1, 2, 3, 0, 1, 2, 3);
}

inline int first_halo_node(int cell) { return halo_index(cell & 3, cell >> 2 & 3, cell >> 4); }

/// Calls f(grid row, halo row, count) for every run of nodes that the halo shares with one block's storage.
template <class NodesOf, class HaloNode, class F>
inline void for_each_halo_row(const Block& self, NodesOf&& nodes_of, HaloNode* halo, F&& f) {
  for (int bz = 0; bz < 2; ++bz) {
    for (int by = 0; by < 2; ++by) {
      auto* near = nodes_of(self.neighbour[static_cast<std::size_t>(neighbour_slot(0, by, bz))]).node;
      auto* far = nodes_of(self.neighbour[static_cast<std::size_t>(neighbour_slot(1, by, bz))]).node;
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

// --- particle to grid ---------------------------------------------------------------------------------------------------

/// What particles a and b of one cell give to node (i, j, k) of that cell: wx_i wy_j wz_k (base + i ax + j ay + k az).
struct Contribution {
  Lanes base, ax, ay, az;
  BsplineWeights<Lanes> w;
};

inline __attribute__((always_inline)) Contribution contribution(const Particle& a, const Particle& b, Lanes corner, double inverse_dx,
                                                                Lanes mass_scale, Lanes affine_scale, Lanes stress_scale) {
  const Lanes xv = load_pair(a.position, b.position);  // x y z V
  const Lanes f = xv * inverse_dx - corner;
  const Lanes volume = spread<3>(xv);
  const Lanes velocity = mask_w ? Lanes{} + 1.0 : load_pair(a.velocity, b.velocity);
  const Lanes ma = affine_scale * volume, ms = stress_scale * volume;
  const Lanes sa = *reinterpret_cast<const Lanes*>(a.affine + 8),
              sb = *reinterpret_cast<const Lanes*>(b.affine + 8);  // c8 xx yy zz xy xz yz h
  Contribution c;
  c.ax = ma * load_pair(a.affine, b.affine) + ms * __builtin_shufflevector(sa, sb, 1, 4, 5, 0, 9, 12, 13, 8);
  c.ay = ma * load_pair(a.affine + 3, b.affine + 3) + ms * __builtin_shufflevector(sa, sb, 4, 2, 6, 0, 12, 10, 14, 8);
  c.az = ma * load_pair(a.affine + 6, b.affine + 6) + ms * __builtin_shufflevector(sa, sb, 5, 6, 3, 0, 13, 14, 11, 8);
  c.base = mass_scale * volume * velocity - spread<0>(f) * c.ax - spread<1>(f) * c.ay - spread<2>(f) * c.az;
  c.w = bspline_weights(f);
  return c;
}

/// Adds a pair's contribution to the 27 sums of its cell.
inline __attribute__((always_inline)) void add(const Contribution& c, Lanes (&sum)[27], const LaterPair& later) {
  const AxisWeights wx = along<0>(c.w), wy = along<1>(c.w), wz = along<2>(c.w);
  const Lanes ax = c.ax, ay = c.ay, az = c.az;
  Lanes value_k = c.base;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    later.ask_rest(k);
    const Lanes u = wz.w[k] * value_k, uy = wz.w[k] * ay, ux = wz.w[k] * ax;
    Lanes value_j = u;
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const Lanes t = wy.w[j] * value_j, tx = wy.w[j] * ux;
      Lanes* row = sum + 3 * (j + 3 * k);
      const Lanes t1 = t + tx, t2 = t1 + tx;
      row[0] += wx.w[0] * t;
      row[1] += wx.w[1] * t1;
      row[2] += wx.w[2] * t2;
      value_j += uy;
    }
    value_k += az;
  }
}

/// Two passes over the pairs of a cell, a batch at a time: the first is one long chain of dependent operations for each pair, the second
/// is wide; apart, each fills the processor's window with many pairs.
/// @param next particles whose turn comes next: asked for ahead of time
void scatter_block(const Grid& grid, const Block& block, const ParticleBin& next, const TransferOptions& options, Halo& halo) {
  const double dx = grid.cell_size(), inverse_dx = grid.inverse_cell_size();
  const Lanes mass_scale = Lanes{} + options.density;
  const Lanes affine_scale = lanes_xyz * (options.apic ? options.density * dx : 0.0);
  const Lanes stress_scale = lanes_xyz * (-options.dt * 4.0 * inverse_dx);
  const ParticleBin& bin = block.particles;
  halo = Halo{};
  Contribution pairs[batch_pairs];
  for (int cell = 0; cell < block_nodes; ++cell) {
    const int begin = bin.cell_start[cell], end = bin.cell_start[cell + 1];
    if (begin == end) continue;
    const Lanes corner = cell_corner(block.coordinate, cell);
    Lanes sum[27] = {};
    for (int first_pair = begin; first_pair < end; first_pair += 2 * batch_pairs) {
      int count = 0;
      for (int n = first_pair; n < end && count < batch_pairs; n += 2, ++count) {
        LaterPair(bin, next, n).ask_first();
        const Particle& a = bin[bin.order[static_cast<std::size_t>(n)]];
        const Particle& b = n + 1 < end ? bin[bin.order[static_cast<std::size_t>(n) + 1]] : nobody;
        pairs[count] = contribution(a, b, corner, inverse_dx, mass_scale, affine_scale, stress_scale);
      }
      for (int p = 0; p < count; ++p) add(pairs[p], sum, LaterPair(bin, next, first_pair + 2 * p));
    }
    Node* node = halo.node + first_halo_node(cell);
#pragma GCC unroll 27
    for (int n = 0; n < 27; ++n) node[halo_index(n % 3, n / 3 % 3, n / 9)] += lower_half(sum[n]) + upper_half(sum[n]);
  }
}

// --- grid to particle ---------------------------------------------------------------------------------------------------

/// Sum w v and its first moments sum w v (i, j, k), for both particles of a pair.
struct Gathered {
  Lanes v, x, y, z;
};

/// A halo with every node twice, {v | v}: one load serves both particles of a pair, without a shuffle.
struct alignas(64) PairHalo {
  Lanes node[halo_nodes];
  PairHalo(const Grid& grid, std::int32_t block, bool old) {
    const auto nodes_of = [&](std::int32_t b) -> const NodeBlock& { return old ? grid.old_nodes(b) : grid.nodes(b); };
    for_each_halo_row(grid.block(block), nodes_of, node, [](const Node* from, Lanes* row, auto count) {
      for (int i = 0; i < count; ++i) row[i] = twice(from[i]);
    });
  }
};

inline __attribute__((always_inline)) Gathered gather_pair(const Lanes* node, const AxisWeights& wx, const AxisWeights& wy,
                                                           const AxisWeights& wz, const LaterPair& later) {
  const Lanes wx2 = wx.w[2] + wx.w[2], wy2 = wy.w[2] + wy.w[2], wz2 = wz.w[2] + wz.w[2];
  Lanes v[3], x[3], y[3];
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    Lanes s[3], sx[3];
    later.ask_rest(k);
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
      const Lanes* row = node + halo_index(0, j, k);
      const Lanes m = wx.w[1] * row[1];
      s[j] = wx.w[0] * row[0] + m + wx.w[2] * row[2];
      sx[j] = m + wx2 * row[2];
    }
    const Lanes m = wy.w[1] * s[1];
    v[k] = wy.w[0] * s[0] + m + wy.w[2] * s[2];
    y[k] = m + wy2 * s[2];
    x[k] = wy.w[0] * sx[0] + wy.w[1] * sx[1] + wy.w[2] * sx[2];
  }
  const Lanes m = wz.w[1] * v[1];
  return {wz.w[0] * v[0] + m + wz.w[2] * v[2], wz.w[0] * x[0] + wz.w[1] * x[1] + wz.w[2] * x[2],
          wz.w[0] * y[0] + wz.w[1] * y[1] + wz.w[2] * y[2], m + wz2 * v[2]};
}

/// Two particles of a cell between the two passes of grid_to_particle.
struct MovingPair {
  Particle *a, *b;
  int slot_a, slot_b;
  bool pair;  ///< false: a is alone, and b is a again
  Lanes f;
  BsplineWeights<Lanes> w;
};

/// @param x lane 3: the volume; @param v lane 3: the identity number; @param cx,cy,cz columns of the affine matrix
inline __attribute__((always_inline)) void store_pair(Particle& a, Particle& b, Lanes x, Lanes v, Lanes cx, Lanes cy, Lanes cz) {
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

/// Nearest integer plus this constant puts the integer into the low bits of the sum (for |value| < 2^51).
constexpr double to_integer_bits = 6755399441055744.0;  // 1.5 * 2^52

}  // namespace

void particle_to_grid(Grid& grid, const TransferOptions& options) {
  const auto all = grid.all_blocks();
#pragma omp parallel
  {
#pragma omp for schedule(static)
    for (std::size_t i = 0; i < all.size(); ++i) grid.nodes(all[i]) = NodeBlock{};
    Halo halo;
    const auto threads = static_cast<std::size_t>(omp_get_num_threads());
    for (int colour = 0; colour < 8; ++colour) {
      const auto blocks = grid.coloured_blocks(colour);
#pragma omp for schedule(dynamic, 1)
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        const Block& block = grid.block(blocks[i]);
        const std::size_t next = std::min(i + threads, blocks.size() - 1);  // a guess: blocks are handed out one at a time
        scatter_block(grid, block, grid.block(blocks[next]).particles, options, halo);
        for_each_halo_row(
            block, [&](std::int32_t b) -> NodeBlock& { return grid.nodes(b); }, halo.node,
            [](Node* node, const Node* row, auto count) {
              for (int n = 0; n < count; ++n) node[n] += row[n];
            });
      }
    }
  }
}

BlockMotion grid_to_particle(Grid& grid, std::int32_t index, const TransferOptions& options, std::int32_t next_index) {
  Block& block = grid.block(index);
  ParticleBin& bin = block.particles;
  const double inverse_dx = grid.inverse_cell_size();
  const ParticleBin& next = next_index == no_block ? bin : grid.block(next_index).particles;
  const bool flip = !options.apic;
  const PairHalo halo(grid, index, false);
  const std::optional<PairHalo> old_halo = flip ? std::optional<PairHalo>(std::in_place, grid, index, true) : std::nullopt;

  const Lanes dt = lanes_xyz * options.dt;
  const Lanes affine_scale = Lanes{} + 4.0 * inverse_dx;
  const Lanes block_corner = {4.0 * block.coordinate[0], 4.0 * block.coordinate[1], 4.0 * block.coordinate[2], 0, 0, 0, 0, 0};
  const Lanes to_cell = (Lanes{} + (to_integer_bits - 1.0)) - __builtin_shufflevector(block_corner, block_corner, 0, 1, 2, 3, 0, 1, 2, 3);
  const LaneMask integer_zero = std::bit_cast<LaneMask>(Lanes{} + to_integer_bits);
  Lanes max_speed_squared = {};
  Particle nobody_else{};  // takes what would be the second of a lone particle
  std::uint32_t reach = 0;
  MovingPair pairs[batch_pairs];

  for (int cell = 0; cell < block_nodes; ++cell) {
    const int begin = bin.cell_start[cell], end = bin.cell_start[cell + 1];
    if (begin == end) continue;
    const Lanes corner = cell_corner(block.coordinate, cell);
    const int first_node = first_halo_node(cell);
    for (int first_pair = begin; first_pair < end; first_pair += 2 * batch_pairs) {
      int count = 0;
      for (int n = first_pair; n < end && count < batch_pairs; n += 2, ++count) {
        LaterPair(bin, next, n).ask_first();
        MovingPair& m = pairs[count];
        m.pair = n + 1 < end;
        m.slot_a = bin.order[static_cast<std::size_t>(n)];
        m.slot_b = m.pair ? bin.order[static_cast<std::size_t>(n) + 1] : m.slot_a;
        m.a = &bin[m.slot_a];
        m.b = m.pair ? &bin[m.slot_b] : m.a;
        m.f = load_pair(m.a->position, m.b->position) * inverse_dx - corner;
        m.w = bspline_weights(m.f);
      }
      for (int n = 0; n < count; ++n) {
        const MovingPair& m = pairs[n];
        Particle &a = *m.a, &b = m.pair ? *m.b : nobody_else;  // written to
        const LaterPair later(bin, next, first_pair + 2 * n);
        const AxisWeights wx = along<0>(m.w), wy = along<1>(m.w), wz = along<2>(m.w);
        const Gathered g = gather_pair(halo.node + first_node, wx, wy, wz, later);
        const Lanes f = m.f, xv = load_pair(a.position, m.b->position);
        const Lanes old_velocity = load_pair(a.velocity, m.b->velocity);  // lane 3: the identity number
        Lanes v = g.v;
        if (flip) v += options.flip_ratio * (old_velocity - gather_pair(old_halo->node + first_node, wx, wy, wz, later).v);
        const Lanes cx = affine_scale * (g.x - spread<0>(f) * g.v);
        const Lanes cy = affine_scale * (g.y - spread<1>(f) * g.v);
        const Lanes cz = affine_scale * (g.z - spread<2>(f) * g.v);
        const Lanes x = xv + dt * g.v;  // lane 3: volume + 0

        store_pair(a, b, x, mask_w ? old_velocity : v, cx, cy, cz);

        const Lanes v2 = v * v;
        const Lanes speed_squared = v2 + spread<1>(v2) + spread<2>(v2);  // in lanes 0 and 4
        max_speed_squared = speed_squared > max_speed_squared ? speed_squared : max_speed_squared;

        // base = floor(x/dx - 1/2) = nearest(x/dx - 1); relative to the block: 0..3 if the particle stays
        const LaneMask local = std::bit_cast<LaneMask>(x * inverse_dx + to_cell) - integer_zero;
        const std::uint64_t bytes = saturated_bytes(local);
        const auto mark = [&](int slot, std::uint32_t c) {  // a byte each for x, y, z
          const bool stays = (c & 0xFCFCFCU) == 0;
          bin.cell[static_cast<std::size_t>(slot)] =
              stays ? static_cast<std::uint8_t>((c | c >> 6 | c >> 12) & 63U) : ParticleBin::left_block;
          reach |= (((c & 0x7F7F7FU) + 0x040404U) ^ (c & 0x808080U)) & 0xF0F0F0U;  // not zero if a byte is not in -4 .. 11
        };
        mark(m.slot_a, static_cast<std::uint32_t>(bytes));
        if (m.pair) mark(m.slot_b, static_cast<std::uint32_t>(bytes >> 32));
      }
    }
  }
  BlockMotion motion;
  motion.max_speed_squared = max(max_speed_squared[0], max_speed_squared[4]);
  motion.within_reach = reach == 0;
  return motion;
}

void collect_migrants(Grid& grid, std::int32_t index, BlockMotion& motion) {
  Block& block = grid.block(index);
  ParticleBin& bin = block.particles;
  const double inverse_dx = grid.inverse_cell_size();
  for (int s = bin.last_leaver(bin.count()); s >= 0; s = bin.last_leaver(s)) {
    Migrant m{bin[s], 0};
    int offset[3];
    for (int axis = 0; axis < 3; ++axis) {
      // the same rounding as in grid_to_particle, so that both agree on ties
      const double rounded =
          m.particle.position[axis] * inverse_dx + ((to_integer_bits - 1.0) - 4.0 * block.coordinate[static_cast<std::size_t>(axis)]);
      const auto local = static_cast<int>(std::bit_cast<std::int64_t>(rounded) - std::bit_cast<std::int64_t>(to_integer_bits));
      offset[axis] = local >> 2;
      m.cell |= (local & 3) << (2 * axis);
      if (offset[axis] < -1 || offset[axis] > 1) motion.within_reach = false;
    }
    if (!motion.within_reach) return;
    block.send(m, neighbour_slot(offset[0], offset[1], offset[2]));
    grid.remove(index, s);
  }
}

}  // namespace mpm
