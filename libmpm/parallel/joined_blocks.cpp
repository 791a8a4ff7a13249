#include "libmpm/parallel/joined_blocks.hpp"

#include <set>

#include "libmpm/core/folded_terrain.hpp"
#include "libmpm/core/folded_wall.hpp"
#include "libmpm/core/surface_contact.hpp"

namespace mpm {

namespace {

template <class Map, class Key>
Key lowest_of(const Map& map, const Key& key) {
  const auto found = map.find(key);
  return found == map.end() ? key : found->second;
}

}  // namespace

JoinedBlocks::JoinedBlocks(const Scene& scene, double cell_size, double time) {
  std::array<std::set<std::int32_t>, 3> lower;  // joined with the layer above it
  const auto join = [](std::set<std::int32_t>& below, const LayerRange& layers) {
    for (std::int32_t layer = layers.first; layer < layers.last; ++layer) below.insert(layer);
  };
  for (const Boundary& boundary : scene.boundaries) {
    const auto* const wall = std::get_if<Wall>(&boundary);
    if (wall != nullptr && folds(*wall, scene.boundaries, scene.mirror, cell_size, time)) {
      const LayerRange layers = layers_of_columns(*wall, cell_size, time);
      join(lower[static_cast<std::size_t>(layers.axis)], layers);
    }
    const auto* const terrain = std::get_if<Terrain>(&boundary);
    if (terrain != nullptr && terrain->rule == ContactRule::surface) join(lower[2], layers_of_columns(*terrain, cell_size));
  }
  const auto add = [](Layers& layers, std::int32_t below, std::int32_t above) {
    if (below != above) layers[above] = lowest_of(layers, below);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const std::int32_t below : lower[axis]) add(layers_[axis], below, below + 1);  // ascending, so that chains are found
  }
  std::set<std::int32_t> in_columns = lower[2];
  for (const Boundary& boundary : scene.boundaries) {
    const auto* const solid = std::get_if<SurfaceSolid>(&boundary);
    if (solid == nullptr) continue;
    join_columns(*solid);
    for (const LayerRange& face : layers_of_faces(*solid, cell_size)) join(in_columns, face);
    for (const LayerRange& ends : layers_of_ends(solid->solid(), cell_size)) join(in_columns, ends);
  }
  for (const std::int32_t below : in_columns) add(pairs_, below >> 1, (below + 1) >> 1);
}

void JoinedBlocks::join_columns(const SurfaceSolid& solid) {
  std::set<Column> mine;
  const auto add = [&](std::int32_t x, std::int32_t y) { mine.insert({lowest_of(layers_[0], x), lowest_of(layers_[1], y)}); };
  for (const auto& node : solid.stencil().nodes) add(block_of_node(node.at[0]), block_of_node(node.at[1]));
  if (mine.empty()) return;
  const Column all = *mine.begin();
  for (const Column& column : mine) {
    const Column before = lowest_of(columns_, column);
    for (auto& [other, group] : columns_) {
      if (group == before) group = all;  // of another solid with a common column
    }
    columns_[column] = all;
  }
}

Index3 JoinedBlocks::representative(const Index3& block) const {
  const Index3 layer = {lowest_of(layers_[0], block[0]), lowest_of(layers_[1], block[1]), lowest_of(layers_[2], block[2])};
  const auto column = columns_.find({layer[0], layer[1]});
  if (column == columns_.end()) return layer;
  return {column->second[0], column->second[1], 2 * lowest_of(pairs_, block[2] >> 1)};
}

}  // namespace mpm
