#include "libmpm/core/page_pool.hpp"

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

}  // namespace mpm
