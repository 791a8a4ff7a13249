#include <omp.h>

#include <algorithm>

#include "libmpm/core/particle_pairs.hpp"
#include "libmpm/core/transfer.hpp"

namespace mpm {

namespace {

/// What particles a and b of one cell give to node (i, j, k) of that cell: wx_i wy_j wz_k (base + i ax + j ay + k az).
struct Linear {
  Lanes base, ax, ay, az;
};

/// One field, the momentum with that of the internal forces; or two, the momentum and what the forces add to it.
template <int fields>
struct Contribution {
  Linear field[fields];
  BsplineWeights<Lanes> w;
};

template <int fields>
inline __attribute__((always_inline)) Contribution<fields> contribution(const Particle& a, const Particle& b, Lanes corner,
                                                                        double inverse_dx, Lanes mass_scale, Lanes affine_scale,
                                                                        Lanes stress_scale) {
  const Lanes xv = load_pair(a.position, b.position);  // x y z V
  const Lanes f = xv * inverse_dx - corner;
  const Lanes volume = spread<3>(xv);
  const Lanes velocity = mask_w ? Lanes{} + 1.0 : load_pair(a.velocity, b.velocity);
  const Lanes ma = affine_scale * volume, ms = stress_scale * volume;
  const Lanes sa = *reinterpret_cast<const Lanes*>(a.affine + 8),
              sb = *reinterpret_cast<const Lanes*>(b.affine + 8);  // c8 xx yy zz xy xz yz h
  const Lanes tx = ms * __builtin_shufflevector(sa, sb, 1, 4, 5, 0, 9, 12, 13, 8);
  const Lanes ty = ms * __builtin_shufflevector(sa, sb, 4, 2, 6, 0, 12, 10, 14, 8);
  const Lanes tz = ms * __builtin_shufflevector(sa, sb, 5, 6, 3, 0, 13, 14, 11, 8);
  Contribution<fields> c;
  Linear& p = c.field[0];
  p.ax = ma * load_pair(a.affine, b.affine);
  p.ay = ma * load_pair(a.affine + 3, b.affine + 3);
  p.az = ma * load_pair(a.affine + 6, b.affine + 6);
  if constexpr (fields == 1) {
    p.ax += tx;
    p.ay += ty;
    p.az += tz;
  } else {
    c.field[1] = {-(spread<0>(f) * tx + spread<1>(f) * ty + spread<2>(f) * tz), tx, ty, tz};
  }
  p.base = mass_scale * volume * velocity - spread<0>(f) * p.ax - spread<1>(f) * p.ay - spread<2>(f) * p.az;
  c.w = bspline_weights(f);
  return c;
}

/// Adds one field of a pair's contribution to the 27 sums of its cell.
inline __attribute__((always_inline)) void add(const Linear& c, const BsplineWeights<Lanes>& w, Lanes (&sum)[27],
                                               const PrefetchPair& prefetch) {
  const AxisWeights wx = along<0>(w), wy = along<1>(w), wz = along<2>(w);
  const Lanes ax = c.ax, ay = c.ay, az = c.az;
  Lanes value_k = c.base;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    prefetch.request_rest(k);
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

/// Two passes over the pairs of a cell, a batch at a time: a latency-bound pass (one long chain of dependent operations for each pair),
/// then a throughput-bound pass. Apart, each fills the processor's window with many pairs.
/// @param next particles whose turn comes next: requested ahead of time
template <int fields>
void scatter_block(const Grid& grid, const Block& block, const ParticleBin& next, const TransferOptions& options, Halo (&halo)[fields]) {
  const double dx = grid.cell_size(), inverse_dx = grid.inverse_cell_size();
  const Lanes mass_scale = Lanes{} + options.density;
  const Lanes affine_scale = lanes_xyz * (options.affine ? options.density * dx : 0.0);
  const Lanes stress_scale = lanes_xyz * (-options.dt * 4.0 * inverse_dx);
  const ParticleBin& bin = block.particles;
  for (Halo& h : halo) h = Halo{};
  Contribution<fields> pairs[batch_pairs];
  for (int cell = 0; cell < block_nodes; ++cell) {
    const int begin = bin.cell_start[cell], end = bin.cell_start[cell + 1];
    if (begin == end) continue;
    const Lanes corner = cell_corner(block.coordinate, cell);
    Lanes sum[fields][27] = {};
    for (int first_pair = begin; first_pair < end; first_pair += 2 * batch_pairs) {
      int count = 0;
      for (int n = first_pair; n < end && count < batch_pairs; n += 2, ++count) {
        PrefetchPair(bin, next, n).request_first();
        const Particle& a = bin[bin.order[static_cast<std::size_t>(n)]];
        const Particle& b = n + 1 < end ? bin[bin.order[static_cast<std::size_t>(n) + 1]] : padding_particle;
        pairs[count] = contribution<fields>(a, b, corner, inverse_dx, mass_scale, affine_scale, stress_scale);
      }
      for (int p = 0; p < count; ++p) {
#pragma GCC unroll 2
        for (int f = 0; f < fields; ++f) add(pairs[p].field[f], pairs[p].w, sum[f], PrefetchPair(bin, next, first_pair + 2 * p));
      }
    }
#pragma GCC unroll 2
    for (int f = 0; f < fields; ++f) {
      Node* node = halo[f].node + first_halo_node(cell);
#pragma GCC unroll 27
      for (int n = 0; n < 27; ++n) node[halo_index(n % 3, n / 3 % 3, n / 9)] += lower_half(sum[f][n]) + upper_half(sum[f][n]);
    }
  }
}

/// @tparam fields 1: nodes hold the momentum with that of the internal forces; 2: nodes hold the momentum, old nodes what forces add
template <int fields>
void scatter(Grid& grid, const TransferOptions& options) {
  const auto all = grid.all_blocks(), lent = grid.lent();
  const auto storage = [&](int field, std::int32_t b) -> NodeBlock& { return field == 0 ? grid.nodes(b) : grid.old_nodes(b); };
#pragma omp parallel
  {
#pragma omp for schedule(static)
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (int f = 0; f < fields; ++f) storage(f, all[i]) = NodeBlock{};
    }
#pragma omp for schedule(static)
    for (std::size_t i = 0; i < lent.size(); ++i) {
      for (int f = 0; f < fields; ++f) storage(f, lent[i]) = NodeBlock{};
    }
    Halo halo[fields];
    const auto threads = static_cast<std::size_t>(omp_get_num_threads());
    for (int colour = 0; colour < 8; ++colour) {
      const auto blocks = grid.coloured_blocks(colour);
#pragma omp for schedule(dynamic, 1)
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        const Block& block = grid.block(blocks[i]);
        const std::size_t next = std::min(i + threads, blocks.size() - 1);  // a guess: blocks are handed out one at a time
        scatter_block<fields>(grid, block, grid.block(blocks[next]).particles, options, halo);
        for (int f = 0; f < fields; ++f) {
          for_each_halo_row(
              block.parts != nullptr ? *block.parts : block.neighbour, [&](std::int32_t b) -> NodeBlock& { return storage(f, b); },
              halo[f].node,
              [](Node* node, const Node* row, auto count) {
                for (int n = 0; n < count; ++n) node[n] += row[n];
              });
        }
      }
    }
  }
}

}  // namespace

void particle_to_grid(Grid& grid, const TransferOptions& options) {
  if (grid.keeps_old_nodes()) {
    scatter<2>(grid, options);
  } else {
    scatter<1>(grid, options);
  }
  if (grid.ranks() != nullptr) grid.ranks()->add_parts(grid);
}

}  // namespace mpm
