#pragma once
/// Which rank owns which block: intervals of a curve through the blocks (Partition), when blocks move to other ranks (Ownership), and
/// blocks as messages, as they are stored, so that nothing is rounded on the way.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "libmpm/core/grid.hpp"
#include "libmpm/parallel/balancing.hpp"
#include "libmpm/parallel/joined_blocks.hpp"
#include "libmpm/parallel/transport.hpp"

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

/// Copies blocks of the other ranks with their particles into a grid of the first; all ranks call it. @param into  not divided among ranks
/// @param wanted  which blocks; called on the rank that owns the block
void collect_blocks(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into);

/// One rank's view of the owners of all blocks; all ranks agree.
class Ownership {
 public:
  /// Rank 0 owns all blocks until the first renew(). @param transport  must outlive this object
  Ownership(Transport& transport, const Balancing& balancing)
      : transport_(transport), balancing_(balancing), trials_(balancing, transport.size()), partition_(transport.size()) {}

  [[nodiscard]] int owner(const Index3& block) const { return partition_.owner(block); }                       ///< rank
  [[nodiscard]] bool owns(const Index3& block) const { return partition_.owner(block) == transport_.rank(); }  ///< whether this rank does
  /// Whether the time that particles take is measured in this step: in every eighth, which costs less than 0.1 % of a step.
  [[nodiscard]] bool measures() const { return steps_ % 8 == 1; }
  /// Whether another rank owns a block or one of its neighbours.
  [[nodiscard]] bool at_border(const Index3& block) const;

  /// Before there are particles, on all ranks: chooses the curve and makes the cuts. @param heads  of all blocks that there will be, on
  /// rank 0
  void cut(const JoinedBlocks& joined, std::span<const BlockHead> heads);
  /// Before a step, on all ranks: moves blocks to other ranks if blocks were newly joined or the load is uneven.
  /// @param costs  of the occupied blocks, s. @param now  empty before the first step, which then makes the first cuts
  /// @returns whether blocks may have moved
  bool renew(Grid& grid, const JoinedBlocks& joined, const BlockCosts& costs, const std::optional<Evenness>& now);

 private:
  void share(Partition& partition) const;
  [[nodiscard]] std::vector<Load> loads(const Grid& grid, const BlockCosts& costs);
  void improve_cuts(const Grid& grid, const BlockCosts& costs, Partition& partition);
  void move_blocks(Grid& grid, const Partition& to);

  Transport& transport_;
  Balancing balancing_;
  BalancingTrials trials_;
  Partition partition_;
  std::uint64_t steps_ = 0;
};

}  // namespace mpm
