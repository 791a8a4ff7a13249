#pragma once
/// Sparse grid: blocks of nodes, each with the particles whose base nodes it owns.
///
/// Space is cut into blocks of 4x4x4 cells. A particle belongs to the block of its base node (bspline.hpp); the nodes that the
/// particles of one block touch are the 6x6x6 nodes from the block's first node on: its own 64 and a rim of two in its seven
/// forward neighbours. A block exists while it, or one of its seven backward neighbours, holds particles, so memory follows the
/// occupied volume and not the bounding box.
///
/// Results are repeatable because the order is fixed. Every list of blocks is sorted by coordinate, and only the thread that works on a
/// block changes it. So any number of threads gives the same bits.

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "libmpm/base/lanes.hpp"
#include "libmpm/core/migration.hpp"
#include "libmpm/core/node_index.hpp"
#include "libmpm/core/particle_bin.hpp"
#include "libmpm/core/ranks.hpp"

namespace mpm {

/// One node of the grid: a vector and a mass. A step changes the vector from the node's momentum to its velocity (Grid::momenta).
using Node = HalfLanes;

/// The nodes that a block owns.
struct alignas(64) NodeBlock {
  Node node[block_nodes];  ///< index x + 4 y + 16 z
};

/// 4x4x4 cells with their particles. An own block is one that this rank computes; ghosts are the others that it stores.
struct Block {
  Index3 coordinate{};                       ///< in blocks; its first node is first_node() of it
  std::array<std::int32_t, 27> neighbour{};  ///< by direction: indices in Grid, or no_block
  ParticleBin particles;                     ///< whose base node is here
  Outbox outbox;                             ///< particles that leave
  bool owned = true;                         ///< an own block; false: a ghost (ranks.hpp)
  bool at_border = false;                    ///< it or a neighbour is another rank's
  bool outer = false;                        ///< an own block whose particles touch nodes of ghosts: set by StepExchange::plan
  /// Where the particles' contributions go, by direction. StepExchange::plan sets it for blocks that share nodes with other ranks: to
  /// buffers (Grid::new_buffer).
  const std::array<std::int32_t, 27>* buffers = nullptr;
  /// Indices in Grid of the nodes that the particles' contributions go to, by direction.
  [[nodiscard]] const std::array<std::int32_t, 27>& targets() const { return buffers != nullptr ? *buffers : neighbour; }
};

inline constexpr int max_particles_per_block = 65000;  ///< slots are 16 bits wide

/// The particles of one block as they are stored: what a checkpoint holds. Nothing is rounded on the way there and back.
struct StoredBlock {
  Index3 coordinate{};                  ///< of the block
  Vec3 velocity = Vec3::Zero();         ///< RecordFrame::velocity
  std::span<const std::uint8_t> cells;  ///< of the slots
  std::span<const std::byte> records;   ///< one after the other, record_bytes() each
};

/// The blocks, found by coordinate. An index is valid until refresh() frees its block. Lists hold own blocks unless named otherwise.
class Grid {
 public:
  /// @param cell_size dx, m
  explicit Grid(double cell_size, Precision precision = Precision::double_precision)
      : cell_size_(cell_size), inverse_cell_size_(1.0 / cell_size), precision_(precision) {}

  [[nodiscard]] Precision precision() const { return precision_; }               ///< of the stored particles
  [[nodiscard]] double cell_size() const { return cell_size_; }                  ///< dx, m
  [[nodiscard]] double inverse_cell_size() const { return inverse_cell_size_; }  ///< 1/m

  /// Puts one particle into its block (created if needed); one of another rank is left out. Serial. Call refresh() before the next
  /// transfer.
  void insert(const Particle& p);
  /// Puts back a block as it was saved: same slots, same cells, same bits. Serial; call refresh() afterwards.
  void restore(const StoredBlock& stored);
  /// Takes a particle out of its block; the block's last particle gets its slot. Blocks may be worked on in parallel.
  void remove(std::int32_t block_index, int slot) { block(block_index).particles.remove(slot, *pool_); }

