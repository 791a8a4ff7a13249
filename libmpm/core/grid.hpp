#pragma once
/// Block-sparse grid and block-sorted particles.
///
/// Space is cut into blocks of 4x4x4 cells. A particle belongs to the block of its base node (bspline.hpp); the nodes that the
/// particles of one block touch are the 6x6x6 nodes from the block's first node on: its own 64 and a rim of two in its seven
/// forward neighbours. A block exists while it, or one of its seven backward neighbours, holds particles, so memory follows the
/// occupied volume and not the bounding box.
///
/// Results are repeatable because the order is fixed. Every list below is sorted by block coordinate, and only the thread that works on a
/// block changes it. So any number of threads gives the same bits.

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <unordered_map>
#include <vector>

#include "libmpm/base/lanes.hpp"
#include "libmpm/base/precision.hpp"
#include "libmpm/base/types.hpp"
#include "libmpm/core/page_pool.hpp"
#include "libmpm/core/particle.hpp"
#include "libmpm/core/ranks.hpp"
#include "libmpm/core/single_record.hpp"

namespace mpm {

using Node = HalfLanes;  ///< {p_x, p_y, p_z, m} after particle_to_grid, {v_x, v_y, v_z, m} after update_grid

inline constexpr int block_nodes = 64;  ///< nodes a block owns
/// From a node of a block to the next one along an axis, in the numbers of nodes.
constexpr int node_stride(int axis) { return axis == 0 ? 1 : axis == 1 ? block_edge : block_edge * block_edge; }
/// Place of a block's node along an axis, 0 .. 3. @param node  its number in the block
constexpr int place_along(int axis, int node) {
  static_assert(block_edge == 4);
  return node >> 2 * axis & 3;
}
/// Number of a block's node at these places along the axes.
constexpr int node_number(int x, int y, int z) { return x * node_stride(0) + y * node_stride(1) + z * node_stride(2); }
inline constexpr int halo_edge = block_edge + 2;                      ///< nodes per axis that a block's particles touch
inline constexpr int halo_nodes = halo_edge * halo_edge * halo_edge;  ///< nodes that a block's particles touch
inline constexpr std::int32_t no_block = -1;                          ///< index if there is no block

/// Offset of a neighbour: dx, dy, dz in {-1, 0, 1}; 13 is the block itself, 26 - slot the opposite neighbour.
constexpr int neighbour_slot(int dx, int dy, int dz) { return (dz + 1) * 9 + (dy + 1) * 3 + dx + 1; }
/// Coordinate of a neighbour. @param slot  neighbour_slot
constexpr Index3 neighbour_of(const Index3& block, int slot) {
  return {block[0] + slot % 3 - 1, block[1] + slot / 3 % 3 - 1, block[2] + slot / 9 - 1};
}
/// The eight blocks (itself and its forward neighbours) that hold the nodes of a block's particles. Number k: bit 0 is one block along x,
/// bit 1 along y, bit 2 along z.
inline constexpr std::array<int, 8> forward_slots = {neighbour_slot(0, 0, 0), neighbour_slot(1, 0, 0), neighbour_slot(0, 1, 0),
                                                     neighbour_slot(1, 1, 0), neighbour_slot(0, 0, 1), neighbour_slot(1, 0, 1),
                                                     neighbour_slot(0, 1, 1), neighbour_slot(1, 1, 1)};
/// Parity of a block's coordinates, a bit an axis: blocks of one colour share no node.
constexpr int colour_of(const Index3& block) { return (block[0] & 1) | (block[1] & 1) << 1 | (block[2] & 1) << 2; }
/// Whether block a comes before block b in every list and every sum: by z, then y, then x.
constexpr bool comes_before(const Index3& a, const Index3& b) {
  if (a[2] != b[2]) return a[2] < b[2];
  return a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

/// Bytes of a stored particle.
constexpr std::size_t record_bytes(Precision precision) {
  return precision == Precision::single_precision ? sizeof(SingleRecord) : sizeof(Particle);
}

/// Calls f with a value of the type that a run stores (Particle or SingleRecord): how a kernel, a template over that type, is chosen.
template <class F>
decltype(auto) with_record_type(Precision precision, F&& f) {
  return precision == Precision::single_precision ? f(SingleRecord{}) : f(Particle{});
}

/// Particles of one block: pages in slot order, and the slots sorted by cell.
///
/// They are stored as Particle or as SingleRecord; one run has one of the two. Kernels work on the records. All other code reads and writes
/// the value Particle as a whole.
class ParticleBin {
 public:
  ParticleBin() = default;
  /// Empty. @param precision  of the records
  explicit ParticleBin(Precision precision) : precision_(precision) {}

  [[nodiscard]] int count() const { return count_; }  ///< particles, in slots 0 .. count() - 1
  /// The particle in a slot.
  [[nodiscard]] Particle operator[](int slot) const {
    return precision_ == Precision::single_precision ? decode(record<SingleRecord>(slot), frame) : record<Particle>(slot);
  }
  /// Replaces the particle in a slot. Its position must be in the slot's cell.
  void set(int slot, const Particle& p) {
    const int at = cell[static_cast<std::size_t>(slot)];
    with_record_type(precision_, [&](auto type) { encode(p, at, frame, record<decltype(type)>(slot)); });
  }
  /// The record in a slot. @tparam Record  what the run stores
  /// @{
  template <class Record>
  Record& record(int slot) {
    return *reinterpret_cast<Record*>(address(slot, sizeof(Record)));
  }
  template <class Record>
  [[nodiscard]] const Record& record(int slot) const {
    return *reinterpret_cast<const Record*>(address(slot, sizeof(Record)));
  }
  /// @}
  /// The bytes of a record. @{
  [[nodiscard]] std::span<const std::byte> bytes(int slot) const {
    return {address(slot, record_bytes(precision_)), record_bytes(precision_)};
  }
  [[nodiscard]] std::span<std::byte> bytes(int slot) { return {address(slot, record_bytes(precision_)), record_bytes(precision_)}; }
  /// @}
  /// Into a new last slot. @param cell  local base node. @throws std::bad_alloc; ConfigError as encode()
  void append(const Particle& p, int cell, PagePool& pool);
  /// A new last slot, whose record is to be written. @throws std::bad_alloc
  void append(int cell, PagePool& pool);
  /// The last particle takes the place of the removed one.
  void remove(int slot, PagePool& pool);
  /// Removes all particles and gives the pages back.
  void release(PagePool& pool);
  /// The last slot below `end` whose particle is marked left_block; -1 if there is none.
  [[nodiscard]] int last_leaver(int end) const;
  /// Rebuilds the order by cell (stable counting sort); call after positions changed.
  void sort_by_cell();

  /// cell[slot]: local base node (x + 4 y + 16 z), or left_block
  std::vector<std::uint8_t> cell;
  /// Slots by cell: those of cell c are order[cell_start[c]] .. order[cell_start[c + 1] - 1]. Empty from a change of the bin to the next
  /// sort.
  std::vector<std::uint16_t> order;
  std::uint16_t cell_start[block_nodes + 1] = {};  ///< places in order

  static constexpr std::uint8_t left_block = 64;  ///< moves to another block

  RecordFrame frame;  ///< what single records are relative to

 private:
  /// Of the record in a slot. @param size  of a record, bytes
  [[nodiscard]] std::byte* address(int slot, std::size_t size) const {
    return pages_[static_cast<unsigned>(slot) / page_particles] + static_cast<unsigned>(slot) % page_particles * size;
  }

  std::vector<std::byte*> pages_;
  int count_ = 0;
  Precision precision_ = Precision::double_precision;
};

/// A particle on its way to another block.
struct Migrant {
  Particle particle;  ///< with its new position
  std::uint8_t cell;  ///< there
  std::uint8_t to;    ///< neighbour_slot of that block
};

/// The migrants of the blocks that one thread moves. The list is in pieces, so that it grows without a copy.
class MigrantList {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }                       ///< migrants
  [[nodiscard]] std::size_t capacity() const { return pieces_.size() * piece; }  ///< migrants that have memory
  /// @param i  below size()
  [[nodiscard]] const Migrant& operator[](std::size_t i) const { return pieces_[i / piece][i % piece]; }
  /// Appends a migrant. @throws std::bad_alloc
  void push_back(const Migrant& m) {
    if (size_ == capacity()) pieces_.push_back(std::make_unique_for_overwrite<Migrant[]>(piece));
    pieces_[size_ / piece][size_ % piece] = m;
    ++size_;
  }
  /// Removes all and keeps as much memory as they took. More is returned: after a step in which a layer of particles crossed the faces of
  /// all blocks, most of it is not needed for some steps.
  void clear() {
    pieces_.resize((size_ + piece - 1) / piece);
    size_ = 0;
  }

 private:
  static constexpr std::size_t piece = 64;
  std::vector<std::unique_ptr<Migrant[]>> pieces_;
  std::size_t size_ = 0;
};

/// The particles that leave a block in a step, until migrate(): a part of a thread's list.
struct Outbox {
  MigrantList* list = nullptr;       ///< null: empty
  std::size_t first = 0, count = 0;  ///< place in the list
  std::uint32_t neighbours = 0;      ///< bit n: there are migrants to neighbour n

