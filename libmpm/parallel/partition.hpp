#pragma once
/// Which rank owns which block: intervals of a Morton curve through the blocks.

#include <cstdint>
#include <span>
#include <vector>

#include "libmpm/core/joined_blocks.hpp"

namespace mpm {

/// Position of a block on the Morton curve: the bits of its coordinates, interleaved. Neighbours on the curve are close in space.
[[nodiscard]] std::uint64_t morton_key(const Index3& block);

/// Cost of a block, or of several joined ones.
struct Load {
  std::uint64_t key = 0;  ///< morton_key of the representative
  double cost = 0.0;      ///< positive, in any unit
};

/// The owner of every possible block. It follows from the block's coordinate, so no rank needs a list of blocks.
class Partition {
 public:
  /// Rank 0 owns all blocks.
  explicit Partition(int ranks);
  bool operator==(const Partition&) const = default;

  [[nodiscard]] int owner(const Index3& block) const;                          ///< rank
  [[nodiscard]] std::uint64_t key(const Index3& block) const;                  ///< of its representative
  [[nodiscard]] const JoinedBlocks& joined() const { return joined_; }         ///< blocks that have one owner together
  void join(const JoinedBlocks& joined) { joined_ = joined; }                  ///< from now on
  [[nodiscard]] std::span<const std::uint64_t> cuts() const { return cuts_; }  ///< rank r owns keys from cuts[r - 1] to below cuts[r]
  void set_cuts(std::vector<std::uint64_t> cuts) { cuts_ = std::move(cuts); }  ///< ascending, one fewer than ranks

  /// Cuts the curve so that every rank gets its part of the cost, to within half a block.
  /// @param loads  in any order; loads with equal keys stay together. @param weights  relative cost for each rank; positive sum
  [[nodiscard]] static std::vector<std::uint64_t> cut(std::vector<Load> loads, std::span<const double> weights);
  /// The largest cost of a rank.
  [[nodiscard]] static double largest_cost(std::span<const Load> loads, std::span<const std::uint64_t> cuts);

 private:
  JoinedBlocks joined_;
  std::vector<std::uint64_t> cuts_;
};

}  // namespace mpm
