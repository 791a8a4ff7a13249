#pragma once
/// Particles on their way from block to block. While blocks are worked on in parallel, each puts the particles that leave it into its
/// outbox; then every block collects its new particles from the outboxes of its neighbours, in a fixed order (Grid::migrate).

#include <omp.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "libmpm/core/particle.hpp"

namespace mpm {

/// A particle on its way to another block.
struct Migrant {
  Particle particle;  ///< with its new position
  std::uint8_t cell;  ///< there
  std::uint8_t to;    ///< direction of that block
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

/// A list for each thread.
class MigrantLists {
 public:
  /// Created if needed; valid as long as this object.
  MigrantList& of_this_thread() {
    const std::lock_guard lock(*mutex_);
    const auto thread = static_cast<std::size_t>(omp_get_thread_num());
    if (lists_.size() <= thread) lists_.resize(thread + 1);
    return lists_[thread];
  }
  /// As MigrantList::clear().
  void clear() {
    for (MigrantList& list : lists_) list.clear();
  }
  /// Memory of all.
  [[nodiscard]] std::size_t bytes() const {
    std::size_t n = 0;
    for (const MigrantList& list : lists_) n += list.capacity() * sizeof(Migrant);
    return n;
  }

 private:
  std::deque<MigrantList> lists_;
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
};

/// The particles that leave a block in a step, until migrate(): a part of a thread's list.
struct Outbox {
  MigrantList* list = nullptr;       ///< null: empty
  std::size_t first = 0, count = 0;  ///< place in the list
  std::uint32_t neighbours = 0;      ///< bit n: there are migrants to neighbour n

  /// Adds a migrant. One thread adds all migrants of a block, one after the other. @throws std::bad_alloc
  void add(const Migrant& m, MigrantLists& lists) {
    if (list == nullptr) {
      list = &lists.of_this_thread();
      first = list->size();
    }
    list->push_back(m);
    ++count;
    neighbours |= 1U << m.to;
  }
  /// Calls f(const Migrant&) on each, in their order.
  template <class F>
  void for_each(F&& f) const {
    for (std::size_t i = first; i < first + count; ++i) f((*list)[i]);
  }
};

}  // namespace mpm