  /// Puts a migrant into a block's outbox. Blocks may be worked on in parallel, but those of one block are put one after the other.
  void send(std::int32_t block_index, const Migrant& m) { block(block_index).outbox.add(m, migrants_); }
  /// Moves the migrants of all blocks to where they belong, sorts every block by cell and refreshes the lists.
  /// Call after collect_migrants of all blocks. @throws std::bad_alloc; UnstableError if a block gets too many particles
  void migrate();

  /// Creates the forward neighbours of occupied blocks, frees blocks without particles near them, sorts particles that were inserted by
  /// cell, and rebuilds the lists. All ranks call it together: it tells the others which blocks are occupied and plans the messages.
  void refresh();

  /// What the implementation of Ranks needs besides.
  /// @{
  /// From now on blocks have owners; call refresh() then. @param ranks  outlives the grid
  void divide(Ranks& ranks);
  [[nodiscard]] Ranks& ranks() const { return *ranks_; }  ///< of which this grid has the blocks of one
  /// Asks again who owns which block, after that has changed. Call refresh() when blocks are where they belong.
  void ask_owners();
  /// The own block or ghost with this coordinate; created if needed.
  std::int32_t find_or_create(const Index3& coordinate);
  /// The same; no_block where there is none.
  [[nodiscard]] std::int32_t find_any(const Index3& coordinate) const;
  /// Removes all particles of a block.
  void clear(std::int32_t index) { block(index).particles.release(*pool_); }
  /// Nodes that belong to no block, for contributions on their way to another rank. @returns their index, valid until free_buffers()
  std::int32_t new_buffer();
  void free_buffers();                                                              ///< all of them
  [[nodiscard]] std::span<const std::int32_t> buffers() const { return buffers_; }  ///< all that are in use
  /// Indices of blocks and buffers are below this: the size of a field by index.
  [[nodiscard]] std::size_t index_end() const { return nodes_.size(); }
  /// @}

  /// @param index  from a list or find()
  Block& block(std::int32_t index) { return blocks_[static_cast<std::size_t>(index)]; }
  /// @param index  from a list or find()
  [[nodiscard]] const Block& block(std::int32_t index) const { return blocks_[static_cast<std::size_t>(index)]; }
  /// The nodes that a block owns, named by the phase of the step. update_grid() turns momenta into velocities, in the same memory.
  /// @{
  /// {p, m}, from particle_to_grid to update_grid.
  NodeBlock& momenta(std::int32_t index) { return field(0, index); }
  [[nodiscard]] const NodeBlock& momenta(std::int32_t index) const { return field(0, index); }
  /// {v, m}, from update_grid on.
  NodeBlock& velocities(std::int32_t index) { return field(0, index); }
  [[nodiscard]] const NodeBlock& velocities(std::int32_t index) const { return field(0, index); }
  /// @}
  /// A second field, if forces are kept apart: the momentum that the internal forces give is not part of momenta(). With it a transfer
  /// compares a particle with the grid before forces.
  /// @{
  [[nodiscard]] bool keeps_forces_apart() const { return forces_apart_; }
  void keep_forces_apart(bool apart) {
    forces_apart_ = apart;
    forces_.resize(apart ? nodes_.size() : 0);
  }
  /// {dt f, 0}, from particle_to_grid to update_grid.
  NodeBlock& force_impulses(std::int32_t index) { return field(1, index); }
  /// {u, 1}, from update_grid on: velocities without the changes by forces and boundaries.
  NodeBlock& velocities_before_forces(std::int32_t index) { return field(1, index); }
  [[nodiscard]] const NodeBlock& velocities_before_forces(std::int32_t index) const { return field(1, index); }
  /// @}
  /// Both by number, for what treats them alike. @{
  [[nodiscard]] int fields() const { return forces_apart_ ? 2 : 1; }
  NodeBlock& field(int number, std::int32_t index) { return (number == 0 ? nodes_ : forces_)[static_cast<std::size_t>(index)]; }
  [[nodiscard]] const NodeBlock& field(int number, std::int32_t index) const {
    return (number == 0 ? nodes_ : forces_)[static_cast<std::size_t>(index)];
  }
  /// @}

