#pragma once
/// Ranks: the processes that compute parts of one state.
///
/// Every block of the grid has an owner, which follows from its coordinate alone. A rank holds the particles and the nodes of its own
/// blocks, and ghosts: blocks of other ranks next to its own. The results equal those of one rank to the last bit, because:
///
/// - Contributions of particles to nodes of another rank's block (parts) are sent unsummed; the owner adds them in the order of the colours
///   (add_parts). The owner then sends back the nodes that particles of other ranks need (send_nodes).
/// - Blocks have one owner if a boundary acts on nodes of several of them together (joined_blocks.hpp).
/// - A migrant to another rank's block arrives there in the outbox of a ghost; its new block collects it in the usual order.
/// - Sums over blocks are exact (block_sums.hpp), or rank 0 adds the rows of all blocks in their order (boundary_impulses.hpp).
///
/// Messages travel while a rank computes. A block is `outer` if its particles touch nodes of other ranks' blocks. Particles of outer blocks
/// come first in particle_to_grid, so that their parts travel while the others are transferred; they come last in grid_to_particle, so that
/// the nodes from other ranks have time to arrive.
///
/// The core uses three interfaces: RankGroup, RankTasks and StepExchange. libmpm/parallel implements them with messages; OneRank is the
/// only rank of a program of one process.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/base/message.hpp"
#include "libmpm/base/types.hpp"

namespace mpm {

class Grid;
class NodeFields;
struct Block;
struct Scene;
struct State;

/// Sums and collections over all ranks. size(), rank() and first() answer at once; all ranks call the others together, in the same order,
/// outside of parallel regions.
class RankGroup {
 public:
  virtual ~RankGroup() = default;
  [[nodiscard]] virtual int size() const = 0;  ///< number of ranks
  [[nodiscard]] virtual int rank() const = 0;  ///< number of this one, from 0
  /// Whether this is the rank that decides and measures; only there are sums over blocks complete.
  [[nodiscard]] bool first() const { return rank() == 0; }

  /// Replaces each number by its sum over all ranks.
  virtual void sum(std::span<std::uint64_t> numbers) = 0;
  /// Collects one message of each rank on the first. @returns there: by rank; elsewhere: nothing
  virtual std::vector<Message> gather(Message mine) = 0;
  /// Sends the message of the first rank to all.
  virtual void share(Message& message) = 0;
  /// Sends messages, by the rank that they go to. @returns those for this rank, by the rank that they come from
  virtual std::map<int, Message> exchange(std::map<int, Message> to) = 0;
};

/// Number of a function that all ranks execute together. A program has functions besides those of the core (parallel/block_exchange.hpp).
using TaskNumber = std::uint32_t;
/// Those of the core.
struct CoreTask {
  /// Their numbers.
  enum Number : TaskNumber {
    step,     ///< step()
    totals,   ///< totals()
    fastest,  ///< fastest_particle()
    count,    ///< numbers of other tasks begin here
  };
};

/// Calls a function on all ranks: the first rank decides, the others wait for its next instruction. A function that has a task number
/// begins with instruct() and ends with done().
class RankTasks {
 public:
  virtual ~RankTasks() = default;
  /// On the first rank: sends the task to the others, with the scalars of its state. On the others, which have it already: nothing.
  virtual void instruct(TaskNumber task, const State& state, double dt = 0.0) = 0;
  /// Ends a task. If a rank throws before it calls this, the others wait for it; the caller must then end them.
  virtual void done() = 0;
};

/// Chooses blocks by their coordinates.
using BlockChoice = std::function<bool(const Index3&)>;

/// Why the step failed in one block.
struct BlockError {
  Index3 block;      ///< where
  std::string text;  ///< the message
};

/// What ranks exchange in a step, in the order of the step. All ranks call the functions together, outside of parallel regions, except for
/// owns(), at_border(), progress(), measures(), note_time() and particle_count(), which do not wait for other ranks.
class StepExchange {
 public:
  virtual ~StepExchange() = default;
  /// Whether this rank owns a block.
  [[nodiscard]] virtual bool owns(const Index3& block) const = 0;
  /// Whether another rank owns a block or one of its 26 neighbours.
  [[nodiscard]] virtual bool at_border(const Index3& block) const = 0;

