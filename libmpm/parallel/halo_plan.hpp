#pragma once
/// Which nodes a rank sends to which other rank in a step, and their places in the messages. Sender and receiver derive both from the
/// blocks with particles at their common border.

#include <map>
#include <vector>

#include "libmpm/core/grid.hpp"
#include "libmpm/parallel/ownership.hpp"

namespace mpm {

/// Blocks with particles at a border, by the rank on the other side.
using Borders = std::map<int, std::vector<Index3>>;

/// Nodes 0 .. extent - 1 along each axis of a block.
using Extent = std::array<int, 3>;
/// Number of these nodes.
constexpr std::size_t nodes_in(const Extent& extent) { return static_cast<std::size_t>(extent[0] * extent[1] * extent[2]); }

/// Nodes of one block in a message.
struct SentNodes {
  std::int32_t nodes;  ///< index in the grid, of a block or of a temporary one
  Extent extent;       ///< which of them
};
/// By receiving or sending rank, in the order of the message.
using NodesByRank = std::map<int, std::vector<SentNodes>>;

/// One summand of the nodes of a shared block.
struct Summand {
  static constexpr int own = -1;  ///< `from` of a part of this rank
  int colour;                     ///< of the contributing block; determines the order
  Extent extent;                  ///< the nodes
  int from;                       ///< rank, or own
  std::int32_t nodes;             ///< own part: index of the temporary block
  std::size_t first;              ///< received part: nodes before it in the message
};

/// An own block whose nodes get parts from other ranks.
struct SharedBlock {
  std::int32_t block;             ///< index in the grid
  std::vector<Summand> summands;  ///< in the order of the colours
};

/// The layout of the messages of a step.
class HaloPlan {
 public:
  /// Recomputes the plan for the current blocks. @param theirs  blocks of other ranks at their borders with this one
  void renew(Grid& grid, const Ownership& ownership, const Borders& theirs);

  NodesByRank parts_to;                   ///< parts that own blocks contribute to blocks of other ranks
  std::map<int, std::size_t> parts_from;  ///< number of nodes in the message with parts
  std::vector<SharedBlock> shared;        ///< own blocks that get parts
  NodesByRank nodes_to, nodes_from;       ///< values that go back to the ranks whose particles need them

 private:
  void plan_own_parts(Grid& grid, const Ownership& ownership);
  void plan_shared(Grid& grid, const Ownership& ownership, const Borders& theirs);

  std::map<std::int32_t, std::array<std::int32_t, 27>> targets_;  ///< Block::parts points into it
};

}  // namespace mpm