  /// Memory for nodes within one phase of a step, with any content. It is kept from step to step: arrays of megabytes that are allocated
  /// and freed in each of them would be scattered over the heap, which would double within some thousand steps.
  [[nodiscard]] std::span<NodeBlock> scratch(std::size_t count) {
    if (scratch_.size() < count) scratch_.resize(count + count / 4);
    return std::span(scratch_).first(count);
  }

  [[nodiscard]] std::span<const std::int32_t> own_blocks() const { return own_; }            ///< sorted by coordinate
  [[nodiscard]] std::span<const std::int32_t> occupied_blocks() const { return occupied_; }  ///< those with particles
  /// Occupied blocks of one colour (colour_of): no two of them touch a common node.
  [[nodiscard]] std::span<const std::int32_t> coloured_blocks(int colour) const { return coloured_[static_cast<std::size_t>(colour)]; }
  /// Index of the own block with this coordinate; no_block where there is none.
  [[nodiscard]] std::int32_t find(const Index3& coordinate) const;

  [[nodiscard]] std::size_t particle_count() const;  ///< in all blocks, of all ranks
  [[nodiscard]] std::size_t bytes() const;           ///< memory of blocks, nodes and particles

  /// Calls f(Particle&) on each particle in storage order, and stores what it left. Positions must stay within their cell.
  template <class F>
  void change_particles(F&& f) {
    for (const auto b : occupied_) {
      ParticleBin& bin = block(b).particles;
      for (int s = 0; s < bin.count(); ++s) {
        Particle p = bin[s];
        f(p);
        bin.set(s, p);
      }
    }
  }

  /// Calls f(const Particle&) in storage order (blocks by coordinate, slots ascending).
  template <class F>
  void for_each_particle(F&& f) const {
    for (const auto b : occupied_) {
      const ParticleBin& bin = block(b).particles;
      for (int s = 0; s < bin.count(); ++s) f(bin[s]);
    }
  }

 private:
  std::int32_t create(const Index3& coordinate);
  void ask_owner(Block& b) const;
  std::int32_t new_storage();
  void destroy(std::int32_t index);
  void rebuild_lists();

  double cell_size_, inverse_cell_size_;
  Precision precision_;
  bool forces_apart_ = false, set_changed_ = true;
  std::unique_ptr<PagePool> pool_ = std::make_unique<PagePool>(record_bytes(precision_));
  std::deque<Block> blocks_;
  std::deque<NodeBlock> nodes_, forces_;
  std::vector<NodeBlock> scratch_;
  MigrantLists migrants_;
  std::vector<std::int32_t> free_;
  std::unordered_map<std::uint64_t, std::int32_t> index_;
  std::vector<std::int32_t> own_, occupied_, ghosts_, buffers_;
  Ranks* ranks_ = &one_rank();
  std::array<std::vector<std::int32_t>, 8> coloured_;
};

/// Fields on the nodes of a grid that are treated alike.
class NodeFields {
 public:
  /// All fields of a grid. @param grid  must outlive this object
  explicit NodeFields(Grid& grid)
      : count_(grid.fields()), nodes_of_([&grid](std::int32_t index, int number) -> NodeBlock& { return grid.field(number, index); }) {}
  /// One field. @param field  by index of block, below Grid::index_end()
  explicit NodeFields(std::span<NodeBlock> field)
      : count_(1), nodes_of_([field](std::int32_t index, int) -> NodeBlock& { return field[static_cast<std::size_t>(index)]; }) {}

  [[nodiscard]] int count() const { return count_; }                                        ///< number of fields
  NodeBlock& of(std::int32_t index, int number) const { return nodes_of_(index, number); }  ///< the nodes of a block
  /// Bytes of so many nodes in all fields.
  [[nodiscard]] std::size_t bytes(std::size_t nodes) const { return static_cast<std::size_t>(count_) * nodes * sizeof(Node); }

 private:
  int count_;
  std::function<NodeBlock&(std::int32_t index, int number)> nodes_of_;
};

}  // namespace mpm
