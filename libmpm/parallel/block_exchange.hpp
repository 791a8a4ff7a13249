#pragma once
/// The ranks of a run: who owns which block, and everything that they exchange in a step.
///
/// In a step each rank sends to each of its neighbours, which are few, one message of each kind:
///
///   parts     after particle_to_grid: what its particles give to nodes of the other's blocks, block by block, unsummed
///   nodes     after the grid update: the values of own nodes that the other's particles touch
///   migrants  after the particles have moved
///
/// and all ranks agree on three small things: the largest speed (and faults), whether blocks at a border came or went, the largest load.
/// Where blocks came or went the ranks tell each other which of their blocks hold particles at the common border; all layouts of messages
/// follow from that, on both sides.

#include <deque>
#include <map>
#include <vector>

#include "libmpm/core/grid.hpp"
#include "libmpm/parallel/partition.hpp"
#include "libmpm/parallel/transport.hpp"

namespace mpm {

/// When blocks move to other ranks.
struct Balancing {
  double threshold = 1.2;  ///< largest load over the mean load from which on new cuts are tried
  double gain = 0.05;      ///< share by which new cuts must lower the largest load to be taken
  int interval = 50;       ///< steps from one try to the next, at least
  int forced = 0;          ///< above 0, for tests: new and uneven cuts every so many steps
};

/// What a rank has exchanged since the start.
struct Traffic {
  std::uint64_t steps = 0;          ///< steps taken
  std::uint64_t particles = 0;      ///< of this rank, summed over the steps
  std::uint64_t neighbours = 0;     ///< ranks that it sent parts to, summed over the steps
  std::uint64_t part_bytes = 0;     ///< sent with parts
  std::uint64_t node_bytes = 0;     ///< sent with nodes
  std::uint64_t migrant_bytes = 0;  ///< sent with migrants
  std::uint64_t sum_bytes = 0;      ///< sent to the first rank as parts of sums
  std::uint64_t moves = 0;          ///< times that blocks changed their owners
};

/// Ranks by messages. Create one on every rank, for one grid each: Grid::divide.
class BlockExchange : public Ranks {
 public:
  /// Everything belongs to rank 0 until the first step. @param transport  outlives this
  explicit BlockExchange(Transport& transport, const Balancing& balancing = {});

  [[nodiscard]] int size() const override { return transport_.size(); }
  [[nodiscard]] bool first() const override { return transport_.rank() == 0; }
  [[nodiscard]] bool owns(const Index3& block) const override { return partition_.owner(block) == transport_.rank(); }
  [[nodiscard]] bool at_border(const Index3& block) const override;
  void tell(Task task, const State& state, double dt) override;
  Told next(State& state) override;
  void done() override { busy_ = false; }
  [[nodiscard]] bool busy() const override { return busy_; }
  void prepare(Grid& grid, const JoinedBlocks& joined) override;
  std::vector<std::int32_t> announce(Grid& grid) override;
  void plan(Grid& grid) override;
  void add_parts(Grid& grid) override;
  void return_nodes(Grid& grid) override;
  void exchange_migrants(Grid& grid) override;
  double agree(double largest, const std::optional<BlockFault>& fault) override;
  std::vector<std::vector<std::byte>> gather(std::vector<std::byte> bytes) override;
  [[nodiscard]] std::size_t particle_count(std::size_t own) const override { return announced_ ? particles_ : own; }
  void collect(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into) override;

  std::string report(std::size_t particles) override;

  [[nodiscard]] const Partition& partition() const { return partition_; }  ///< as it is now
  [[nodiscard]] const Traffic& traffic() const { return traffic_; }        ///< of this rank

 private:
  /// Blocks with particles at a border, by the rank on the other side.
  using Borders = std::map<int, std::vector<Index3>>;
  /// Nodes 0 .. extent - 1 along each axis of a block.
  using Extent = std::array<int, 3>;
  /// What one of the own blocks gives to a block of another rank.
  struct OutPart {
    std::int32_t nodes;  ///< lent
    Extent extent;
  };
  /// One summand of the nodes of a shared block.
  struct Summand {
    int colour;          ///< of the block that gives it: its turn
    Extent extent;       ///< the nodes
    int from;            ///< rank; -1: own, in lent nodes
    std::int32_t nodes;  ///< lent
    std::size_t first;   ///< nodes of the sender's message before it
  };
  struct Shared {
    std::int32_t block;
    std::vector<Summand> summands;  ///< in the order of the colours
  };
  /// Nodes of a block that go back to the rank whose particles need them.
  struct Returned {
    std::int32_t block;
    Extent extent;
  };

  [[nodiscard]] Borders borders_of(const Grid& grid) const;
  void plan_own_parts(Grid& grid);
  void plan_shared(Grid& grid);
  [[nodiscard]] std::vector<Load> loads(const Grid& grid, const Partition& partition);
  [[nodiscard]] bool uneven();
  void move_blocks(Grid& grid, const Partition& to);

  Transport& transport_;
  Balancing balancing_;
  Partition partition_;
  Borders mine_, theirs_;
  std::vector<Index3> occupied_;      ///< own blocks with particles, at the last announce()
  std::vector<std::int32_t> needed_;  ///< what it returned
  bool announced_ = false, busy_ = false;
  bool fresh_ = true;       ///< owners have changed since
  bool unchanged_ = false;  ///< it found everything as it was before
  std::size_t particles_ = 0, own_particles_ = 0;
  double largest_load_ = 0.0;
  std::uint64_t steps_ = 0, tried_at_ = 0;
  std::map<std::int32_t, std::array<std::int32_t, 27>> targets_;  ///< Block::parts points into it
  std::map<int, std::vector<OutPart>> parts_to_;
  std::map<int, std::size_t> parts_from_;  ///< nodes of the message
  std::vector<Shared> shared_;
  std::map<int, std::vector<Returned>> nodes_to_, nodes_from_;
  Traffic traffic_;
};

}  // namespace mpm
