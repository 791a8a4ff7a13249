#include "libmpm/core/mirror.hpp"

namespace mpm {

namespace {

/// Calls f(nodes, nodes behind or null, stride, flip) for every block at the mirror plane of `axis`: `stride` from a node to the next along
/// the axis, `flip` turns a node into its image.
/// @param blocks  numbers of those to look at. @param nodes_of  NodeBlock& of a block's number: which field
template <class NodesOf, class F>
void for_each_mirrored_block(const Grid& grid, std::span<const std::int32_t> blocks, int axis, NodesOf&& nodes_of, F&& f) {
  const int stride = node_stride(axis);
  const auto slot = static_cast<std::size_t>(axis == 0 ? neighbour_slot(-1, 0, 0) : neighbour_slot(0, -1, 0));
  Node flip = {1, 1, 1, 1};
  flip[axis] = -1.0;
  for (const auto index : blocks) {
    const Block& block = grid.block(index);
    if (block.coordinate[static_cast<std::size_t>(axis)] != 0) continue;
    const std::int32_t behind = block.neighbour[slot];
    f(nodes_of(index).node, behind == no_block ? nullptr : nodes_of(behind).node, stride, flip);
  }
}

/// Adds the image of the plane behind (axis index -1) to the plane at +1, doubles the mirror plane, and sets the plane behind to the image.
template <class NodesOf>
void fold(const Grid& grid, std::span<const std::int32_t> blocks, int axis, NodesOf&& nodes_of) {
  for_each_mirrored_block(grid, blocks, axis, nodes_of, [axis](Node* nodes, Node* behind, int stride, Node flip) {
    for (int n = 0; n < block_nodes; ++n) {
      if (place_along(axis, n) != 0) continue;
      nodes[n] += flip * nodes[n];
      if (behind == nullptr) continue;
      Node& image = behind[n + 3 * stride];
      nodes[n + stride] += flip * image;
      image = flip * nodes[n + stride];
    }
  });
}

/// Renews the plane behind as the image of the plane at +1, whose velocities a boundary may have changed.
void reflect(Grid& grid, std::span<const std::int32_t> blocks, int axis) {
  const auto nodes_of = [&](std::int32_t b) -> NodeBlock& { return grid.nodes(b); };
  for_each_mirrored_block(grid, blocks, axis, nodes_of, [axis](const Node* nodes, Node* behind, int stride, Node flip) {
    for (int n = 0; behind != nullptr && n < block_nodes; ++n) {
      if (place_along(axis, n) == 0) behind[n + 3 * stride] = flip * nodes[n + stride];
    }
  });
}

}  // namespace

void fold_mirror_planes(Grid& grid, const MirrorPlanes& mirror) {
  for (int axis = 0; axis < 2; ++axis) {
    if (!(axis == 0 ? mirror.x : mirror.y)) continue;
    fold(grid, grid.all_blocks(), axis, [&](std::int32_t b) -> NodeBlock& { return grid.nodes(b); });
    if (grid.keeps_old_nodes()) fold(grid, grid.all_blocks(), axis, [&](std::int32_t b) -> NodeBlock& { return grid.old_nodes(b); });
  }
}

void fold_mirror_planes(const Grid& grid, const MirrorPlanes& mirror, std::span<NodeBlock> field, std::span<const std::int32_t> blocks) {
  const auto nodes_of = [&](std::int32_t b) -> NodeBlock& { return field[static_cast<std::size_t>(b)]; };
  for (int axis = 0; axis < 2; ++axis) {
    if (axis == 0 ? mirror.x : mirror.y) fold(grid, blocks, axis, nodes_of);
  }
}

void reflect_velocities(Grid& grid, const MirrorPlanes& mirror, std::span<const std::int32_t> blocks) {
  if (mirror.x) reflect(grid, blocks, 0);
  if (mirror.y) reflect(grid, blocks, 1);
}

}  // namespace mpm
