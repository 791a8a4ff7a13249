#pragma once
/// Which rank owns which block, and when blocks move to other ranks.

#include "libmpm/core/grid.hpp"
#include "libmpm/parallel/balancing.hpp"
#include "libmpm/parallel/partition.hpp"
#include "libmpm/parallel/transport.hpp"

namespace mpm {

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