  /// Calls f(const Migrant&) on each, in their order.
  template <class F>
  void for_each(F&& f) const {
    for (std::size_t i = first; i < first + count; ++i) f((*list)[i]);
  }
};

/// 4x4x4 cells, with their particles and the numbers of the neighbours.
struct Block {
  Index3 coordinate{};                       ///< along each axis: first_node()
  std::array<std::int32_t, 27> neighbour{};  ///< by neighbour_slot: indices in Grid, or no_block
  ParticleBin particles;                     ///< whose base node is here
  Outbox outbox;                             ///< particles that leave
  bool owned = true;                         ///< false: a ghost, another rank's (ranks.hpp)
  bool at_border = false;                    ///< a block of another rank is among it and its neighbours
  bool outer = false;                        ///< its particles touch nodes of blocks of other ranks: set by Ranks::plan
  /// Where the particles' contributions go instead of the neighbours' nodes: set by Ranks::plan for blocks that share nodes with other
  /// ranks.
  const std::array<std::int32_t, 27>* parts = nullptr;
};

/// Numbers along the axes of one of a block's own nodes. @param node  x + 4 y + 16 z
constexpr Index3 node_index(const Index3& block, int node) {
  return {first_node(block[0]) + place_along(0, node), first_node(block[1]) + place_along(1, node),
          first_node(block[2]) + place_along(2, node)};
}
/// The block that owns a node, and the node's number in it: the inverse of node_index(). @{
constexpr Index3 block_of_node(const Index3& at) { return {block_of_node(at[0]), block_of_node(at[1]), block_of_node(at[2])}; }
constexpr int number_of_node(const Index3& at) { return node_number(place_of_node(at[0]), place_of_node(at[1]), place_of_node(at[2])); }
/// @}
/// Position of one of a block's own nodes, m. @param node  x + 4 y + 16 z
inline Vec3 node_position(const Index3& block, int node, double cell_size) {
  const Index3 at = node_index(block, node);
  return cell_size * Vec3(at[0], at[1], at[2]);
}

/// The box in which a block's particles lie, m, up to rounding of a position on the edge of its cell.
/// @param around  cells added on every side
inline Eigen::AlignedBox3d block_box(const Index3& block, double cell_size, double around = 1e-6) {
  const Vec3 first(first_node(block[0]), first_node(block[1]), first_node(block[2]));
  const Vec3 low = first + Vec3::Constant(0.5 - around), high = first + Vec3::Constant(0.5 + block_edge + around);
  return {cell_size * low, cell_size * high};
}

/// The nodes that a block owns.
struct alignas(64) NodeBlock {
  Node node[block_nodes];  ///< index x + 4 y + 16 z
};

/// The particles of one block as they are stored: what a checkpoint holds. Nothing is rounded on the way there and back.
struct StoredBlock {
  Index3 coordinate{};                  ///< of the block
  Vec3 velocity = Vec3::Zero();         ///< RecordFrame::velocity
  std::span<const std::uint8_t> cells;  ///< of the slots
  std::span<const std::byte> records;   ///< one after the other, record_bytes() each
};

/// The blocks, found by coordinate. An index stays valid until its block is freed by refresh().
class Grid {
 public:
  /// @param cell_size dx, m
  explicit Grid(double cell_size, Precision precision = Precision::double_precision)
      : cell_size_(cell_size), inverse_cell_size_(1.0 / cell_size), precision_(precision) {}

