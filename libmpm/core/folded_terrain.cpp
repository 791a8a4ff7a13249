#include "libmpm/core/folded_terrain.hpp"

#include <algorithm>
#include <cmath>

#include "libmpm/core/node_column.hpp"

namespace mpm {

namespace {

constexpr std::size_t most_nodes = 5;       ///< of a column, at the steepest slope
constexpr double support = 1.5;             ///< half the width of a quadratic B-spline, cells
constexpr double rounding = 1e-9;           ///< cells
constexpr double above = 4.0, below = 5.0;  ///< cells: no column reaches further from the ground

using Column = NodeColumn<most_nodes>;

/// The column of nodes at one place in plan.
struct GroundColumn {
  HeightField::Surface surface;
  std::int32_t master;               ///< number of its layer
  std::array<double, most_nodes> c;  ///< velocity relative to that of the master
  std::size_t used;                  ///< number of its nodes
  double gap;                        ///< cells: what touches the ground within the support of its nodes may be this far above it here

  GroundColumn(const Terrain& terrain, const Vec3& place, double cell_size) : surface(terrain.surface(place)) {
    const double plane = surface.height / cell_size, steepness = surface.slope.cwiseAbs().sum();
    const double layer = std::ceil(plane + nearest_master - rounding), distance = layer - plane;
    master = static_cast<std::int32_t>(layer);
    for (std::size_t k = 0; k < most_nodes; ++k) c[k] = (distance - static_cast<double>(k)) / distance;
    gap = closed_gap + support * steepness;
    const double lowest = support * (1.0 + steepness);  // below the ground: material touches no node further down
    used = static_cast<std::size_t>(std::clamp(std::ceil(distance + lowest - rounding), 3.0, double{most_nodes}));
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
    NodeBlock& nodes = grid.velocities(blocks[i]);
    for (int n = 0; n < block_edge * block_edge; ++n) {
      const GroundColumn ground(terrain, node_position(block, n, dx), dx);
      const Vec3 normal = ground.surface.normal(), moving = terrain.velocity(ground.surface.slope);
      const auto write = [&](const NodeAt& at, const Vec3& velocity) {
        set_velocity(grid, at, mirror, moving, velocity, terrain.reference_point(), taken[i]);
      };
      for (int z = 0; z < block_edge; ++z) {
        const int number = n + z * node_stride(2);
        const std::int32_t inward = ground.master - (first_node(block[2]) + z);
        Node& node = nodes.node[number];
        if (inward < 0) break;
        if (inward > 0) {  // skip slaves of a master in an existing block; any other node acts alone
          if (inward < static_cast<std::int32_t>(ground.used) && node_at(grid, blocks[i], number, 2, inward).node != nullptr) continue;
          if (node[3] <= 0.0) continue;
          const Vec3 before(node[0], node[1], node[2]);
          write({&node, blocks[i], number}, contact_velocity(before, normal, moving, terrain.contact, terrain.friction) - moving);
          continue;
        }
        Column column{{}, ground.c};
        if (!collect_column(grid, blocks[i], number, 2, -1, moving, column, ground.used)) continue;
        if (!act_on_column(column, {normal, terrain.contact, terrain.friction, ground.gap})) continue;
        for (const ColumnNode& c : column.node) {
          if (c.mass > 0.0) write(c.at, c.velocity);
        }
      }
    }
  }
  return taken;
}

TerrainLayers layers_of_columns(const Terrain& terrain, double cell_size) {
  const auto layer = [&](double height, double cells) {
    return block_of_node(static_cast<std::int32_t>(std::floor((height + terrain.shift.z()) / cell_size + cells)));
  };
  return {layer(terrain.field->lowest(), -below), layer(terrain.field->highest(), above)};
}

}  // namespace mpm
