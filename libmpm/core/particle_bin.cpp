#include "libmpm/core/particle_bin.hpp"

#include <sys/mman.h>

#include <cstring>
#include <new>

namespace mpm {

void PagePool::Unmap::operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{slab_bytes}); }

std::byte* PagePool::take() {
  const std::lock_guard lock(mutex_);
  if (free_.empty()) {
    void* memory = ::operator new (slab_bytes, std::align_val_t{slab_bytes});
    madvise(memory, slab_bytes, MADV_HUGEPAGE);  // advice only: without huge pages the slab works as well
    slabs_.emplace_back(static_cast<std::byte*>(memory));
    for (std::size_t n = slab_bytes / page_bytes_; n-- > 0;) free_.push_back(slabs_.back().get() + n * page_bytes_);
  }
  std::byte* page = free_.back();
  free_.pop_back();
  std::memset(page, 0, page_bytes_);
  return page;
}

void PagePool::give_back(std::byte* page) {
  const std::lock_guard lock(mutex_);
  free_.push_back(page);
}

void ParticleBin::append(int cell_of_p, PagePool& pool) {
  if (count_ == static_cast<int>(pages_.size()) * page_particles) pages_.push_back(pool.take());
  cell.push_back(static_cast<std::uint8_t>(cell_of_p));
  ++count_;
  order.clear();
}

void ParticleBin::append(const Particle& p, int cell_of_p, PagePool& pool) {
  if (count_ == 0) frame.velocity = velocity_of(p);  // until grid_to_particle sets the mean velocity
  append(cell_of_p, pool);
  set(count_ - 1, p);
}

void ParticleBin::remove(int slot, PagePool& pool) {
  const int last = count_ - 1;
  if (slot != last) {
    std::memcpy(bytes(slot).data(), bytes(last).data(), record_bytes(precision_));
    cell[static_cast<std::size_t>(slot)] = cell[static_cast<std::size_t>(last)];
  }
  cell.pop_back();
  order.clear();
  count_ = last;
  if (count_ + 2 * page_particles <= static_cast<int>(pages_.size()) * page_particles) {  // keep one spare: no thrashing at a page's edge
    pool.give_back(pages_.back());
    pages_.pop_back();
  }
}

int ParticleBin::last_leaver(int end) const {
  const void* const found = memrchr(cell.data(), left_block, static_cast<std::size_t>(end));
  return found == nullptr ? -1 : static_cast<int>(static_cast<const std::uint8_t*>(found) - cell.data());
}

void ParticleBin::release(PagePool& pool) {
  for (std::byte* page : pages_) pool.give_back(page);
  pages_.clear();
  cell.clear();
  order.clear();
  count_ = 0;
}

void ParticleBin::sort_by_cell() {
  // Four runs of slots, each with counters of its own: neighbouring slots often share a cell, and one counter would make each
  // increment wait for the one before. The resulting order is that of one run.
  constexpr std::size_t runs = 4;
  const std::size_t n = cell.size(), length = n / runs;
  const std::uint8_t* const c = cell.data();
  std::uint16_t next[runs][block_nodes] = {};
  for (std::size_t s = 0; s < length; ++s) {
    for (std::size_t r = 0; r < runs; ++r) ++next[r][c[r * length + s]];
  }
  for (std::size_t s = runs * length; s < n; ++s) ++next[runs - 1][c[s]];
  std::uint16_t sum = 0;
  for (int k = 0; k < block_nodes; ++k) {
    cell_start[k] = sum;
    for (auto& run : next) {
      const std::uint16_t count = run[k];
      run[k] = sum;
      sum = static_cast<std::uint16_t>(sum + count);
    }
  }
  cell_start[block_nodes] = sum;
  order.resize(n);
  std::uint16_t* const o = order.data();
  for (std::size_t s = 0; s < length; ++s) {
    for (std::size_t r = 0; r < runs; ++r) o[next[r][c[r * length + s]]++] = static_cast<std::uint16_t>(r * length + s);
  }
  for (std::size_t s = runs * length; s < n; ++s) o[next[runs - 1][c[s]]++] = static_cast<std::uint16_t>(s);
}

}  // namespace mpm
