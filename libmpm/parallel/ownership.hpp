#pragma once
/// Which rank owns which block, and when blocks move to other ranks.

#include "libmpm/core/grid.hpp"
#include "libmpm/parallel/partition.hpp"
#include "libmpm/parallel/transport.hpp"

namespace mpm {

/// When blocks move to other ranks.
struct Balancing {
  double threshold = 1.2;  ///< new cuts are tried if largest load / mean load exceeds this
  double gain = 0.05;      ///< new cuts are taken if they lower the largest load by this fraction
  int interval = 50;       ///< fewest steps between two trials
  int forced = 0;          ///< for tests: if above 0, new and uneven cuts every so many steps
};

/// How evenly the particles are distributed over the ranks.
struct Evenness {
  std::size_t particles = 0;  ///< of all ranks
  double largest = 0.0;       ///< particles of the rank that has most
};

/// One rank's view of the owners of all blocks; all ranks agree.
class Ownership {
 public:
  /// Rank 0 owns all blocks until the first renew(). @param transport  must outlive this object
  Ownership(Transport& transport, const Balancing& balancing)
      : transport_(transport), balancing_(balancing), partition_(transport.size()) {}

  [[nodiscard]] const Partition& partition() const { return partition_; }                                      ///< as it is now
  [[nodiscard]] int owner(const Index3& block) const { return partition_.owner(block); }                       ///< rank
  [[nodiscard]] bool owns(const Index3& block) const { return partition_.owner(block) == transport_.rank(); }  ///< whether this rank does
  /// Whether another rank owns a block or one of its neighbours.
  [[nodiscard]] bool at_border(const Index3& block) const;

  /// Before there are particles, on all ranks: makes the cuts. @param heads  of all blocks that there will be, on rank 0
  void cut(const JoinedBlocks& joined, std::span<const BlockHead> heads);
  /// Before a step, on all ranks: moves blocks to other ranks if blocks were newly joined or the load is uneven.
  /// @param now  empty before the first step, which then makes the first cuts. @returns whether blocks may have moved
  bool renew(Grid& grid, const JoinedBlocks& joined, const std::optional<Evenness>& now);

 private:
  [[nodiscard]] bool uneven(const std::optional<Evenness>& now) const;
  [[nodiscard]] std::vector<Load> loads(const Grid& grid, const Partition& partition);
  [[nodiscard]] std::vector<std::uint64_t> better_cuts(const Grid& grid, const Partition& wanted);
  void move_blocks(Grid& grid, const Partition& to);

  Transport& transport_;
  Balancing balancing_;
  Partition partition_;
  std::uint64_t steps_ = 0, tried_at_ = 0;
};

}  // namespace mpm
