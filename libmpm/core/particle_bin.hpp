#pragma once
/// The particles of one block, and the memory of all particles: pages of 32 records, cut from slabs that are aligned to huge pages.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "libmpm/core/particle.hpp"

namespace mpm {

inline constexpr int page_particles = 32;  ///< particles of a page

/// Pages are handed out in any order by several threads; which address a page has never influences a result.
class PagePool {
 public:
  /// @param record_bytes  size of a record, a multiple of its alignment
  explicit PagePool(std::size_t record_bytes) : page_bytes_(page_particles * record_bytes) {}

  /// A page of zeros, aligned to 64 bytes. @throws std::bad_alloc
  std::byte* take();
  /// @param page  from take() of this pool
  void give_back(std::byte* page);
  [[nodiscard]] std::size_t bytes() const { return slabs_.size() * slab_bytes; }  ///< of all slabs, in use or not

 private:
  static constexpr std::size_t slab_bytes = std::size_t{2} << 20;
  struct Unmap {
    void operator()(std::byte* p) const;
  };
  std::size_t page_bytes_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<std::byte[], Unmap>> slabs_;
  std::vector<std::byte*> free_;
};

/// Particles of one block: pages in slot order, and the slots sorted by cell.
///
/// They are stored as Particle or as SingleRecord; one run has one of the two. Kernels and some other loops of core/ work on the records,
/// all other code on the value Particle.
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

}  // namespace mpm
