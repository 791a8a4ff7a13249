#include "libmpm/core/migration.hpp"

#include <omp.h>

namespace mpm {

MigrantList& MigrantLists::of_this_thread() {
  const std::lock_guard lock(*mutex_);
  const auto thread = static_cast<std::size_t>(omp_get_thread_num());
  if (lists_.size() <= thread) lists_.resize(thread + 1);
  return lists_[thread];
}

void MigrantLists::clear() {
  for (auto& list : lists_) list.clear();
}

std::size_t MigrantLists::bytes() const {
  std::size_t n = 0;
  for (const auto& list : lists_) n += list.capacity() * sizeof(Migrant);
  return n;
}

}  // namespace mpm
