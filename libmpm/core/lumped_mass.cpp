#include "libmpm/core/lumped_mass.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libmpm/base/bspline.hpp"
#include "libmpm/core/spline_sums.hpp"

namespace mpm {

namespace {

constexpr double outer_reach = LumpedMassCorrection::full_reach + LumpedMassCorrection::fade;
constexpr double reach_of_column = outer_reach + 0.5 * block_edge * 1.4143;  ///< cells from the centre of a column of blocks: its diagonal
constexpr double to_centre = 0.5 * block_edge + 0.5;                         ///< cells from a block's first node to its centre

/// The fields on the nodes that a block's particles touch.
struct Fields {
  Node by_forces[halo_nodes];      ///< {a dt = v - u, not used}: change by forces and boundaries
  Node before_forces[halo_nodes];  ///< u

  Fields(const Grid& grid, const Block& block) {
    for_each_halo_row(
        block.neighbour, [&](std::int32_t b) -> const NodeBlock& { return grid.velocities_before_forces(b); },
        [&](const Node* row, int first, auto count) {
          for (int n = 0; n < count; ++n) before_forces[first + n] = row[n];
        });
    for_each_halo_row(
        block.neighbour, [&](std::int32_t b) -> const NodeBlock& { return grid.velocities(b); },
        [&](const Node* row, int first, auto count) {
          for (int n = 0; n < count; ++n) by_forces[first + n] = row[n] - before_forces[first + n];
        });
  }
};

/// Prefetches the particle at order[n], if there is one; the hardware cannot predict the order by cell.
void request(const ParticleBin& bin, int n) {
  if (n < bin.count()) __builtin_prefetch(bin.bytes(bin.order[static_cast<std::size_t>(n)]).data());
}

struct PositionAndVolume {
  Vec3 x;
  double volume;
};
PositionAndVolume position_and_volume(const Grid& grid, const ParticleBin& bin, int slot) {
  return with_record_type(grid.precision(), [&](auto record) {
    const auto& r = bin.record<decltype(record)>(slot);
    return PositionAndVolume{position_of(r, bin.frame), r.volume};
  });
}

/// Columns of the skew part of a gradient.
/// @param x, y, z  columns of the gradient: derivatives along the axes
std::array<Node, 3> skew_part(const Node& x, const Node& y, const Node& z) {
  const double xy = 0.5 * (y[0] - x[1]), xz = 0.5 * (z[0] - x[2]), yz = 0.5 * (z[1] - y[2]);
  return {Node{0.0, -xy, -xz, 0.0}, Node{xy, 0.0, -yz, 0.0}, Node{xz, yz, 0.0, 0.0}};
}

/// A rectangle of columns of blocks: their coordinates x, y.
using Columns = Eigen::AlignedBox2i;

/// The same with columns before and behind it, along x and along y.
Columns extended(const Columns& columns, int before, int behind) {
  return {columns.min() - Eigen::Vector2i::Constant(before), columns.max() + Eigen::Vector2i::Constant(behind)};
}

std::vector<std::int32_t> blocks_in(const Grid& grid, const Columns& columns) {
  std::vector<std::int32_t> blocks;
  for (const auto b : grid.own_blocks()) {
    const Index3& block = grid.block(b).coordinate;
    if (columns.contains(Eigen::Vector2i(block[0], block[1]))) blocks.push_back(b);
  }
  return blocks;
}

}  // namespace

bool need_lumped_mass_correction(std::span<const Boundary> boundaries) {
  return std::ranges::any_of(boundaries, [](const Boundary& b) { return std::holds_alternative<SurfaceSolid>(b); });
}

double LumpedMassCorrection::weight(const Vec3& x) const {
  double distance = std::numeric_limits<double>::infinity();
  for (const UprightSolid* const solid : solids_) distance = std::min(distance, solid->distance(x));
  return std::clamp((outer_reach - distance / dx_) / fade, 0.0, 1.0);
}

std::array<LumpedMassCorrection::Part, block_nodes> LumpedMassCorrection::parts_of(const Block& block) const {
  constexpr double across = 0.7072, up = 0.5001;  // from the centre of a cell to its corner in plan and to its ends, rounded up
  constexpr int columns = block_edge * block_edge;
  std::array<Part, block_nodes> parts{};
  for (const UprightSolid* const solid : solids_) {
    for (int column = 0; column < columns; ++column) {
      double plan = std::numeric_limits<double>::quiet_NaN();  // the same for all cells of a column
      for (int cell = column; cell < block_nodes; cell += columns) {
        if (block.particles.cell_start[cell] == block.particles.cell_start[cell + 1]) continue;
        const Vec3 centre = node_position(block.coordinate, cell, dx_) + Vec3::Constant(dx_);
        if (std::isnan(plan)) plan = solid->outline.distance(centre.head<2>()) / dx_;
        const double beyond = solid->beyond(centre.z()) / dx_;
        if (std::max(plan - across, beyond - up) >= outer_reach) continue;
        Part& part = parts[static_cast<std::size_t>(cell)];
        part = std::max(part, std::max(plan + across, beyond + up) <= full_reach ? Part::full : Part::fading);
      }
    }
  }
  return parts;
}

bool LumpedMassCorrection::reaches(std::int32_t x, std::int32_t y) const {
  const Vec2 centre = dx_ * (Vec2(first_node(x), first_node(y)) + Vec2::Constant(to_centre));
  return std::ranges::any_of(solids_, [&](const UprightSolid* solid) { return solid->outline.distance(centre) <= reach_of_column * dx_; });
}

Eigen::AlignedBox2i LumpedMassCorrection::columns() const {
  const auto first_nodes = [&](const Vec2& corner, double cells) -> Eigen::Array2d {
    return ((corner / dx_).array() + (cells - to_centre - first_node(0))) / block_edge;
  };
  Eigen::AlignedBox2d bounds;
  for (const UprightSolid* const solid : solids_) bounds.extend(solid->outline.bounds());
  return {first_nodes(bounds.min(), -reach_of_column).floor().cast<int>().matrix(),
          first_nodes(bounds.max(), reach_of_column).ceil().cast<int>().matrix()};
}

void LumpedMassCorrection::add_of_block(const Grid& grid, const Block& block, std::span<NodeBlock> correction) const {
  const ParticleBin& bin = block.particles;
  const auto parts = parts_of(block);
  if (std::ranges::all_of(parts, [](Part p) { return p == Part::none; })) return;
  const Fields fields(grid, block);
  const bool keeps_moment = relaxed_ == 1.0;  // APIC
  // of all particles: sum m w {-(a + r u) - (S + r C) (x_i - x_p) | 1}, a and u at the particle; the nodes' own times the mass follow
  Node sum[halo_nodes] = {};
  bool any = false;
  for (int cell = 0; cell < block_nodes; ++cell) {
    const Part part = parts[static_cast<std::size_t>(cell)];
    if (part == Part::none) continue;
    const Vec3 base = node_position(block.coordinate, cell, dx_) / dx_;
    const int first = first_halo_node(cell);
    Node given[27] = {};
    bool here = false;
    for (int n = bin.cell_start[cell]; n < bin.cell_start[cell + 1]; ++n) {
      request(bin, n + 16);
      const auto [x, volume] = position_and_volume(grid, bin, bin.order[static_cast<std::size_t>(n)]);
      const double mass = (part == Part::full ? 1.0 : weight(x)) * density_ * volume;
      if (mass == 0.0) continue;
      here = true;
      const Vec3 f = x / dx_ - base;
      const BsplineWeights<Node> w = bspline_weights(Node{f.x(), f.y(), f.z(), 0.0});
      const Gathered<Node> u = gather(fields.before_forces + first, w, NoPrefetch{}), a = gather(fields.by_forces + first, w, NoPrefetch{});
      const double gradient_factor = 4.0 * relaxed_;  // gradients, for each cell, are four times the moments about the particle
      Linear<Node> c = {a.v + relaxed_ * u.v, gradient_factor * (u.x - f.x() * u.v), gradient_factor * (u.y - f.y() * u.v),
                        gradient_factor * (u.z - f.z() * u.v)};
      if (keeps_moment) {
        const auto [sx, sy, sz] = skew_part(4.0 * (a.x - f.x() * a.v), 4.0 * (a.y - f.y() * a.v), 4.0 * (a.z - f.z() * a.v));
        c.ax += sx, c.ay += sy, c.az += sz;
      }
      c.base -= f.x() * c.ax + f.y() * c.ay + f.z() * c.az;
      const Node given_by = {-mass, -mass, -mass, 0.0};
      c = {given_by * c.base, given_by * c.ax, given_by * c.ay, given_by * c.az};
      c.base[3] = mass;
      mpm::add(c, w, given);
    }
    if (!here) continue;
    any = true;
    add_sums(given, sum + first);
  }
  if (!any) return;
  for_each_halo_row(
      block.targets(), [&](std::int32_t b) -> NodeBlock& { return correction[static_cast<std::size_t>(b)]; },
      [&](Node* row, int first, auto count) {
        for (int n = 0; n < count; ++n) {
          const Node& s = sum[first + n];
          const Node all = s + s[3] * (fields.by_forces[first + n] + relaxed_ * fields.before_forces[first + n]);
          row[n] += Node{all[0], all[1], all[2], 0.0};
        }
      });
}

void LumpedMassCorrection::add_inner(const Grid& grid, std::span<NodeBlock> correction) const {
  for (int colour = 0; colour < 8; ++colour) add_of_blocks(grid, grid.coloured_blocks(colour), false, correction);
}

void LumpedMassCorrection::add_outer(const Grid& grid, std::span<NodeBlock> correction) const {
  add_of_blocks(grid, grid.occupied_blocks(), true, correction);
}

void LumpedMassCorrection::add_of_blocks(const Grid& grid, std::span<const std::int32_t> blocks, bool outer,
                                         std::span<NodeBlock> correction) const {
#pragma omp parallel for schedule(dynamic, 1)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& block = grid.block(blocks[i]);
    if (block.outer == outer && reaches(block.coordinate[0], block.coordinate[1])) add_of_block(grid, block, correction);
  }
}

