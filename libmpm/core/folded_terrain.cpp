#include "libmpm/core/folded_terrain.hpp"

#include <algorithm>
#include <cmath>

#include "libmpm/core/node_column.hpp"

namespace mpm {

namespace {

constexpr std::size_t most_nodes = 5;       ///< of a column, at the steepest slope
constexpr double support = 1.5;             ///< half the width of a quadratic B-spline, cells
constexpr double above = 4.0, below = 5.0;  ///< cells: no column reaches further from the ground

/// The column of nodes at one place in plan, and the ground there.
struct GroundColumn {
  ColumnPlan<most_nodes> plan{.axis = 2, .inward = -1};
  ColumnSurface surface;  ///< its gap: what touches the ground within the support of the nodes may be this far above it here

  GroundColumn(const Terrain& terrain, const Vec3& place, double cell_size) {
    const HeightField::Surface ground = terrain.surface(place);
    const double plane = ground.height / cell_size, steepness = ground.slope.cwiseAbs().sum();
    const double layer = std::ceil(plane + nearest_master - cell_rounding), distance = layer - plane;
    plan.master = static_cast<std::int32_t>(layer);
    for (std::size_t k = 0; k < most_nodes; ++k) plan.c[k] = (distance - static_cast<double>(k)) / distance;
    const double lowest = support * (1.0 + steepness);  // below the ground: material touches no node further down
    plan.used = static_cast<std::size_t>(std::clamp(std::ceil(distance + lowest - cell_rounding), 3.0, double{most_nodes}));
    surface = {ground.normal(), terrain.contact, terrain.friction, terrain.velocity(ground.slope), closed_gap + support * steepness};
  }
};

}  // namespace

std::vector<Impulse> apply_folded_terrain(Grid& grid, const Terrain& terrain, const MirrorPlanes& mirror,
                                          std::span<const std::int32_t> blocks) {
  const double dx = grid.cell_size();
  std::vector<Impulse> taken(blocks.size());  // by block of the master
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Index3& block = grid.block(blocks[i]).coordinate;
    const Vec3 low = node_position(block, 0, dx), high = low + Vec3::Constant((block_edge - 1) * dx);
    if (!terrain.reaches(low - Vec3(0.0, 0.0, above * dx), high, 0.0)) continue;
    for (int n = 0; n < block_edge * block_edge; ++n) {
      const GroundColumn ground(terrain, node_position(block, n, dx), dx);
      for (int z = 0; z < block_edge; ++z) {
        const std::int32_t behind = ground.plan.master - (first_node(block[2]) + z);
        if (behind < 0) break;
        act_at_node(grid, blocks[i], n + z * node_stride(2), behind, ground.plan, ground.surface, mirror, terrain.reference_point(),
                    taken[i]);
      }
    }
  }
  return taken;
}

LayerRange layers_of_columns(const Terrain& terrain, double cell_size) {
  const auto layer = [&](double height, double cells) {
    return block_of_node(static_cast<std::int32_t>(std::floor((height + terrain.shift.z()) / cell_size + cells)));
  };
  return {2, layer(terrain.field->lowest(), -below), layer(terrain.field->highest(), above)};
}

}  // namespace mpm
