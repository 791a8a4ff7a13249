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
/// - Sums over blocks are exact (block_sums.hpp), or rank 0 adds the rows of all blocks in the order of the blocks (block_table.hpp).
///
/// Messages travel while a rank computes. A block is `outer` if its particles touch nodes of other ranks' blocks. Particles of outer blocks
/// come first in particle_to_grid, so that their parts travel while the others are transferred; they come last in grid_to_particle, so that
/// the nodes from other ranks have time to arrive.
///
/// The core uses this interface; libmpm/parallel implements it. In a program of one process Grid::ranks() is null.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libmpm/base/message.hpp"
#include "libmpm/base/types.hpp"

namespace mpm {

class Grid;
class JoinedBlocks;
struct NodeBlock;
struct Block;
struct State;

/// What all ranks do together. The first rank decides; the others wait for its next instruction (driver/worker.hpp).
enum class Task : std::uint32_t {
  step,       ///< step()
  totals,     ///< totals()
  fastest,    ///< the fastest particle of all
  inside,     ///< particles that start inside a boundary
  observe,    ///< particles that an observer wants to see
  particles,  ///< all particles by their numbers, for a file
  blocks,     ///< all blocks in their order, for a file
  report,     ///< what was exchanged
  start,      ///< the particles of t = 0
  restore,    ///< the particles of a checkpoint
  end,        ///< nothing follows
};

/// A block and how many particles it holds.
struct BlockHead {
  Index3 block{};          ///< its coordinate
  std::int32_t count = 0;  ///< its particles
};

/// Why the step failed in one block.
struct BlockError {
  Index3 block;      ///< where
  std::string text;  ///< the message
};

/// What one rank has computed and exchanged since the start, without the exchange for files.
struct RankCounts {
  std::uint64_t particles = 0;        ///< of this rank now
  std::uint64_t steps = 0;            ///< steps taken
  std::uint64_t particle_steps = 0;   ///< particles of this rank, summed over the steps
  std::uint64_t block_steps = 0;      ///< likewise: its blocks with particles
  std::uint64_t border_steps = 0;     ///< likewise: those of them next to a block of another rank
  std::uint64_t neighbour_steps = 0;  ///< likewise: other ranks that it shares a border with
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

/// Chooses blocks by their coordinates.
using BlockChoice = std::function<bool(const Index3&)>;

/// One rank's view of the others. The functions that are not const are collective: all ranks call them, outside of parallel regions.
class Ranks {
 public:
  virtual ~Ranks() = default;

  [[nodiscard]] virtual int size() const = 0;  ///< number of ranks
  /// Whether this is the rank that decides and measures; only there are sums over blocks complete.
  [[nodiscard]] virtual bool first() const = 0;
  /// Whether this rank owns a block.
  [[nodiscard]] virtual bool owns(const Index3& block) const = 0;
  /// Whether another rank owns a block or one of its 26 neighbours.
  [[nodiscard]] virtual bool at_border(const Index3& block) const = 0;

  /// Starts a task on all ranks: the first sends it to the others, with the scalars of its state. The others, which have the task from
  /// next_instruction(), send nothing.
  virtual void instruct(Task task, const State& state, double dt = 0.0) = 0;
  /// What the first rank sends to start a task.
  struct Instruction {
    Task task = Task::end;  ///< what to do
    double dt = 0.0;        ///< time step, s; Task::step only
  };
  /// Waits for the first rank; called by the others. @param state  gets the scalars of the first rank's state
  virtual Instruction next_instruction(State& state) = 0;
  /// Ends a task. If a rank throws before it calls this, the others wait for it; the caller must then end them.
  virtual void done() = 0;
  /// Whether a task has started and not ended.
  [[nodiscard]] virtual bool busy() const = 0;

