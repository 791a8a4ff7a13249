#include "libmpm/core/folded_wall.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "libmpm/core/node_column.hpp"

namespace mpm {

namespace {

constexpr int column_nodes = 3;                                        ///< a master and two slaves
constexpr double unbounded = std::numeric_limits<double>::infinity();  ///< kg m/s

/// The axis a wall is normal to; empty for an oblique one.
std::optional<int> axis_of(const Wall& wall) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(std::abs(wall.normal[axis]) - 1.0) < 1e-12) return axis;
  }
  return std::nullopt;
}

using Plan = ColumnPlan<column_nodes>;

Plan plan_of(const Wall& wall, int axis, double cell_size, double time) {
  const double sign = wall.normal[axis] > 0.0 ? 1.0 : -1.0;
  const double plane = sign * wall.plane_distance(time) / cell_size;  // coordinate, in cells
  const double master = sign > 0.0 ? std::ceil(plane + nearest_master - cell_rounding) : std::floor(plane - nearest_master + cell_rounding);
  const double d = sign * (master - plane);
  return {axis, sign > 0.0 ? -1 : 1, static_cast<std::int32_t>(master), {1.0, (d - 1.0) / d, (d - 2.0) / d}};
}

ColumnSurface surface_of(const Wall& wall, const Plan& plan) { return {-plan.inward * Vec3::Unit(plan.axis), wall.contact, wall.friction}; }

/// Top and underside of a solid as walls; empty where it has none.
std::array<std::optional<Wall>, 2> faces_of(const SurfaceSolid& solid) {
  const auto face = [&](double z, const Vec3& normal) -> std::optional<Wall> {
    if (!std::isfinite(z)) return {};
    return Wall{Vec3(0.0, 0.0, z), normal, Contact::separable, solid.friction(), Vec3::Zero(), false, ContactRule::surface};
  };
  return {face(solid.solid().top, Vec3::UnitZ()), face(solid.solid().base, -Vec3::UnitZ())};
}

void apply_folded_face(Grid& grid, const SurfaceSolid& solid, const Wall& face, const MirrorPlanes& mirror, double density, double dt,
                       std::vector<ContactImpulse::Part>& parts) {
  const Plan plan = plan_of(face, 2, grid.cell_size(), 0.0);
  const auto& columns = solid.stencil().columns;
  std::vector<double> taken(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::array<int, 2> plan_at = solid.stencil().nodes[static_cast<std::size_t>(columns[i].node)].at;
    const Index3 at = {plan_at[0], plan_at[1], plan.master};
    const std::int32_t block = grid.find(block_of_node(at));
    if (block == no_block) continue;
    const int number = number_of_node(at);
    NodeColumn<column_nodes> column{{}, plan.c};
    // without material at the master nothing lies on the face: what is behind it is beside the solid
    if (!collect_column(grid, block, number, plan, Vec3::Zero(), column) || column.node[0].mass <= 0.0) continue;
    double bound = unbounded;
    if (const EdgeBound& edge = columns[i].edge; edge.neighbour >= 0) {
      double along = 0.0;  // square of the largest velocity along the face: the flow is fastest at the surface, next to the edge
      for (const ColumnNode& c : column.node) along = std::max(along, c.before.head<2>().squaredNorm());
      bound =
          edge.largest(taken[static_cast<std::size_t>(edge.neighbour)], 0.5 * density * along * columns[i].strip * grid.cell_size() * dt);
    }
    const std::optional<double> normal = fold_column(column, surface_of(face, plan), bound);
    if (!normal) continue;
    taken[i] = *normal;
    for (int k = 0; k < column_nodes; ++k) {
      const ColumnNode& c = column.node[static_cast<std::size_t>(k)];
      if (c.mass <= 0.0) continue;
      Impulse given;
      set_velocity(grid, c.at, mirror, Vec3::Zero(), c.velocity, solid.reference_point(), given);
      parts.push_back({plan.master + plan.inward * k, given});  // the layers are those of all blocks in the columns of the stencil
    }
  }
}

}  // namespace

bool folds(const Wall& wall, std::span<const Boundary> boundaries, const MirrorPlanes& mirror, double cell_size, double time) {
  if (wall.rule != ContactRule::surface) return false;
  const std::optional<int> axis = axis_of(wall);
  if (!axis) return false;
  const std::int32_t plane = plan_of(wall, *axis, cell_size, time).master;
  if (mirror.across(*axis) && plane <= 0) return false;
  Vec3 master = wall.point;
  master[*axis] = cell_size * plane;
  return std::ranges::none_of(boundaries, [&](const Boundary& other) {
    const auto* const parallel = std::get_if<Wall>(&other);
    if (parallel == nullptr || parallel->normal.dot(wall.normal) > -0.5) return false;
    // a coupled wall's own master is the first node half a cell before it, so it is another node only if there is a cell between
    return parallel->normal.dot(master) - parallel->plane_distance(time) < (nearest_master + 1.0 - cell_rounding) * cell_size;
  });
}

std::vector<Impulse> apply_folded_wall(Grid& grid, const Wall& wall, const MirrorPlanes& mirror, double time,
                                       std::span<const std::int32_t> blocks) {
  const double dx = grid.cell_size();
  const int axis = axis_of(wall).value();
  const Plan plan = plan_of(wall, axis, dx, time);
  ColumnSurface surface = surface_of(wall, plan);
  std::vector<Impulse> taken(blocks.size());  // by block of the master
#pragma omp parallel for schedule(static, 8) firstprivate(surface)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Index3& block = grid.block(blocks[i]).coordinate;
    const std::int32_t first = first_node(block[static_cast<std::size_t>(axis)]);
    // range of the block's nodes, in steps from the masters' plane into the wall
    const std::int32_t from = plan.inward * (first - plan.master), to = plan.inward * (first + block_edge - 1 - plan.master);
    if (std::max(from, to) < 0) continue;
    for (int n = 0; n < block_nodes; ++n) {
      const std::int32_t behind = plan.inward * (first + place_along(axis, n) - plan.master);
      if (behind < 0) continue;
      surface.velocity = wall.surface_velocity(node_position(block, n, dx), time);
      act_at_node(grid, blocks[i], n, behind, plan, surface, mirror, wall.point, taken[i]);
    }
  }
  return taken;
}

LayerRange layers_of_columns(const Wall& wall, double cell_size, double time) {
  const Plan plan = plan_of(wall, axis_of(wall).value(), cell_size, time);
  const std::int32_t master = block_of_node(plan.master), last = block_of_node(plan.master + (column_nodes - 1) * plan.inward);
  return {plan.axis, std::min(master, last), std::max(master, last)};
}

std::vector<LayerRange> layers_of_faces(const SurfaceSolid& solid, double cell_size) {
  std::vector<LayerRange> layers;
  for (const auto& face : faces_of(solid)) {
    if (face) layers.push_back(layers_of_columns(*face, cell_size, 0.0));
  }
  return layers;
}

void apply_folded_faces(Grid& grid, const SurfaceSolid& solid, const MirrorPlanes& mirror, double density, double dt,
                        ContactImpulse& impulse) {
  const auto faces = faces_of(solid);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (faces[f]) apply_folded_face(grid, solid, *faces[f], mirror, density, dt, impulse.faces[f]);
  }
}

}  // namespace mpm
