#pragma once
/// Which rank owns which block: intervals of a Morton curve through the blocks.

#include <cstdint>
#include <span>
#include <vector>

#include "libmpm/core/joined_blocks.hpp"

namespace mpm {

/// Place of a block on the Morton curve: the bits of its coordinates, interleaved. Near on the curve is near in space.
[[nodiscard]] std::uint64_t morton_key(const Index3& block);

/// What one block, or several that are joined, cost.
struct Load {
  std::uint64_t key = 0;  ///< morton_key of the representative
  double cost = 0.0;      ///< above 0, in any unit
};

/// Owners of all blocks that there may ever be: an owner follows from a coordinate, so that no rank needs a list of blocks.
class Partition {
 public:
  /// Everything belongs to rank 0.
  explicit Partition(int ranks);
  bool operator==(const Partition&) const = default;

  [[nodiscard]] int owner(const Index3& block) const;                          ///< rank
  [[nodiscard]] std::uint64_t key(const Index3& block) const;                  ///< of its representative
  [[nodiscard]] const JoinedBlocks& joined() const { return joined_; }         ///< what has one owner
  void join(const JoinedBlocks& joined) { joined_ = joined; }                  ///< from now on
  [[nodiscard]] std::span<const std::uint64_t> cuts() const { return cuts_; }  ///< rank r owns keys from cuts[r - 1] to below cuts[r]
  void set_cuts(std::vector<std::uint64_t> cuts) { cuts_ = std::move(cuts); }  ///< one less than ranks, rising

  /// Cuts the curve so that every rank gets its share of the cost, to within half a block.
  /// @param loads  in any order; equal keys are one piece. @param shares  of each rank; any sum above 0
  [[nodiscard]] static std::vector<std::uint64_t> cut(std::vector<Load> loads, std::span<const double> shares);
  /// The largest cost of a rank.
  [[nodiscard]] static double largest_cost(std::span<const Load> loads, std::span<const std::uint64_t> cuts);

 private:
  JoinedBlocks joined_;
  std::vector<std::uint64_t> cuts_;
};

}  // namespace mpm
