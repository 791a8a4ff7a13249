#pragma once
/// When blocks move to other ranks to distribute the work evenly.

#include <cstddef>
#include <cstdint>
#include <optional>

namespace mpm {

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