  /// Before a step: moves blocks to other ranks if blocks were newly joined or the load is uneven.
  virtual void prepare(Grid& grid, const JoinedBlocks& joined) = 0;
  /// Exchanges the lists of blocks with particles at the borders, and creates ghosts for those of other ranks.
  /// @returns the blocks that must exist in the step
  virtual std::vector<std::int32_t> announce(Grid& grid) = 0;
  /// Prepares the messages for the current blocks, and marks the outer ones (Block::outer).
  virtual void plan(Grid& grid) = 0;
  /// After particle_to_grid of the outer blocks: starts to send their parts. add_parts() follows.
  virtual void send_parts(Grid& grid) = 0;
  /// After particle_to_grid of all blocks: waits for the parts of other ranks, and sums the nodes that get contributions from outer blocks.
  virtual void add_parts(Grid& grid) = 0;
  /// After the update: starts to send nodes to the ranks whose particles need them. receive_nodes() follows.
  virtual void send_nodes(Grid& grid) = 0;
  /// Before grid_to_particle of the outer blocks: waits for the nodes from other ranks.
  virtual void receive_nodes(Grid& grid) = 0;
  /// send_nodes() for a part of the blocks; receive_nodes() follows.
  /// @param givers  the blocks whose particles need nodes; the same choice on all ranks and in all steps
  virtual void send_nodes(Grid& grid, const BlockChoice& givers) = 0;
  /// send_parts() for a part of the blocks and another field; add_parts(field) follows.
  /// @param field  by number of block, including buffers
  /// @param givers  the blocks whose particles give parts; the same choice on all ranks and in all steps
  virtual void send_parts(std::span<NodeBlock> field, const BlockChoice& givers) = 0;
  /// add_parts() for another field. @param field  by number of block, including buffers
  virtual void add_parts(std::span<NodeBlock> field) = 0;
  /// Helps messages on their way. In a parallel region only the thread that calls the other functions may call it.
  virtual void progress() noexcept = 0;
  /// Whether note_time() is wanted in this step.
  [[nodiscard]] virtual bool measures() const = 0;
  /// The computing time that the particles of a block took in grid_to_particle and the stress update, s: blocks are distributed by it. May
  /// be called inside a parallel region by any thread, once for each block.
  virtual void note_time(const Block& block, std::int32_t number, int particles, double time) noexcept = 0;
  /// Moves migrants to blocks of other ranks from this rank's outboxes into those of the ghosts there.
  virtual void exchange_migrants(Grid& grid) = 0;

  /// @returns the largest of all ranks' values. @throws UnstableError, on all, with the error of the first block in their order
  virtual double agree(double largest, const std::optional<BlockError>& error) = 0;
  /// Replaces each number by its sum over all ranks.
  virtual void sum(std::span<std::uint64_t> numbers) = 0;
  /// Collects one message of each rank on the first. @returns there: by rank; elsewhere: nothing
  virtual std::vector<Message> gather(Message mine) = 0;
  /// Sends the message of the first rank to all.
  virtual void share(Message& message) = 0;
  /// Number of particles of all ranks, as of the last announce(). @param own  of this rank, which holds all before the first of these
  [[nodiscard]] virtual std::size_t particle_count(std::size_t own) const = 0;

  /// Copies blocks of the others with their particles into a grid of the first rank. @param into  not divided among ranks
  /// @param wanted  which blocks; called on the rank that owns the block
  virtual void collect(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into) = 0;
  /// Counts of all ranks, on the first; elsewhere nothing. @param particles  of this rank
  virtual std::vector<RankCounts> counts(std::size_t particles) = 0;

  // What files and the start need.

  [[nodiscard]] virtual int rank() const = 0;  ///< number of this one, from 0
  /// Sends messages, by the rank that they go to. @returns those for this rank, by the rank that they come from
  virtual std::map<int, Message> exchange(std::map<int, Message> to) = 0;
  /// Whether a particle that is inserted into a block is for this rank: it owns the block. While blocks are counted it takes none.
  virtual bool takes(const Index3& block) = 0;
  /// From now on takes() counts the particles of each block. @see counted_blocks
  virtual void count_blocks() = 0;
  /// Ends that. @returns what was counted, in the order of the blocks
  virtual std::vector<BlockHead> counted_blocks() = 0;
  /// Before there are particles on any rank: cuts by the number of particles that each block will hold. @param heads  on the first rank
  virtual void cut(const JoinedBlocks& joined, std::span<const BlockHead> heads) = 0;
};

}  // namespace mpm
