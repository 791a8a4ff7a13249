#include "libmpm/core/lumped_mass.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "libmpm/base/bspline.hpp"
#include "libmpm/core/particle_groups.hpp"

namespace mpm {

namespace {

constexpr double outer_reach = LumpedMassCorrection::full_reach + LumpedMassCorrection::fade;

/// One particle's weights of its 27 nodes.
struct Kernel {
  double w[27];
  Vec3 arm[27];  ///< x_i - x_p, cells

  /// @param f  offset from the base node, cells
  explicit Kernel(const Vec3& f) {
    double along[3][3];
    for (int axis = 0; axis < 3; ++axis) {
      const BsplineWeights<double> n = bspline_weights(f[axis]);
      along[axis][0] = n.n0;
      along[axis][1] = n.n1;
      along[axis][2] = n.n2;
    }
    for (int n = 0; n < 27; ++n) {
      const int i = n % 3, j = n / 3 % 3, k = n / 9;
      w[n] = along[0][i] * along[1][j] * along[2][k];
      arm[n] = Vec3(i, j, k) - f;
    }
  }
  /// Place of node n in the halo. @param first  that of the base node
  static int place(int first, int n) { return first + halo_index(n % 3, n / 3 % 3, n / 9); }
};

/// The fields on the nodes that a block's particles touch.
struct Fields {
  Node gained[halo_nodes];  ///< v - u: what forces and boundaries changed
  Node before[halo_nodes];  ///< u

  Fields(const Grid& grid, const Block& block) {
    for_each_halo_row(
        block.neighbour, [&](std::int32_t b) -> const NodeBlock& { return grid.old_nodes(b); },
        [&](const Node* row, int first, auto count) {
          for (int n = 0; n < count; ++n) before[first + n] = row[n];
        });
    for_each_halo_row(
        block.neighbour, [&](std::int32_t b) -> const NodeBlock& { return grid.nodes(b); },
        [&](const Node* row, int first, auto count) {
          for (int n = 0; n < count; ++n) gained[first + n] = row[n] - before[first + n];
        });
  }
};

/// Half of the curl of a field at a particle, for each cell: the skew part of its gradient is S r = rotation x r.
/// @param first  place of the base node in the halo
Vec3 rotation_of(const Kernel& kernel, int first, const Node* field) {
  Node slope[3] = {};
  for (int i = 0; i < 27; ++i) {
    const Node a = kernel.w[i] * field[Kernel::place(first, i)];
    for (int axis = 0; axis < 3; ++axis) slope[axis] += 4.0 * kernel.arm[i][axis] * a;
  }
  return 0.5 * Vec3(slope[1][2] - slope[2][1], slope[2][0] - slope[0][2], slope[0][1] - slope[1][0]);
}

}  // namespace

bool need_lumped_mass_correction(std::span<const Boundary> boundaries) {
  return std::ranges::any_of(boundaries, [](const Boundary& b) { return std::holds_alternative<SurfaceSolid>(b); });
}

double LumpedMassCorrection::share(const Vec3& x) const {
  const double distance = std::max(distance_.outside(x.head<2>()), x.z() - top_) / dx_;
  return std::clamp((outer_reach - distance) / fade, 0.0, 1.0);
}

bool LumpedMassCorrection::reaches(std::int32_t x, std::int32_t y) const {
  constexpr double half_diagonal = 0.5 * block_edge * 1.4143, to_centre = 0.5 * block_edge + 0.5;  // cells hold x/dx from base + 1/2 on
  const Vec2 centre = dx_ * (double{block_edge} * Vec2(x, y) + Vec2::Constant(to_centre));
  return distance_.outside(centre) <= (outer_reach + half_diagonal) * dx_;
}

void LumpedMassCorrection::add_of_block(const Grid& grid, const Block& block, std::span<NodeBlock> change) const {
  const ParticleBin& bin = block.particles;
  const Fields fields(grid, block);
  const bool keeps_moment = relaxed_ == 1.0;  // APIC
  Node sum[halo_nodes] = {};
  bool any = false;
  for (int cell = 0; cell < block_nodes; ++cell) {
    const Vec3 base = node_position(block.coordinate, cell, dx_) / dx_;
    const int first = first_halo_node(cell);
    for (int n = bin.cell_start[cell]; n < bin.cell_start[cell + 1]; ++n) {
      const Particle p = bin[bin.order[static_cast<std::size_t>(n)]];
      const Vec3 x(p.position[0], p.position[1], p.position[2]);
      const double mass = share(x) * density_ * p.volume;
      if (mass == 0.0) continue;
      any = true;
      const Kernel kernel(x / dx_ - base);
      Node gained{}, before{}, gradient[3] = {};
      for (int i = 0; i < 27; ++i) {
        const int at = Kernel::place(first, i);
        gained += kernel.w[i] * fields.gained[at];
        const Node u = kernel.w[i] * fields.before[at];
        before += u;
        for (int axis = 0; axis < 3; ++axis) gradient[axis] += 4.0 * kernel.arm[i][axis] * u;
      }
      const Vec3 turn = keeps_moment ? rotation_of(kernel, first, fields.gained) : Vec3(Vec3::Zero());
      for (int i = 0; i < 27; ++i) {
        const int at = Kernel::place(first, i);
        const Vec3& arm = kernel.arm[i];
        const Node beyond_linear = fields.before[at] - before - arm.x() * gradient[0] - arm.y() * gradient[1] - arm.z() * gradient[2];
        const Vec3 turned = turn.cross(arm);
        sum[at] +=
            (mass * kernel.w[i]) * (fields.gained[at] - gained - Node{turned.x(), turned.y(), turned.z(), 0.0} + relaxed_ * beyond_linear);
      }
    }
  }
  if (!any) return;
  for_each_halo_row(
      block.parts != nullptr ? *block.parts : block.neighbour,
      [&](std::int32_t b) -> NodeBlock& { return change[static_cast<std::size_t>(b)]; },
      [&](Node* row, int first, auto count) {
        for (int n = 0; n < count; ++n) row[n] += Node{sum[first + n][0], sum[first + n][1], sum[first + n][2], 0.0};
      });
}

void LumpedMassCorrection::add(const Grid& grid, std::span<NodeBlock> change) const {
  for (int colour = 0; colour < 8; ++colour) {
    const auto blocks = grid.coloured_blocks(colour);
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const Block& block = grid.block(blocks[i]);
      if (reaches(block.coordinate[0], block.coordinate[1])) add_of_block(grid, block, change);
    }
  }
}

}  // namespace mpm
