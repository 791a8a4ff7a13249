#include "libmpm/driver/threads.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <sched.h>
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

namespace {

/// Lets this thread run on the processors of all places. With OMP_PROC_BIND or GOMP_CPU_AFFINITY the OpenMP runtime has bound it to one of
/// them, and a program that it starts would have only that one.
void unbind() {
  std::vector<int> processors;
  for (int place = 0; place < omp_get_num_places(); ++place) {
    std::vector<int> some(static_cast<std::size_t>(omp_get_place_num_procs(place)));
    omp_get_place_proc_ids(place, some.data());
    processors.insert(processors.end(), some.begin(), some.end());
  }
  if (processors.empty()) return;
  const auto count = static_cast<std::size_t>(*std::ranges::max_element(processors)) + 1, size = CPU_ALLOC_SIZE(count);
  cpu_set_t* const set = CPU_ALLOC(count);
  if (set == nullptr) return;
  CPU_ZERO_S(size, set);
  for (const int processor : processors) CPU_SET_S(static_cast<std::size_t>(processor), size, set);
  sched_setaffinity(0, size, set);
  CPU_FREE(set);
}

}  // namespace

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
  unbind();
  execv(program.c_str(), argv);  // the new process finds the variable set, and continues
}

std::string limit_threads() {
  const int wanted = omp_get_max_threads(), most = most_threads();
  if (wanted <= most) return {};
  omp_set_num_threads(most);
  return fmt::format("warning: OMP_NUM_THREADS asks for {} threads; {}, the most on this machine, are used", wanted, most);
}

int most_threads() {
  constexpr int for_each = 4;
  return for_each * std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace mpm