void correct_lumped_mass(Grid& grid, std::span<const Boundary> boundaries, double density, double relaxed, const MirrorPlanes& mirror,
                         const std::function<void(std::span<const std::int32_t>)>& try_boundaries) {
  std::vector<const UprightSolid*> solids;
  for (const Boundary& boundary : boundaries) {
    if (const auto* const solid = std::get_if<SurfaceSolid>(&boundary)) solids.push_back(&solid->solid());
  }
  const LumpedMassCorrection corrected(std::move(solids), grid.cell_size(), density, relaxed);
  const Columns columns = corrected.columns();  // with particles that may take part
  // Particles of `columns` touch nodes up to one block further. A column of nodes along x or y that holds one of them has its master at
  // most one block away: boundaries act in blocks -1 .. +2; its slaves are at most one block further: -2 .. +3 change.
  const auto acted = blocks_in(grid, extended(columns, 1, 2)), changed = blocks_in(grid, extended(columns, 2, 3));
  const std::size_t count = grid.index_end();
  const std::span scratch = grid.scratch(count + changed.size());
  const std::span correction = scratch.first(count), untried = scratch.subspan(count);  // by index of block; as `changed`
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < changed.size(); ++i) {
    untried[i] = grid.velocities(changed[i]);
    correction[static_cast<std::size_t>(changed[i])] = NodeBlock{};
  }
  for (const auto b : grid.buffers()) correction[static_cast<std::size_t>(b)] = NodeBlock{};
  try_boundaries(acted);
  reflect_velocities(grid, mirror, acted);
  Ranks& ranks = grid.ranks();
  const auto near = [&](const Index3& block) { return corrected.reaches(block[0], block[1]); };
  ranks.send_nodes(NodeFields(grid), near);
  corrected.add_inner(grid, correction);
  ranks.receive_nodes(NodeFields(grid));
  corrected.add_outer(grid, correction);
  ranks.send_parts(NodeFields(correction), near);
  ranks.add_parts(NodeFields(correction));
  add_mirror_images(grid, mirror, NodeFields(correction), acted);
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < changed.size(); ++i) {
    const NodeBlock &before = untried[i], &more = correction[static_cast<std::size_t>(changed[i])];
    for (int n = 0; n < block_nodes; ++n) {
      const double mass = before.node[n][3];
      grid.velocities(changed[i]).node[n] = mass > 0.0 ? before.node[n] + more.node[n] / mass : before.node[n];
    }
  }
}

}  // namespace mpm
