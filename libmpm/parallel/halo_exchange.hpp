#pragma once
/// Parts and nodes of the blocks at the borders, as messages between neighbours; block_exchange.hpp says when they are sent.

#include <cstdint>
#include <functional>
#include <span>

#include "libmpm/core/grid.hpp"
#include "libmpm/parallel/halo_plan.hpp"
#include "libmpm/parallel/step_clock.hpp"
#include "libmpm/parallel/transport.hpp"

namespace mpm {

/// One or more fields on the nodes of the grid that are exchanged together.
class NodeFields {
 public:
  /// All fields of the grid. @param grid  must outlive this object
  explicit NodeFields(Grid& grid);
  /// One field. @param field  by number of block
  explicit NodeFields(std::span<NodeBlock> field);

  [[nodiscard]] int count() const { return count_; }                                      ///< number of fields
  NodeBlock& of(std::int32_t block, int field) const { return nodes_of_(block, field); }  ///< the nodes of a block
  [[nodiscard]] std::size_t bytes(std::size_t nodes) const;                               ///< of so many nodes in all fields

 private:
  int count_;
  std::function<NodeBlock&(std::int32_t block, int field)> nodes_of_;
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
