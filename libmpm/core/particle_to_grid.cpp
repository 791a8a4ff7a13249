#include <omp.h>

#include <algorithm>
#include <span>

#include "libmpm/core/particle_groups.hpp"
#include "libmpm/core/spline_sums.hpp"
#include "libmpm/core/transfer.hpp"

namespace mpm {

namespace {

/// One field: momentum including that of the internal forces. Or two: momentum, and momentum of the internal forces. {kg m/s, kg} a node.
template <class V, int fields>
struct Contribution {
  Linear<V> field[fields];
  BsplineWeights<V> w;
};

/// Factors of a particle's values in its contribution to the grid.
template <class V>
struct Scales {
  V mass, affine, stress;  ///< rho_0, kg/m^3; rho_0 dx, kg/m^2; -4 dt/dx, s/m
  V shock, shock_limit;    ///< kg/m, kg/(m s): q = |d| min(shock |d|, shock_limit), d the rate of compression (transfer.hpp)
};

/// Viscous pressure of shocks, in all components. @param x, y, z  columns of C
template <class V>
inline __attribute__((always_inline)) V shock_pressure(const V& x, const V& y, const V& z, const Scales<V>& scale) {
  const V compression = max(V{} - (spread<0>(x) + spread<1>(y) + spread<2>(z)), V{});
  return compression * min(scale.shock * compression, scale.shock_limit);
}

template <int fields, bool viscous, class Record, class V = typename Group<Record>::Vector>
inline __attribute__((always_inline)) Contribution<V, fields> contribution(const Group<Record>& g, const CellOffset<Record>& offset,
                                                                           const Scales<V>& scale) {
  const V xv = g.position();  // x y z V
  const V f = offset(xv);
  const V volume = spread<3>(xv);
  const V velocity = select(Group<Record>::mask_w, V{} + 1.0, g.velocity());
  const V ma = scale.affine * volume, ms = scale.stress * volume;
  TensorColumns<V> columns = g.tensors();
  if constexpr (viscous) {
    const V q = shock_pressure(columns.cx, columns.cy, columns.cz, scale);
    columns.tx -= Group<Record>::unit_x * q;
    columns.ty -= Group<Record>::unit_y * q;
    columns.tz -= Group<Record>::unit_z * q;
  }
  const V tx = ms * columns.tx, ty = ms * columns.ty, tz = ms * columns.tz;
  Contribution<V, fields> c;
  Linear<V>& p = c.field[0];
  p.ax = ma * columns.cx;
  p.ay = ma * columns.cy;
  p.az = ma * columns.cz;
  if constexpr (fields == 1) {
    p.ax += tx;
    p.ay += ty;
    p.az += tz;
  } else {
    c.field[1] = {-(spread<0>(f) * tx + spread<1>(f) * ty + spread<2>(f) * tz), tx, ty, tz};
  }
  p.base = scale.mass * volume * velocity - spread<0>(f) * p.ax - spread<1>(f) * p.ay - spread<2>(f) * p.az;
  c.w = bspline_weights(f);
  return c;
}

/// Sums of one block's particles in the precision of the records. One node more: the last row of four reaches it.
template <class Record>
struct alignas(64) SumHalo {
  typename Group<Record>::Quad node[halo_nodes + 4];
};

/// A group between the two passes of scatter_to_halo.
template <class Record, int fields>
struct ScatteredGroup {
  using Vector = typename Group<Record>::Vector;
  Contribution<Vector, fields> given;
  PrefetchGroup<Record> ahead;  ///< to be requested during the work on this group
};

/// Adds the groups of a cell to a plane of its nodes. The nine sums of a field stay in registers; those of three planes would not fit.
/// @param first_node  the first of the plane's nodes
template <int k, class Record, int fields>
inline __attribute__((always_inline)) void add_to_plane(std::span<const ScatteredGroup<Record, fields>> groups,
                                                        SumHalo<Record> (&halo)[fields], int first_node) {
  using V = typename Group<Record>::Vector;
  V sum[fields][9] = {};
  for (const ScatteredGroup<Record, fields>& group : groups) {
    group.ahead.request_rest(k);
    const BsplineWeights<V>& w = group.given.w;
    const AxisWeights<V> wx = along<0>(w), wy = along<1>(w), wz = along<2>(w);
#pragma GCC unroll 2
    for (int f = 0; f < fields; ++f) {
      const Linear<V>& c = group.given.field[f];
      V value = c.base;
#pragma GCC unroll 2
      for (int step = 0; step < k; ++step) value += c.az;
      add_plane(c, value, wx, wy, wz.w[k], sum[f]);
    }
  }
#pragma GCC unroll 2
  for (int f = 0; f < fields; ++f) add_plane_sums(sum[f], halo[f].node + first_node);
}

/// Sums the particles of a block into a halo: two passes over the groups of a cell, a batch at a time: a latency-bound pass (one long chain
/// of dependent operations for each group), then a throughput-bound pass. Apart, each fills the processor's window with many groups.
/// @param next particles to prefetch, those of the next block. @tparam viscous  false: without the viscous pressure of shocks
template <bool viscous, class Record, int fields>
void scatter_to_halo(const Grid& grid, const Block& block, const ParticleBin& next, const TransferOptions& options,
                     SumHalo<Record> (&halo)[fields]) {
  using V = typename Group<Record>::Vector;
  using Scalar = ScalarOf<V>;
  constexpr int size = Group<Record>::size, batch = batch_of<Record>;
  const double dx = grid.cell_size(), inverse_dx = grid.inverse_cell_size();
  const Scales<V> scale{V{} + static_cast<Scalar>(options.density),
                        Group<Record>::xyz * static_cast<Scalar>(options.affine ? options.density * dx : 0.0),
                        Group<Record>::xyz * static_cast<Scalar>(-options.dt * 4.0 * inverse_dx),
                        V{} + static_cast<Scalar>(options.density * dx * dx * options.shock_viscosity),
                        V{} + static_cast<Scalar>(options.density * dx * dx * shock_stability / options.dt)};
  const ParticleBin& bin = block.particles;
  for (auto& h : halo) h = SumHalo<Record>{};
  ScatteredGroup<Record, fields> groups[batch];
  for (int cell = 0; cell < block_nodes; ++cell) {
    const int begin = bin.cell_start[cell], end = bin.cell_start[cell + 1];
    if (begin == end) continue;
    const CellOffset<Record> offset(grid, block.coordinate, cell);
    const auto prepare = [&](int first) {
      int count = 0;
      for (int n = first; n < end && count < batch; n += size, ++count) {
        groups[count].ahead = PrefetchGroup<Record>(bin, next, n);
        groups[count].ahead.request_first();
        groups[count].given = contribution<fields, viscous>(group_at<Record>(bin, n, end), offset, scale);
      }
      return std::span<const ScatteredGroup<Record, fields>>(groups, static_cast<std::size_t>(count));
    };
    if (end - begin <= size * batch) {
      const auto cell_groups = prepare(begin);
      const int node = first_halo_node(cell);
      add_to_plane<0>(cell_groups, halo, node);
      add_to_plane<1>(cell_groups, halo, node + halo_index(0, 0, 1));
      add_to_plane<2>(cell_groups, halo, node + halo_index(0, 0, 2));
      continue;
    }
    V sum[fields][27] = {};  // of a crowded cell
    for (int first = begin; first < end; first += size * batch) {
      for (const auto& group : prepare(first)) {
        for (int f = 0; f < fields; ++f) add(group.given.field[f], group.given.w, sum[f]);
      }
    }
    for (int f = 0; f < fields; ++f) add_sums(sum[f], halo[f].node + first_halo_node(cell));
  }
}

/// Adds the sums of a block to the nodes. @param velocity  reference of the momenta of single records, {v_x, v_y, v_z, 0}
inline void add_row(Node* node, const Node* row, int count, Node /*velocity*/) {
  for (int n = 0; n < count; ++n) node[n] += row[n];
}
inline void add_row(Node* node, const SingleQuad* row, int count, Node velocity) {
  for (int n = 0; n < count; ++n) {
    const Node wide = widen(row[n]);
    node[n] += wide + velocity * wide[3];
  }
}

/// Sets nodes to zero that a block's particles touch, in the buffers that it has in place of its neighbours' nodes (Block::buffers).
template <int fields>
void clear_buffers(Grid& grid, const Block& block) {
  for (std::size_t k = 0; k < forward_directions.size(); ++k) {
    const auto direction = static_cast<std::size_t>(forward_directions[k]);
    const std::int32_t buffer = (*block.buffers)[direction];
    if (buffer == block.neighbour[direction]) continue;
    for (int f = 0; f < fields; ++f) {
      Node* const nodes = grid.field(f, buffer).node;
      for (int z = 0; z < ((k & 4U) != 0 ? 2 : block_edge); ++z) {
        for (int y = 0; y < ((k & 2U) != 0 ? 2 : block_edge); ++y)
          std::fill_n(nodes + block_edge * (y + block_edge * z), block_edge, Node{});
      }
    }
  }
}

/// Adds the particles of blocks that share no node. All threads of a parallel region call it and divide the blocks among themselves.
/// @param outer  those with this value of Block::outer. @tparam fields as in scatter_all()
template <class Record, int fields>
void scatter_disjoint_blocks(Grid& grid, std::span<const std::int32_t> blocks, bool outer, const TransferOptions& options,
                             SumHalo<Record> (&halo)[fields]) {
  const auto threads = static_cast<std::size_t>(omp_get_num_threads());
  const auto to_halo = options.shock_viscosity > 0.0 ? scatter_to_halo<true, Record, fields> : scatter_to_halo<false, Record, fields>;
#pragma omp for schedule(dynamic, 1)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& block = grid.block(blocks[i]);
    if (block.outer != outer) continue;
    const std::size_t next = std::min(i + threads, blocks.size() - 1);  // an estimate: threads get one block at a time
    to_halo(grid, block, grid.block(blocks[next]).particles, options, halo);
    const Vec3& v = block.particles.frame.velocity;
    if (block.buffers != nullptr) clear_buffers<fields>(grid, block);
    for (int f = 0; f < fields; ++f) {
      const Node velocity = f == 0 ? Node{v.x(), v.y(), v.z(), 0.0} : Node{};  // internal forces do not depend on the frame of reference
      for_each_halo_row(
          block.targets(), [&](std::int32_t b) -> NodeBlock& { return grid.field(f, b); },
          [&](Node* node, int first, auto count) { add_row(node, halo[f].node + first, count, velocity); });
    }
    if (omp_get_thread_num() == 0) grid.ranks().progress();
  }
}

/// Outer blocks. The contributions of such a block all go to buffers (Block::buffers): outer blocks share no node, whatever their colours.
template <class Record, int fields>
void scatter_outer_blocks(Grid& grid, const TransferOptions& options) {
#pragma omp parallel
  {
    SumHalo<Record> halo[fields];
    scatter_disjoint_blocks<Record, fields>(grid, grid.occupied_blocks(), true, options, halo);
  }
}

/// The other blocks, colour by colour.
template <class Record, int fields>
void scatter_inner_blocks(Grid& grid, const TransferOptions& options) {
  const auto all = grid.own_blocks();
#pragma omp parallel
  {
#pragma omp for schedule(static)
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (int f = 0; f < fields; ++f) grid.field(f, all[i]) = NodeBlock{};
    }
    SumHalo<Record> halo[fields];
    for (int colour = 0; colour < 8; ++colour) {
      scatter_disjoint_blocks<Record, fields>(grid, grid.coloured_blocks(colour), false, options, halo);
    }
  }
}

/// @tparam fields 1: momenta with those of the internal forces; 2: momenta and force impulses
template <class Record, int fields>
void scatter_all(Grid& grid, const TransferOptions& options) {
  Ranks& ranks = grid.ranks();
  if (ranks.size() > 1) scatter_outer_blocks<Record, fields>(grid, options);
  ranks.send_parts(NodeFields(grid));
  scatter_inner_blocks<Record, fields>(grid, options);
  ranks.add_parts(NodeFields(grid));
}

}  // namespace

void particle_to_grid(Grid& grid, const TransferOptions& options) {
  with_record_type(grid.precision(), [&](auto record) {
    using Record = decltype(record);
    if (grid.keeps_forces_apart()) {
      scatter_all<Record, 2>(grid, options);
    } else {
      scatter_all<Record, 1>(grid, options);
    }
  });
}

}  // namespace mpm
