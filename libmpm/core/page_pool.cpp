#include "libmpm/core/page_pool.hpp"

#include <sys/mman.h>

#include <new>

namespace mpm {

void PagePool::Unmap::operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{slab_bytes}); }

ParticlePage* PagePool::take() {
  const std::lock_guard lock(mutex_);
  if (free_.empty()) {
    void* memory = ::operator new (slab_bytes, std::align_val_t{slab_bytes});
    madvise(memory, slab_bytes, MADV_HUGEPAGE);  // advice only: without huge pages the slab works as well
    slabs_.emplace_back(static_cast<std::byte*>(memory));
    auto* pages = static_cast<ParticlePage*>(memory);
    for (std::size_t n = slab_bytes / sizeof(ParticlePage); n-- > 0;) free_.push_back(pages + n);
  }
  ParticlePage* page = free_.back();
  free_.pop_back();
  return new (page) ParticlePage{};
}

void PagePool::give_back(ParticlePage* page) {
  const std::lock_guard lock(mutex_);
  free_.push_back(page);
}

}  // namespace mpm
