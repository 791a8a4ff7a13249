#include "libmpm/core/joined_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "libmpm/core/folded_wall.hpp"
#include "libmpm/core/lumped_mass.hpp"

namespace mpm {

namespace {

template <class Map, class Key>
Key lowest_of(const Map& map, const Key& key) {
  const auto found = map.find(key);
  return found == map.end() ? key : found->second;
}

/// Columns of blocks whose particles take part in the correction before a curved side.
std::vector<std::array<std::int32_t, 2>> reached_columns(const SurfaceSolid& solid, double cell_size) {
  const LumpedMassCorrection correction(solid, cell_size, 0.0, 0.0);
  const Circle& circle = *solid.outline().circle;
  const double reach = circle.radius / cell_size + LumpedMassCorrection::full_reach + LumpedMassCorrection::fade;
  const auto blocks = static_cast<std::int32_t>(std::ceil(reach / block_edge)) + 1;
  const auto middle = [&](double x) { return static_cast<std::int32_t>(std::floor(x / (block_edge * cell_size))); };
  std::vector<std::array<std::int32_t, 2>> columns;
  for (std::int32_t x = middle(circle.centre.x()) - blocks; x <= middle(circle.centre.x()) + blocks; ++x) {
    for (std::int32_t y = middle(circle.centre.y()) - blocks; y <= middle(circle.centre.y()) + blocks; ++y) {
      if (correction.reaches(x, y)) columns.push_back({x, y});
    }
  }
  return columns;
}

}  // namespace

JoinedBlocks::JoinedBlocks(const Scene& scene, double cell_size, double time) {
  std::array<std::set<std::int32_t>, 3> lower;  // joined with the layer above it
  const auto join = [&](const std::optional<JoinedLayers>& layers) {
    if (layers) lower[static_cast<std::size_t>(layers->axis)].insert(layers->lower);
  };
  if (scene.mirror.x) lower[0].insert(-1);
  if (scene.mirror.y) lower[1].insert(-1);
  for (const Boundary& boundary : scene.boundaries) {
    const Wall* const wall = plane_of(boundary);
    if (wall != nullptr && folds(*wall, scene.boundaries, scene.mirror, cell_size, time)) join(layers_of_columns(*wall, cell_size, time));
  }
  const auto add = [](Layers& layers, std::int32_t below, std::int32_t above) {
    if (below != above) layers[above] = lowest_of(layers, below);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const std::int32_t below : lower[axis]) add(layers_[axis], below, below + 1);  // rising, so that chains are found
  }
  std::set<std::int32_t> in_columns = lower[2];
  for (const Boundary& boundary : scene.boundaries) {
    const auto* const solid = std::get_if<SurfaceSolid>(&boundary);
    if (solid == nullptr) continue;
    join_columns(*solid, cell_size);
    if (LumpedMassCorrection::concerns(*solid)) whole_columns_ = true;
    if (const auto top = layers_of_top(*solid, cell_size)) in_columns.insert(top->lower);
  }
  for (const std::int32_t below : in_columns) add(pairs_, below >> 1, (below + 1) >> 1);
}

void JoinedBlocks::join_columns(const SurfaceSolid& solid, double cell_size) {
  std::set<Column> mine;
  const auto add = [&](std::int32_t x, std::int32_t y) { mine.insert({lowest_of(layers_[0], x), lowest_of(layers_[1], y)}); };
  for (const auto& node : solid.stencil().nodes) add(node.at[0] >> 2, node.at[1] >> 2);
  if (LumpedMassCorrection::concerns(solid)) {
    for (const Column& column : reached_columns(solid, cell_size)) {  // their particles touch the next columns, too
      for (const std::int32_t x : {0, 1}) {
        for (const std::int32_t y : {0, 1}) add(column[0] + x, column[1] + y);
      }
    }
  }
  if (mine.empty()) return;
  const Column all = *mine.begin();
  for (const Column& column : mine) {
    const Column before = lowest_of(columns_, column);
    for (auto& [other, stands_for] : columns_) {
      if (stands_for == before) stands_for = all;  // another solid's that shares a column
    }
    columns_[column] = all;
  }
}

Index3 JoinedBlocks::representative(const Index3& block) const {
  const Index3 layer = {lowest_of(layers_[0], block[0]), lowest_of(layers_[1], block[1]), lowest_of(layers_[2], block[2])};
  const auto column = columns_.find({layer[0], layer[1]});
  if (column == columns_.end()) return layer;
  return {column->second[0], column->second[1], whole_columns_ ? 0 : 2 * lowest_of(pairs_, block[2] >> 1)};
}

}  // namespace mpm
