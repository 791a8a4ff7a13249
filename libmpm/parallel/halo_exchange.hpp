#pragma once
/// Parts and nodes of the blocks at the borders, as messages between neighbours; block_exchange.hpp says when they are sent. Sender and
/// receiver derive the nodes and their places in the messages (HaloPlan) from the blocks with particles at their common border.

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "libmpm/core/grid.hpp"
#include "libmpm/parallel/balancing.hpp"
#include "libmpm/parallel/ownership.hpp"
#include "libmpm/parallel/transport.hpp"

namespace mpm {

/// Blocks with particles at a border, by the rank on the other side.
using Borders = std::map<int, std::vector<Index3>>;

/// Nodes 0 .. extent - 1 along each axis of a block.
using Extent = std::array<int, 3>;
/// Number of these nodes.
constexpr std::size_t nodes_in(const Extent& extent) { return static_cast<std::size_t>(extent[0] * extent[1] * extent[2]); }

/// Nodes of one block in a message.
struct SentNodes {
  std::int32_t nodes;  ///< index in the grid, of a block or of a buffer
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
  std::int32_t nodes;             ///< own part: index of the buffer
  std::size_t first;              ///< received part: nodes before it in the message
};

/// An own block whose nodes get parts from other ranks, or from outer blocks of this rank: their order in time is not that of the colours.
struct SharedBlock {
  std::int32_t block;             ///< index in the grid
  std::vector<Summand> summands;  ///< in the order of the colours
};

/// Nodes in messages with parts and with nodes, and where they go.
struct HaloLayout {
  NodesByRank parts_to;                   ///< parts that own blocks contribute to blocks of other ranks
  std::map<int, std::size_t> parts_from;  ///< number of nodes in the message with parts
  std::vector<SharedBlock> shared;        ///< own blocks that get parts; first those with no part from other ranks
  std::size_t complete = 0;               ///< number of the latter
  NodesByRank nodes_to, nodes_from;       ///< values that go back to the ranks whose particles need them
};

/// The layouts of the messages of a step.
class HaloPlan {
 public:
  /// Recomputes the plan for the current blocks. @param theirs  blocks of other ranks at their borders with this one
  void renew(Grid& grid, const Ownership& ownership, const Borders& theirs);

  /// With parts that some blocks give, and nodes that these need. @param givers  these blocks, the same choice in all steps; empty: all
  [[nodiscard]] const HaloLayout& of(const BlockChoice& givers);

 private:
  /// One block's particles touch nodes of another block.
  struct Touch {
    Index3 giver;         ///< block with the particles
    int k;                ///< the other one's place in forward_directions
    std::int32_t to;      ///< its index in the grid
    int rank;             ///< the other rank; Summand::own if both blocks are of this one
    std::int32_t buffer;  ///< for the parts; no_block if the giver is another rank's
  };
  void find_touches(Grid& grid, const Ownership& ownership, const Borders& theirs);
  [[nodiscard]] HaloLayout layout_of(const BlockChoice& givers) const;

  std::vector<Touch> out_, in_, own_;  ///< own blocks touch other ranks' blocks; the reverse; own blocks touch shared ones
  std::map<std::int32_t, std::array<std::int32_t, 27>> targets_;  ///< Block::buffers points into it
  HaloLayout all_;
  std::optional<HaloLayout> some_;
};

/// What one rank has computed and exchanged since the start, without the exchange for files.
struct RankCounts {
  std::uint64_t particles = 0;        ///< of this rank now
  std::uint64_t steps = 0;            ///< steps taken
  std::uint64_t particle_steps = 0;   ///< particles of this rank, summed over the steps
  std::uint64_t block_steps = 0;      ///< its blocks with particles, summed over the steps
  std::uint64_t border_steps = 0;     ///< those of them next to a block of another rank, summed
  std::uint64_t neighbour_steps = 0;  ///< other ranks that it shares a border with, summed
  std::uint64_t messages = 0;         ///< sent to neighbours: parts, nodes, migrants
  std::uint64_t part_bytes = 0;       ///< sent with parts
  std::uint64_t node_bytes = 0;       ///< sent with nodes
  std::uint64_t migrant_bytes = 0;    ///< sent with migrants
  std::uint64_t exchanges = 0;        ///< times that the ranks exchanged lists of their border blocks
  std::uint64_t reductions = 0;       ///< sums and maxima over all ranks
  std::uint64_t reduced_bytes = 0;    ///< contributed to them
  std::uint64_t gathers = 0;          ///< collections of rows of all ranks on the first
  std::uint64_t gathered_bytes = 0;   ///< contributed to them
  std::uint64_t moves = 0;            ///< times that blocks changed their owners
  double part_wait = 0.0;             ///< s, waited for parts
  double node_wait = 0.0;             ///< s, waited for nodes
  double migrant_wait = 0.0;          ///< s, waited for migrants
  double reduction_wait = 0.0;        ///< s, in sums and maxima over all ranks: where a rank with less work waits for the others
};

/// Sends parts and nodes, and adds or stores what arrives. Both kinds may be on their way at the same time.
class HaloExchange {
 public:
  /// All of them must outlive this object. @param counts  gets messages, their bytes, and the time waited
  HaloExchange(Transport& transport, StepClock& clock, RankCounts& counts) : transport_(transport), clock_(clock), counts_(counts) {}

  /// Sends contributions to nodes of other ranks. @param layout  must stay until add_parts()
  void send_parts(const NodeFields& fields, const HaloLayout& layout);
  /// Waits for the contributions of other ranks, and sums the nodes that have several.
  void add_parts(const NodeFields& fields);
  /// Sends own nodes that particles of other ranks need. @param layout  must stay until receive_nodes()
  void send_nodes(const NodeFields& fields, const HaloLayout& layout);
  /// Waits for the nodes of other ranks.
  void receive_nodes(const NodeFields& fields);
  /// Counts messages. @param bytes  is increased by theirs
  void count(const Messages& out, std::uint64_t& bytes);

 private:
  Transport& transport_;
  StepClock& clock_;
  RankCounts& counts_;
  const HaloLayout *parts_ = nullptr, *nodes_ = nullptr;  ///< of the messages on their way
};

}  // namespace mpm
