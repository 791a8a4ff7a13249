#include "libmpm/core/mirror.hpp"

namespace mpm {

namespace {

/// Calls f(plane, before, behind, flip) for the nodes next to the mirror plane of `axis`, which all are in the same block: the one on the
/// plane, those one node before and behind it, and what turns a node into its image.
/// @param blocks  numbers of those to look at. @param nodes_of  NodeBlock& of a block's number: which field
template <class NodesOf, class F>
void for_each_mirrored_node(const Grid& grid, std::span<const std::int32_t> blocks, int axis, NodesOf&& nodes_of, F&& f) {
  static_assert(block_of_node(-1) == block_of_node(1));
  const int stride = node_stride(axis);
  Node flip = {1, 1, 1, 1};
  flip[axis] = -1.0;
  for (const auto index : blocks) {
    if (grid.block(index).coordinate[static_cast<std::size_t>(axis)] != block_of_node(0)) continue;
    Node* const nodes = nodes_of(index).node;
    for (int n = 0; n < block_nodes; ++n) {
      if (place_along(axis, n) == place_of_node(0)) f(nodes[n], nodes[n + stride], nodes[n - stride], flip);
    }
  }
}

}  // namespace

void add_mirror_images(const Grid& grid, const MirrorPlanes& mirror, const NodeFields& fields, std::span<const std::int32_t> blocks) {
  for (int axis = 0; axis < 2; ++axis) {
    if (!mirror.across(axis)) continue;
    for (int f = 0; f < fields.count(); ++f) {
      const auto nodes_of = [&](std::int32_t b) -> NodeBlock& { return fields.of(b, f); };
      for_each_mirrored_node(grid, blocks, axis, nodes_of, [](Node& plane, Node& before, Node& behind, Node flip) {
        plane += flip * plane;  // its own image: cancels the normal momentum
        before += flip * behind;
        behind = flip * before;
      });
    }
  }
}

void reflect_velocities(Grid& grid, const MirrorPlanes& mirror, std::span<const std::int32_t> blocks) {
  const auto nodes_of = [&](std::int32_t b) -> NodeBlock& { return grid.velocities(b); };
  for (int axis = 0; axis < 2; ++axis) {
    if (!mirror.across(axis)) continue;
    for_each_mirrored_node(grid, blocks, axis, nodes_of, [](Node& plane, const Node& before, Node& behind, Node flip) {
      plane = 0.5 * (plane + flip * plane);  // a boundary that the plane cuts may have given it a velocity across
      behind = flip * before;
    });
  }
}

}  // namespace mpm