  [[nodiscard]] Precision precision() const { return precision_; }               ///< of the stored particles
  [[nodiscard]] double cell_size() const { return cell_size_; }                  ///< dx, m
  [[nodiscard]] double inverse_cell_size() const { return inverse_cell_size_; }  ///< 1/m

  /// Puts one particle into its block (created if needed). Serial. Call refresh() before the next transfer.
  void insert(const Particle& p);
  /// Puts back a block as it was saved: same slots, same cells, same bits. Serial; call refresh() afterwards.
  void restore(const StoredBlock& stored);
  /// Takes a particle out of its block; the block's last particle gets its slot. Blocks may be worked on in parallel.
  void remove(std::int32_t block_index, int slot) { block(block_index).particles.remove(slot, *pool_); }

  /// Puts a migrant into a block's outbox. Blocks may be worked on in parallel, but those of one block are put one after the other.
  void send(std::int32_t block_index, const Migrant& m);
  /// Moves the migrants of all blocks to where they belong, sorts every block by cell and refreshes the lists.
  /// Call after grid_to_particle. @throws std::bad_alloc
  void migrate();

  /// Creates the forward neighbours of occupied blocks, frees those without particles near them, rebuilds the lists.
  void refresh();

  /// What the implementation of Ranks needs besides. Blocks of other ranks are in no list but ghosts(), and find() does not find them.
  /// @{
  /// From now on blocks have owners; call refresh() then. @param ranks  outlives the grid
  void divide(Ranks* ranks);
  [[nodiscard]] Ranks* ranks() const { return ranks_; }  ///< null: there is one rank
  /// Asks again who owns which block, after that has changed. Call refresh() when blocks are where they belong.
  void ask_owners();
  /// The block with this coordinate, whoever owns it; created if needed.
  std::int32_t block_at(const Index3& coordinate);
  /// The same, no_block where there is none.
  [[nodiscard]] std::int32_t find_any(const Index3& coordinate) const;
  [[nodiscard]] std::span<const std::int32_t> ghosts() const { return ghosts_; }  ///< blocks of other ranks, sorted by coordinate
  /// Removes all particles of a block.
  void clear(std::int32_t index) { block(index).particles.release(*pool_); }
  /// Nodes that belong to no block: a part on its way. Valid until the parts are returned.
  std::int32_t lend_nodes();
  /// Takes all lent nodes back.
  void return_lent();
  [[nodiscard]] std::span<const std::int32_t> lent() const { return lent_; }  ///< all that were lent
  /// Numbers of blocks and of lent nodes are below this: for fields of one's own by number.
  [[nodiscard]] std::size_t numbers() const { return nodes_.size(); }
  /// @}

