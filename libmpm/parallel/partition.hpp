#pragma once
/// Which rank owns which block: intervals of a curve through the blocks.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "libmpm/parallel/joined_blocks.hpp"

namespace mpm {

/// A curve through all blocks. The key of a block is its position on the curve: the bits of its coordinates in a fixed order.
struct Curve {
  std::array<int, 3> spacing;  ///< by axis: places between two bits of a coordinate, 1 to 3
  std::array<int, 3> shift;    ///< by axis: place of the lowest bit
  bool operator==(const Curve&) const = default;

  /// Position of a block on this curve, below 2^63.
  [[nodiscard]] std::uint64_t key(const Index3& block) const;
  /// All bits interleaved: neighbours on the curve are close in space.
  static constexpr Curve morton() { return {{3, 3, 3}, {0, 1, 2}}; }
  /// The Morton curve; for each axis the Morton curve through columns along this axis; the six orders layer by layer. Few ranks have the
  /// shortest borders with layers, many ranks with a Morton curve; columns suit a flow that is shallow in one direction.
  static std::vector<Curve> all();
};

/// Position of a block on the Morton curve.
[[nodiscard]] inline std::uint64_t morton_key(const Index3& block) { return Curve::morton().key(block); }

/// A block and how many particles it holds.
struct BlockHead {
  Index3 block{};          ///< its coordinate
  std::int32_t count = 0;  ///< its particles
};

/// Cost of a block.
struct Load {
  Index3 block{};     ///< its coordinate
  double cost = 0.0;  ///< positive, in any unit
};

/// The owner of every possible block. It follows from the block's coordinate, so no rank needs a list of blocks.
class Partition {
 public:
  /// Rank 0 owns all blocks.
  explicit Partition(int ranks);
  bool operator==(const Partition&) const = default;

  [[nodiscard]] int owner(const Index3& block) const;          ///< rank
  [[nodiscard]] bool at_border(const Index3& block) const;     ///< whether a neighbour of the block has another owner
  [[nodiscard]] std::uint64_t key(const Index3& block) const;  ///< of its representative
  /// From now on these blocks have one owner together.
  void join(const JoinedBlocks& joined) { joined_ = joined; }
  [[nodiscard]] const Curve& curve() const { return curve_; }                  ///< through the blocks
  [[nodiscard]] std::span<const std::uint64_t> cuts() const { return cuts_; }  ///< rank r owns keys from cuts[r - 1] to below cuts[r]
  /// Takes other cuts, ascending, one fewer than ranks.
  void set(const Curve& curve, std::vector<std::uint64_t> cuts) { curve_ = curve, cuts_ = std::move(cuts); }

  /// Cuts the curve so that every rank gets its part of the cost, to within half a block or half of the blocks joined with it.
  /// @param loads  in any order. @param weights  relative cost for each rank; positive sum
  void cut(std::span<const Load> loads, std::span<const double> weights);
  /// Chooses the curve for which the rank with most work has least, and cuts it. Work is the cost, and a fifth more for blocks at a border.
  void choose_curve(std::span<const Load> loads, std::span<const double> weights);
  /// The largest cost of a rank. @param at_border  added to the cost of a block at a border, as a fraction of it
  [[nodiscard]] double largest_cost(std::span<const Load> loads, double at_border = 0.0) const;

 private:
  JoinedBlocks joined_;
  Curve curve_ = Curve::morton();
  std::vector<std::uint64_t> cuts_;
};

}  // namespace mpm
