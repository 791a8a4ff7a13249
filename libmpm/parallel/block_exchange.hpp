#pragma once
/// The ranks of a run: everything that they exchange in a step.
///
/// In a step each rank sends to each of its neighbours, which are few, one message of each kind:
///
///   parts     after particle_to_grid: what its particles give to nodes of the other's blocks, block by block, unsummed
///   nodes     after the grid update: the values of own nodes that the other's particles touch
///   migrants  after the particles have moved
///
/// and all ranks agree on three small things: the largest speed (and faults), whether blocks at a border came or went, the largest load.
/// Where blocks came or went the ranks tell each other which of their blocks hold particles at the common border; all layouts of messages
/// (halo_plan.hpp) follow from that, on both sides.

#include <vector>

#include "libmpm/parallel/halo_plan.hpp"
#include "libmpm/parallel/ownership.hpp"

namespace mpm {

/// Ranks by messages. Create one on every rank, for one grid each: Grid::divide.
class BlockExchange : public Ranks {
 public:
  /// Everything belongs to rank 0 until the first step. @param transport  outlives this
  explicit BlockExchange(Transport& transport, const Balancing& balancing = {}) : transport_(transport), ownership_(transport, balancing) {}

  [[nodiscard]] int size() const override { return transport_.size(); }
  [[nodiscard]] bool first() const override { return transport_.rank() == 0; }
  [[nodiscard]] bool owns(const Index3& block) const override { return ownership_.owns(block); }
  [[nodiscard]] bool at_border(const Index3& block) const override { return ownership_.at_border(block); }
  void tell(Task task, const State& state, double dt) override;
  Told next(State& state) override;
  void done() override { busy_ = false; }
  [[nodiscard]] bool busy() const override { return busy_; }
  void prepare(Grid& grid, const JoinedBlocks& joined) override;
  std::vector<std::int32_t> announce(Grid& grid) override;
  void plan(Grid& grid) override;
  void add_parts(Grid& grid) override;
  void add_parts(std::span<NodeBlock> field) override;
  void return_nodes(Grid& grid) override;
  void exchange_migrants(Grid& grid) override;
  double agree(double largest, const std::optional<BlockFault>& fault) override;
  void sum(std::span<std::uint64_t> numbers) override;
  std::vector<Message> gather(Message mine) override;
  void share(Message& message) override { transport_.broadcast(message); }
  [[nodiscard]] std::size_t particle_count(std::size_t own) const override { return now_ ? now_->particles : own; }
  void collect(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into) override;
  std::vector<RankCounts> counts(std::size_t particles) override;

  [[nodiscard]] const RankCounts& own_counts() const { return counts_; }  ///< of this rank, but its particles

 private:
  [[nodiscard]] Borders borders_of(const Grid& grid) const;
  void exchange_borders();
  [[nodiscard]] std::vector<std::int32_t> blocks_that_must_be(Grid& grid) const;
  /// @param nodes_of  the nodes of a block, given its number and that of the field
  template <class NodesOf>
  void add_parts_of(int fields, const NodesOf& nodes_of);
  void send(Messages out, std::uint64_t& bytes);
  void reduce(std::size_t bytes);
  void begin(Task task);

  Transport& transport_;
  Ownership ownership_;
  HaloPlan plan_;
  Borders mine_, theirs_;
  std::vector<Index3> occupied_;      ///< own blocks with particles, at the last announce()
  std::vector<std::int32_t> needed_;  ///< what it returned
  std::optional<Evenness> now_;       ///< as of then
  bool busy_ = false;
  bool counting_ = true;    ///< what is exchanged now is not for a file
  bool fresh_ = true;       ///< owners have changed since
  bool unchanged_ = false;  ///< it found everything as it was before
  std::size_t own_particles_ = 0, border_blocks_ = 0;
  RankCounts counts_;
};

}  // namespace mpm
