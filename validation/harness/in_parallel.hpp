#pragma once
/// A loop over independent tasks on all threads, which may throw.

#include <cstddef>
#include <exception>

namespace mpm::validation {

/// Runs task(i) for i < count on all threads; the first exception is thrown after the last task.
template <class Task>
void in_parallel(std::size_t count, Task&& task) {
  std::exception_ptr first;
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < count; ++i) {
    try {
      task(i);
    } catch (...) {
#pragma omp critical
      if (!first) first = std::current_exception();
    }
  }
  if (first) std::rethrow_exception(first);
}

}  // namespace mpm::validation
