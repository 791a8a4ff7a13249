#include "libmpm/core/mirror.hpp"

namespace mpm {

namespace {

/// Calls f(nodes, nodes behind or null, stride, flip) for every block at the mirror plane of `axis`: `stride` from a node to the next along
/// the axis, `flip` turns a node into its image.
template <class F>
void for_each_mirrored_block(Grid& grid, int axis, F&& f) {
  const int stride = axis == 0 ? 1 : 4;
  const auto slot = static_cast<std::size_t>(axis == 0 ? neighbour_slot(-1, 0, 0) : neighbour_slot(0, -1, 0));
  Node flip = {1, 1, 1, 1};
  flip[axis] = -1.0;
  for (const auto index : grid.all_blocks()) {
    const Block& block = grid.block(index);
    if (block.coordinate[static_cast<std::size_t>(axis)] != 0) continue;
    const std::int32_t behind = block.neighbour[slot];
    f(grid.nodes(index).node, behind == no_block ? nullptr : grid.nodes(behind).node, stride, flip);
  }
}

/// Adds the image of the plane behind (axis index -1) to the plane at +1, doubles the mirror plane, and sets the plane behind to the image.
void fold(Grid& grid, int axis) {
  for_each_mirrored_block(grid, axis, [](Node* nodes, Node* behind, int stride, Node flip) {
    for (int n = 0; n < block_nodes; ++n) {
      if ((n / stride) % 4 != 0) continue;
      nodes[n] += flip * nodes[n];
      if (behind == nullptr) continue;
      Node& image = behind[n + 3 * stride];
      nodes[n + stride] += flip * image;
      image = flip * nodes[n + stride];
    }
  });
}

/// Sets the plane behind to the image of the plane at +1 again, whose velocities a boundary may have changed.
void reflect(Grid& grid, int axis) {
  for_each_mirrored_block(grid, axis, [](const Node* nodes, Node* behind, int stride, Node flip) {
    for (int n = 0; behind != nullptr && n < block_nodes; ++n) {
      if ((n / stride) % 4 == 0) behind[n + 3 * stride] = flip * nodes[n + stride];
    }
  });
}

}  // namespace

void fold_mirror_planes(Grid& grid, const MirrorPlanes& mirror) {
  if (mirror.x) fold(grid, 0);
  if (mirror.y) fold(grid, 1);
}

void reflect_velocities(Grid& grid, const MirrorPlanes& mirror) {
  if (mirror.x) reflect(grid, 0);
  if (mirror.y) reflect(grid, 1);
}

}  // namespace mpm
