#pragma once
/// Measured times: the computing time of a thread, and wall time.

#include <chrono>
#include <ctime>

namespace mpm {

/// Computing time of the calling thread, s. Unlike wall time it does not grow while other programs have the core.
inline double thread_seconds() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Wall time since an instant, s.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace mpm