  /// @param index  from all_blocks() or find()
  Block& block(std::int32_t index) { return blocks_[static_cast<std::size_t>(index)]; }
  /// @param index  from all_blocks() or find()
  [[nodiscard]] const Block& block(std::int32_t index) const { return blocks_[static_cast<std::size_t>(index)]; }
  /// The nodes that a block owns, and what is kept of their values before the grid update.
  /// @{
  NodeBlock& nodes(std::int32_t index) { return nodes_[static_cast<std::size_t>(index)]; }
  [[nodiscard]] const NodeBlock& nodes(std::int32_t index) const { return nodes_[static_cast<std::size_t>(index)]; }
  /// For transfers that compare a particle with the grid before forces: after particle_to_grid the momentum that internal forces give,
  /// after update_grid the velocities before forces.
  NodeBlock& old_nodes(std::int32_t index) { return old_nodes_[static_cast<std::size_t>(index)]; }
  [[nodiscard]] const NodeBlock& old_nodes(std::int32_t index) const { return old_nodes_[static_cast<std::size_t>(index)]; }
  [[nodiscard]] bool keeps_old_nodes() const { return keep_old_nodes_; }
  void keep_old_nodes(bool keep) {
    keep_old_nodes_ = keep;
    old_nodes_.resize(keep ? nodes_.size() : 0);
  }
  /// @}

  [[nodiscard]] std::span<const std::int32_t> all_blocks() const { return all_; }            ///< sorted by coordinate
  [[nodiscard]] std::span<const std::int32_t> occupied_blocks() const { return occupied_; }  ///< those with particles
  /// Occupied blocks of one colour (colour_of): no two of them touch a common node.
  [[nodiscard]] std::span<const std::int32_t> coloured_blocks(int colour) const { return coloured_[static_cast<std::size_t>(colour)]; }
  /// Index of the block with this coordinate; no_block where there is none.
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
  MigrantList& migrants_of_this_thread();
  void rebuild_lists();

  double cell_size_, inverse_cell_size_;
  Precision precision_;
  bool keep_old_nodes_ = false, set_changed_ = true;
  std::unique_ptr<PagePool> pool_ = std::make_unique<PagePool>(record_bytes(precision_));
  std::deque<Block> blocks_;
  std::deque<NodeBlock> nodes_, old_nodes_;
  std::deque<MigrantList> migrants_;  ///< a list for each thread
  std::unique_ptr<std::mutex> migrants_mutex_ = std::make_unique<std::mutex>();
  std::vector<std::int32_t> free_;
  std::unordered_map<std::uint64_t, std::int32_t> index_;
  std::vector<std::int32_t> all_, occupied_, ghosts_, lent_;
  Ranks* ranks_ = nullptr;
  std::array<std::vector<std::int32_t>, 8> coloured_;
};

}  // namespace mpm