  /// Starts the step on all ranks (CoreTask::step), and moves blocks to other ranks if blocks were newly joined or the load is uneven.
  virtual void begin_step(State& state, const Scene& scene, double dt) = 0;
  /// After particle_to_grid of the outer blocks: starts to send their parts. add_parts() follows.
  /// @param givers  of these blocks only, the same choice on all ranks and in all steps; empty: of all
  virtual void send_parts(const NodeFields& fields, const BlockChoice& givers = {}) = 0;
  /// After particle_to_grid of all blocks: waits for the parts of other ranks, and sums the nodes that get contributions from outer blocks.
  virtual void add_parts(const NodeFields& fields) = 0;
  /// After the update: starts to send nodes to the ranks whose particles need them. receive_nodes() follows.
  /// @param givers  as in send_parts(): nodes that their particles need
  virtual void send_nodes(const NodeFields& fields, const BlockChoice& givers = {}) = 0;
  /// Before grid_to_particle of the outer blocks: waits for the nodes from other ranks.
  virtual void receive_nodes(const NodeFields& fields) = 0;
  /// When particles have moved. @returns the largest of all ranks' values.
  /// @throws UnstableError, on all, if a rank has an error: that of the first block in their order
  virtual double largest_or_throw(double own, const std::optional<BlockError>& error) = 0;
  /// Moves migrants to blocks of other ranks from this rank's outboxes into those of the ghosts there.
  virtual void exchange_migrants(Grid& grid) = 0;
  /// Exchanges the lists of blocks with particles at the borders, and creates ghosts for those of other ranks.
  /// @returns the blocks that must exist in the step
  virtual std::vector<std::int32_t> announce(Grid& grid) = 0;
  /// Prepares the messages for the current blocks, and marks the outer ones (Block::outer).
  virtual void plan(Grid& grid) = 0;
  /// Number of particles of all ranks, as of the last announce(). @param own  of this rank: the result before the first announce()
  [[nodiscard]] virtual std::size_t particle_count(std::size_t own) const = 0;

  /// Helps messages on their way. In a parallel region only the thread that calls the other functions may call it.
  virtual void progress() noexcept = 0;
  /// Whether note_time() is wanted in this step.
  [[nodiscard]] virtual bool measures() const = 0;
  /// The computing time that the particles of a block took in grid_to_particle and the stress update, s: blocks are distributed by it. May
  /// be called inside a parallel region by any thread, once for each block.
  virtual void note_time(const Block& block, std::int32_t index, int particles, double time) noexcept = 0;
};

/// One rank's view of the others.
class Ranks : public RankGroup, public RankTasks, public StepExchange {};

/// The only rank: it owns everything, and nobody waits for it.
class OneRank : public Ranks {
 public:
  [[nodiscard]] int size() const override { return 1; }
  [[nodiscard]] int rank() const override { return 0; }
  void sum(std::span<std::uint64_t> /*numbers*/) override {}
  std::vector<Message> gather(Message mine) override { return {std::move(mine)}; }
  void share(Message& /*message*/) override {}
  std::map<int, Message> exchange(std::map<int, Message> to) override { return to; }
  void instruct(TaskNumber /*task*/, const State& /*state*/, double /*dt*/) override {}
  void done() override {}
  [[nodiscard]] bool owns(const Index3& /*block*/) const override { return true; }
  [[nodiscard]] bool at_border(const Index3& /*block*/) const override { return false; }
  void begin_step(State& /*state*/, const Scene& /*scene*/, double /*dt*/) override {}
  void send_parts(const NodeFields& /*fields*/, const BlockChoice& /*givers*/) override {}
  void add_parts(const NodeFields& /*fields*/) override {}
  void send_nodes(const NodeFields& /*fields*/, const BlockChoice& /*givers*/) override {}
  void receive_nodes(const NodeFields& /*fields*/) override {}
  double largest_or_throw(double own, const std::optional<BlockError>& error) override {
    if (error) throw UnstableError(error->text);
    return own;
  }
  void exchange_migrants(Grid& /*grid*/) override {}
  std::vector<std::int32_t> announce(Grid& /*grid*/) override { return {}; }
  void plan(Grid& /*grid*/) override {}
  [[nodiscard]] std::size_t particle_count(std::size_t own) const override { return own; }
  void progress() noexcept override {}
  [[nodiscard]] bool measures() const override { return false; }
  void note_time(const Block& /*block*/, std::int32_t /*index*/, int /*particles*/, double /*time*/) noexcept override {}
};
/// It has no state: one object serves all grids.
inline Ranks& one_rank() {
  static OneRank rank;
  return rank;
}

}  // namespace mpm
