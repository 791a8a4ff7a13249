#include <algorithm>
#include <bit>
#include <optional>

#include "libmpm/core/particle_pairs.hpp"
#include "libmpm/core/transfer.hpp"

namespace mpm {

namespace {

/// Sum w v and its first moments sum w v (i, j, k), for both particles of a pair.
struct Gathered {
  Lanes v, x, y, z;
};

/// A halo with every node twice, {v | v}: one load serves both particles of a pair, without a shuffle.
struct alignas(64) PairHalo {
  Lanes node[halo_nodes];
  PairHalo(const Grid& grid, std::int32_t block, bool old) {
    const auto nodes_of = [&](std::int32_t b) -> const NodeBlock& { return old ? grid.old_nodes(b) : grid.nodes(b); };
    for_each_halo_row(grid.block(block).neighbour, nodes_of, node, [](const Node* from, Lanes* row, auto count) {
      for (int i = 0; i < count; ++i) row[i] = twice(from[i]);
    });
  }
};

inline __attribute__((always_inline)) Gathered gather_pair(const Lanes* node, const AxisWeights& wx, const AxisWeights& wy,
                                                           const AxisWeights& wz, const PrefetchPair& prefetch) {
  const Lanes wx2 = wx.w[2] + wx.w[2], wy2 = wy.w[2] + wy.w[2], wz2 = wz.w[2] + wz.w[2];
  Lanes v[3], x[3], y[3];
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    Lanes s[3], sx[3];
    prefetch.request_rest(k);
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

BlockMotion grid_to_particle(Grid& grid, std::int32_t index, const TransferOptions& options, std::int32_t next_index) {
  Block& block = grid.block(index);
  ParticleBin& bin = block.particles;
  const double inverse_dx = grid.inverse_cell_size();
  const ParticleBin& next = next_index == no_block ? bin : grid.block(next_index).particles;
  const bool keeps = options.kept > 0.0;
  const PairHalo halo(grid, index, false);
  const std::optional<PairHalo> old_halo = keeps ? std::optional<PairHalo>(std::in_place, grid, index, true) : std::nullopt;

  const Lanes dt = lanes_xyz * options.dt;
  const Lanes affine_scale = Lanes{} + 4.0 * inverse_dx;
  const Lanes to_cell = (Lanes{} + (to_integer_bits - 1.0)) - cell_corner(block.coordinate, 0);
  const LaneMask integer_zero = std::bit_cast<LaneMask>(Lanes{} + to_integer_bits);
  Lanes max_speed_squared = {};
  Particle discarded{};  // takes what would be the second of a lone particle
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
        PrefetchPair(bin, next, n).request_first();
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
        Particle &a = *m.a, &b = m.pair ? *m.b : discarded;  // written to
        const PrefetchPair prefetch(bin, next, first_pair + 2 * n);
        const AxisWeights wx = along<0>(m.w), wy = along<1>(m.w), wz = along<2>(m.w);
        const Gathered g = gather_pair(halo.node + first_node, wx, wy, wz, prefetch);
        const Lanes f = m.f, xv = load_pair(a.position, m.b->position);
        const Lanes old_velocity = load_pair(a.velocity, m.b->velocity);  // lane 3: the identity number
        Lanes v = g.v;
        if (keeps) v += options.kept * (old_velocity - gather_pair(old_halo->node + first_node, wx, wy, wz, prefetch).v);
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
      const double rounded = m.particle.position[axis] * inverse_dx +
                             ((to_integer_bits - 1.0) - double{block_edge} * block.coordinate[static_cast<std::size_t>(axis)]);
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
