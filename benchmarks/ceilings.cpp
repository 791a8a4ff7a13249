#include "ceilings.hpp"

#include <omp.h>
#include <sys/mman.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <new>

#include "libmpm/base/lanes.hpp"

namespace mpm::benchmarks {

namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr int trials = 15;

constexpr auto huge_page = std::align_val_t{std::size_t{2} << 20};
struct Free {
  void operator()(double* p) const { ::operator delete(p, huge_page); }
};

/// Three arrays of 128 MB: more than the part of a last-level cache that one virtual machine has.
double triad(int threads) {
  constexpr long count = 16L << 20;
  constexpr std::size_t bytes = count * sizeof(double);
  // on huge pages like the particles; not initialised: the threads touch their own part first
  const auto array = [] {
    void* memory = ::operator new(bytes, huge_page);
    madvise(memory, bytes, MADV_HUGEPAGE);
    return std::unique_ptr<double[], Free>(static_cast<double*>(memory));
  };
  const auto a = array(), b = array(), c = array();
  double *const pa = a.get(), *const pb = b.get(), *const pc = c.get();
#pragma omp parallel for schedule(static) num_threads(threads)
  for (long i = 0; i < count; ++i) pa[i] = 0.0, pb[i] = 1.0, pc[i] = 2.0;
  double best = 0.0;
  for (int trial = 0; trial < trials; ++trial) {
    const double scale = 3.0 + trial;
    const auto start = Clock::now();
#pragma omp parallel for schedule(static) num_threads(threads)
    for (long i = 0; i < count; ++i) pa[i] = pb[i] + scale * pc[i];
    best = std::max(best, 24.0 * count / seconds_since(start));
  }
  return best;
}

/// Twelve chains of one register each: more than latency times width of the multiply-add units needs. Vectors longer than a register would
/// go through memory.
double multiply_add(int threads) {
  constexpr int chains = 12;
  constexpr long rounds = 4'000'000;
  double best = 0.0;
  for (int trial = 0; trial < trials; ++trial) {
    double sink = 0.0;
    const auto start = Clock::now();
#pragma omp parallel num_threads(threads) reduction(+ : sink)
    {
      DoubleLanes sum[chains];
      for (int i = 0; i < chains; ++i) sum[i] = broadcast<DoubleLanes>(0.01 * i);
      const DoubleLanes factor = broadcast<DoubleLanes>(0.999999 + 1e-9 * trial), addend = broadcast<DoubleLanes>(1e-6);
      for (long n = 0; n < rounds; ++n) {
#pragma GCC unroll 12
        for (int i = 0; i < chains; ++i) sum[i] = sum[i] * factor + addend;
      }
      for (const DoubleLanes& s : sum) {
        for (int i = 0; i < lanes_of<DoubleLanes>; ++i) sink += s[i];
      }
    }
    const double elapsed = seconds_since(start);
    if (sink != 0.0) best = std::max(best, 2.0 * lanes_of<DoubleLanes> * chains * rounds * threads / elapsed);
  }
  return best;
}

}  // namespace

const Ceilings& ceilings(int threads) {
  static std::map<int, Ceilings> measured;
  const auto found = measured.find(threads);
  return found != measured.end() ? found->second : measured.emplace(threads, Ceilings{triad(threads), multiply_add(threads)}).first->second;
}

}  // namespace mpm::benchmarks
