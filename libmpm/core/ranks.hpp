#pragma once
/// Other processes that compute parts of the same state: ranks.
///
/// Every block of the grid has an owner, which follows from its coordinate alone. A rank holds the particles and the nodes of its own
/// blocks, and ghosts: blocks of other ranks next to its own. What makes the results those of one rank, to the last bit:
///
/// - What a block's particles give to nodes of another rank's block is sent as it is, not summed, and the owner adds all such parts in the
///   order of the colours (add_parts). The nodes that particles elsewhere need are then sent back (return_nodes).
/// - Blocks in which one boundary acts on several nodes together have one owner (joined_blocks.hpp).
/// - A migrant to another rank's block arrives in the outbox of a ghost, where its new block finds it in its turn.
/// - Parts of sums are brought to the first rank and added there in the order of the blocks (block_table.hpp).
///
/// The core knows this interface; libmpm/parallel implements it. In a program of one process there is no object of it, and a grid's
/// ranks() is null.

#include <cstdint>
#include <functional>
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

/// What all ranks do together. The first rank decides; the others wait for its next word (driver/worker.hpp).
enum class Task : std::uint32_t {
  step,       ///< step()
  totals,     ///< totals()
  fastest,    ///< the fastest particle of all
  inside,     ///< particles that start inside a boundary
  observe,    ///< particles that an observer wants to see
  particles,  ///< all particles by their numbers, for a file
  blocks,     ///< all blocks in their order, for a file
  report,     ///< what was exchanged
  end,        ///< nothing follows
};

/// Why a step cannot be taken, found in one block.
struct BlockFault {
  Index3 block;      ///< where
  std::string text;  ///< the message
};

/// What one rank has computed and exchanged since the start, but for what went into files.
struct RankCounts {
  std::uint64_t particles = 0;       ///< of this rank now
  std::uint64_t steps = 0;           ///< steps taken
  std::uint64_t particle_steps = 0;  ///< particles of this rank, summed over the steps
  std::uint64_t block_steps = 0;     ///< likewise: its blocks with particles
  std::uint64_t border_steps = 0;    ///< likewise: those of them next to a block of another rank
  std::uint64_t messages = 0;        ///< sent to neighbours: parts, nodes, migrants
  std::uint64_t part_bytes = 0;      ///< sent with parts
  std::uint64_t node_bytes = 0;      ///< sent with nodes
  std::uint64_t migrant_bytes = 0;   ///< sent with migrants
  std::uint64_t exchanges = 0;       ///< times that all ranks told each other of their borders
  std::uint64_t reductions = 0;      ///< numbers of all ranks made one: sums, maxima
  std::uint64_t reduced_bytes = 0;   ///< given to these
  std::uint64_t gathers = 0;         ///< rows of all ranks brought to the first
  std::uint64_t gathered_bytes = 0;  ///< given to these
  std::uint64_t moves = 0;           ///< times that blocks changed their owners
};

/// One rank's view of the others. All functions but the const ones are called by all ranks together, outside of parallel regions.
class Ranks {
 public:
  virtual ~Ranks() = default;

  [[nodiscard]] virtual int size() const = 0;  ///< how many there are
  /// Whether this is the rank that decides, measures and writes; sums over blocks are whole there alone.
  [[nodiscard]] virtual bool first() const = 0;
  /// Whether a block is this rank's own.
  [[nodiscard]] virtual bool owns(const Index3& block) const = 0;
  /// Whether a block or one of its 26 neighbours is another rank's.
  [[nodiscard]] virtual bool at_border(const Index3& block) const = 0;

  /// The first rank tells the others what is next, with the scalars of its state; on the others it does nothing: next() told them.
  virtual void tell(Task task, const State& state, double dt = 0.0) = 0;
  /// What the first rank told the others.
  struct Told {
    Task task = Task::end;  ///< what is next
    double dt = 0.0;        ///< s, of a step
  };
  /// The others wait for what is next. @param state  gets the scalars of the first rank's
  virtual Told next(State& state) = 0;
  /// What all were told is done. An exception before that leaves the others waiting: the caller must end them.
  virtual void done() = 0;
  /// Whether all are in what they were told.
  [[nodiscard]] virtual bool busy() const = 0;

  /// Before a step: moves blocks to other ranks where blocks were joined that were not before, or where the load is uneven.
  virtual void prepare(Grid& grid, const JoinedBlocks& joined) = 0;
  /// Tells the others of the particles at their borders, and makes ghosts of theirs. @returns the blocks that have to be there
  virtual std::vector<std::int32_t> announce(Grid& grid) = 0;
  /// Prepares add_parts() and return_nodes() for the blocks as they are now.
  virtual void plan(Grid& grid) = 0;
  /// After all blocks have given their parts to the nodes: adds those that belong to nodes shared with other ranks.
  virtual void add_parts(Grid& grid) = 0;
  /// The same for another field. @param field  by number of block, lent ones among them
  virtual void add_parts(std::span<NodeBlock> field) = 0;
  /// After the update: sends nodes to the ranks whose particles need them.
  virtual void return_nodes(Grid& grid) = 0;
  /// Moves migrants to blocks of other ranks from this rank's outboxes into those of the ghosts there.
  virtual void exchange_migrants(Grid& grid) = 0;

  /// @returns the largest of all ranks' values. @throws UnstableError, on all, with the fault of the first block in order
  virtual double agree(double largest, const std::optional<BlockFault>& fault) = 0;
  /// Each number becomes the sum over all ranks.
  virtual void sum(std::span<std::uint64_t> numbers) = 0;
  /// What every rank gives, by rank, on the first; elsewhere nothing.
  virtual std::vector<Message> gather(Message mine) = 0;
  /// The message of the first rank, on all.
  virtual void share(Message& message) = 0;
  /// Particles of all ranks, as of the last announce(). @param own  of this rank: all that there are before the first step
  [[nodiscard]] virtual std::size_t particle_count(std::size_t own) const = 0;

  /// Copies blocks with their particles into a grid of the first rank that knows no other ranks.
  /// @param wanted  which, asked where the block is
  virtual void collect(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into) = 0;
  /// Counts of all ranks, on the first; elsewhere nothing. @param particles  of this rank
  virtual std::vector<RankCounts> counts(std::size_t particles) = 0;
};

}  // namespace mpm
