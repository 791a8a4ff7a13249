#include "libmpm/driver/threads.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <latch>
#include <system_error>
#include <thread>
#include <vector>

#include "libmpm/base/error.hpp"

namespace mpm {

void start_threads(int threads) {
  if (threads > 0) omp_set_num_threads(threads);
  const int wanted = omp_get_max_threads();
  std::vector<std::thread> trial;
  std::latch all(wanted);
  try {
    for (int i = 1; i < wanted; ++i) trial.emplace_back([&all] { all.arrive_and_wait(); });
    all.count_down();
  } catch (const std::system_error& error) {
    all.count_down(wanted - static_cast<std::ptrdiff_t>(trial.size()));
    for (std::thread& t : trial) t.join();
    throw Error(ExitCode::internal,
                fmt::format("cannot start {} threads: {}; take fewer with --threads, or raise the limits of memory (ulimit -v) and of "
                            "processes (ulimit -u)",
                            wanted, error.what()));
  }
  for (std::thread& t : trial) t.join();
#pragma omp parallel
  {}
}

void use_short_spin(char** argv) {
  constexpr const char* variable = "GOMP_SPINCOUNT";
  if (std::getenv(variable) != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);  // the link's own name would show in `ps`
  if (error || setenv(variable, short_spin.data(), 0) != 0) return;
  execv(program.c_str(), argv);  // the new process finds the variable set, and continues
}

int most_threads() {
  constexpr int for_each = 4;
  return for_each * std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace mpm
