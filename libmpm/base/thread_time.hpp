#pragma once
/// The computing time of a thread.

#include <time.h>

namespace mpm {

/// Computing time of the calling thread, s. Unlike wall time it does not grow while other programs have the core.
inline double thread_seconds() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace mpm
