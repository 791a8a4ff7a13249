#pragma once
/// What a rank and its blocks cost in computing time, and when blocks move to other ranks to distribute the work evenly.
///
/// The time for the motion and the stresses of a block's particles is measured block by block. What else a rank computes (particles to the
/// grid, walls, contact with an obstacle, sorting) is measured for all its blocks together, and shared among them in proportion. Contact
/// concerns a few blocks only, which this does not know; but when blocks have left a rank that takes too long, its other blocks are found
/// to cost more, until all ranks take equally long.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "libmpm/base/process.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

/// Processor time of the calling thread in a step, without waiting. A rank that waits keeps its core busy.
class StepClock {
 public:
  /// At the beginning of a step.
  void start() {
    start_ = thread_seconds();
    waited_ = 0.0;
  }
  /// At its end. @returns the computing time since start(), s; nothing if that was not called
  std::optional<double> stop() {
    if (!start_) return std::nullopt;
    const double computed = thread_seconds() - *start_ - waited_;
    start_.reset();
    return computed;
  }

  /// From its creation to its end the rank waits.
  class Waiting {
   public:
    /// @param sum  the elapsed time is added to it, s
    Waiting(StepClock& clock, double& sum) : clock_(clock), sum_(sum) {}
    ~Waiting() {
      sum_ += std::chrono::duration<double>(Elapsed::now() - elapsed_).count();
      clock_.waited_ += thread_seconds() - thread_;
    }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;

   private:
    using Elapsed = std::chrono::steady_clock;
    StepClock& clock_;
    double& sum_;
    Elapsed::time_point elapsed_ = Elapsed::now();
    double thread_ = thread_seconds();
  };

 private:
  std::optional<double> start_;
  double waited_ = 0.0;
};

/// Computing time of a step for each particle, by block.
class BlockCosts {
 public:
  /// Makes room. @param index_end  Grid::index_end()
  void reserve(std::size_t index_end);
  /// Notes what a block's particles took. Threads may note different blocks at the same time. @param time  s
  void note(const Block& block, std::int32_t number, int particles, double time) noexcept;
  /// Notes what a whole step took on this rank. @param time  computing time of all threads, without waiting, s
  /// @param expected  sum of of_occupied_blocks(), s
  void note_step(double time, double expected);
  /// Computing time for each occupied block, s. A block that has not been measured takes as long as the measured ones do for as many
  /// particles.
  [[nodiscard]] std::vector<double> of_occupied_blocks(const Grid& grid) const;

 private:
  struct Measured {
    Index3 block{};     ///< the number may belong to another block by now
    double cost = 0.0;  ///< s for each particle; 0: not measured
  };
  std::vector<Measured> measured_;  ///< by number of block
  double whole_ = 1.0;              ///< time of a step over the sum of the measured times
};

/// When new cuts of the curve through the blocks are tried, and when they are taken.
struct Balancing {
  double threshold = 1.05;  ///< new cuts are tried if largest cost / mean cost of a rank exceeds this
  double gain = 0.02;       ///< new cuts are taken if they lower the largest cost by this fraction
  int interval = 50;        ///< fewest steps between two trials
  int longest = 1600;       ///< after a trial without gain the interval doubles, up to this number of steps
  int forced = 0;           ///< for tests: if above 0, new and uneven cuts every so many steps
};

/// How evenly the work is distributed over the ranks.
struct Evenness {
  std::size_t particles = 0;  ///< of all ranks
  double cost = 0.0;          ///< computing time of all ranks for a step, s
  double largest = 0.0;       ///< that of the rank with most, s
};

/// Decides about trials of new cuts. All ranks have the same inputs and decide alike.
class BalancingTrials {
 public:
  /// @param ranks  their number
  BalancingTrials(const Balancing& balancing, int ranks)
      : balancing_(balancing), ranks_(ranks), wait_(static_cast<std::uint64_t>(balancing.interval)) {}

  /// Whether new cuts should be tried now. @param now  empty before the first step, which makes the first cuts
  [[nodiscard]] bool due(std::uint64_t step, const std::optional<Evenness>& now) const {
    if (balancing_.forced > 0) return step % static_cast<std::uint64_t>(balancing_.forced) == 0;
    if (!now) return true;
    return step - tried_at_ >= wait_ && now->largest * ranks_ > balancing_.threshold * now->cost;
  }
  /// Whether new cuts should be taken. @param before,after  largest cost of a rank with the present cuts and with the new ones
  [[nodiscard]] bool worthwhile(double before, double after) const {
    return balancing_.forced > 0 || after <= (1.0 - balancing_.gain) * before;
  }
  /// After a trial. @param taken  whether the new cuts were taken. If not, a block or joined blocks are too large for an even distribution:
  /// the next trials, each of which collects the costs of all blocks, come later and later
  void note(std::uint64_t step, bool taken) {
    const auto shortest = static_cast<std::uint64_t>(balancing_.interval), longest = static_cast<std::uint64_t>(balancing_.longest);
    tried_at_ = step;
    wait_ = taken ? shortest : wait_ < longest / 2 ? 2 * wait_ : longest;
  }

 private:
  Balancing balancing_;
  int ranks_;
  std::uint64_t tried_at_ = 0, wait_;
};

}  // namespace mpm
