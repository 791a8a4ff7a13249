#pragma once
/// Where blocks and nodes are: their coordinates, their numbers in a block, their neighbours, their positions; and the halo of a block, the
/// 6x6x6 nodes that its particles touch.
///
/// A block has 4x4x4 nodes. Its coordinate counts blocks along each axis; a node's index counts nodes, its position is index times dx. In
/// its block a node has the number x + 4 y + 16 z. A cell is a cube of positions with the same base node, x/dx from base + 1/2 to
/// base + 3/2: it is centred on node base + 1, and has the number of node base.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <type_traits>

#include "libmpm/base/types.hpp"

namespace mpm {

inline constexpr int block_edge = 4;  ///< cells and nodes per axis
/// Numbers along an axis of a block's first node, of the block that owns a node, and of the node in that block. Block 0 begins with node
/// -1: the first half cell before a wall or a mirror plane at the origin belongs to base node -1, and gets no layer of blocks of its own.
/// @{
constexpr std::int32_t first_node(std::int32_t block) { return block_edge * block - 1; }
constexpr std::int32_t block_of_node(std::int32_t node) { return (node + 1) >> 2; }
constexpr int place_of_node(std::int32_t node) { return (node + 1) & 3; }
/// @}
inline constexpr int block_nodes = 64;  ///< nodes a block owns
/// From a node of a block to the next one along an axis, in the numbers of nodes.
constexpr int node_stride(int axis) { return axis == 0 ? 1 : axis == 1 ? block_edge : block_edge * block_edge; }
/// Place of a block's node along an axis, 0 .. 3. @param node  its number in the block
constexpr int place_along(int axis, int node) {
  static_assert(block_edge == 4);
  return node >> 2 * axis & 3;
}
/// Numbers along the axes of one of a block's own nodes. @param node  x + 4 y + 16 z
constexpr Index3 node_index(const Index3& block, int node) {
  return {first_node(block[0]) + place_along(0, node), first_node(block[1]) + place_along(1, node),
          first_node(block[2]) + place_along(2, node)};
}
/// The block that owns a node, and the node's number in it: the inverse of node_index(). @{
constexpr Index3 block_of_node(const Index3& at) { return {block_of_node(at[0]), block_of_node(at[1]), block_of_node(at[2])}; }
constexpr int number_of_node(const Index3& at) {
  return place_of_node(at[0]) + node_stride(1) * place_of_node(at[1]) + node_stride(2) * place_of_node(at[2]);
}
/// @}
/// Position of one of a block's own nodes, m. @param node  x + 4 y + 16 z
inline Vec3 node_position(const Index3& block, int node, double cell_size) {
  const Index3 at = node_index(block, node);
  return cell_size * Vec3(at[0], at[1], at[2]);
}

/// A range of layers of blocks across an axis.
struct LayerRange {
  int axis = 2;                      ///< 0, 1, 2
  std::int32_t first = 0, last = 0;  ///< coordinates along it, of the lowest and the highest
};

/// The box in which a block's particles lie, m, up to rounding of a position on the edge of its cell.
/// @param around  cells added on every side
inline Eigen::AlignedBox3d block_box(const Index3& block, double cell_size, double around = 1e-6) {
  const Vec3 first(first_node(block[0]), first_node(block[1]), first_node(block[2]));
  const Vec3 low = first + Vec3::Constant(0.5 - around), high = first + Vec3::Constant(0.5 + block_edge + around);
  return {cell_size * low, cell_size * high};
}

inline constexpr int halo_edge = block_edge + 2;                      ///< nodes per axis that a block's particles touch
inline constexpr int halo_nodes = halo_edge * halo_edge * halo_edge;  ///< nodes that a block's particles touch
inline constexpr std::int32_t no_block = -1;                          ///< index if there is no block

/// Index of a node in a halo, the 6x6x6 nodes of a block. @param x, y, z  in [0, 6)
constexpr int halo_index(int x, int y, int z) { return x + halo_edge * (y + halo_edge * z); }
/// Index in a halo of the base node of a cell. @param cell  x + 4 y + 16 z
inline int first_halo_node(int cell) { return halo_index(cell & 3, cell >> 2 & 3, cell >> 4); }

/// Direction of a neighbour, 0 .. 26, from dx, dy, dz in {-1, 0, 1}; 13 is the block itself, 26 - direction the opposite one.
constexpr int direction_of(int dx, int dy, int dz) { return (dz + 1) * 9 + (dy + 1) * 3 + dx + 1; }
/// Coordinate of a neighbour.
constexpr Index3 neighbour_of(const Index3& block, int direction) {
  return {block[0] + direction % 3 - 1, block[1] + direction / 3 % 3 - 1, block[2] + direction / 9 - 1};
}
/// Directions of the eight blocks (itself and its forward neighbours) that hold the nodes of a block's particles. Number k: bit 0 is one
/// block along x, bit 1 along y, bit 2 along z.
inline constexpr std::array<int, 8> forward_directions = {direction_of(0, 0, 0), direction_of(1, 0, 0), direction_of(0, 1, 0),
                                                          direction_of(1, 1, 0), direction_of(0, 0, 1), direction_of(1, 0, 1),
                                                          direction_of(0, 1, 1), direction_of(1, 1, 1)};
/// Parity of a block's coordinates, a bit an axis: blocks of one colour share no node.
constexpr int colour_of(const Index3& block) { return (block[0] & 1) | (block[1] & 1) << 1 | (block[2] & 1) << 2; }
/// Whether block a comes before block b in every list and every sum: by z, then y, then x.
constexpr bool comes_before(const Index3& a, const Index3& b) {
  if (a[2] != b[2]) return a[2] < b[2];
  return a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

/// Calls f(grid row, index of its first node in the halo, count) for every run of nodes that the halo shares with one block's storage.
/// @param neighbour  numbers of those blocks, by direction
template <class NodesOf, class F>
inline void for_each_halo_row(const std::array<std::int32_t, 27>& neighbour, NodesOf&& nodes_of, F&& f) {
  for (int bz = 0; bz < 2; ++bz) {
    for (int by = 0; by < 2; ++by) {
      auto* near = nodes_of(neighbour[static_cast<std::size_t>(direction_of(0, by, bz))]).node;
      auto* far = nodes_of(neighbour[static_cast<std::size_t>(direction_of(1, by, bz))]).node;
      for (int z = 0; z < (bz == 0 ? 4 : 2); ++z) {
        for (int y = 0; y < (by == 0 ? 4 : 2); ++y) {
          const int first = halo_index(0, 4 * by + y, 4 * bz + z);
          f(near + 4 * y + 16 * z, first, std::integral_constant<int, 4>{});
          f(far + 4 * y + 16 * z, first + 4, std::integral_constant<int, 2>{});
        }
      }
    }
  }
}

}  // namespace mpm
