#pragma once
/// Parts and nodes of the blocks at the borders, as messages between neighbours; block_exchange.hpp says when they are sent.

#include <cstdint>

#include "libmpm/core/grid.hpp"
#include "libmpm/parallel/balancing.hpp"
#include "libmpm/parallel/halo_plan.hpp"
#include "libmpm/parallel/transport.hpp"

namespace mpm {

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
