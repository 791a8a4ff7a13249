#include "libmpm/parallel/partition.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace mpm {

namespace {

/// Two zero bits between the 21 bits of a number.
std::uint64_t spread_bits(std::uint64_t v) {
  v = (v | v << 32) & 0x1F00000000FFFFULL;
  v = (v | v << 16) & 0x1F0000FF0000FFULL;
  v = (v | v << 8) & 0x100F00F00F00F00FULL;
  v = (v | v << 4) & 0x10C30C30C30C30C3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

int rank_of(std::span<const std::uint64_t> cuts, std::uint64_t key) {
  return static_cast<int>(std::ranges::upper_bound(cuts, key) - cuts.begin());
}

}  // namespace

std::uint64_t morton_key(const Index3& block) {
  constexpr std::int32_t middle = 1 << 20;
  const auto bits = [&](std::size_t axis) { return spread_bits(static_cast<std::uint64_t>(block[axis] + middle) & 0x1FFFFFU); };
  return bits(0) | bits(1) << 1 | bits(2) << 2;
}

Partition::Partition(int ranks) : cuts_(static_cast<std::size_t>(ranks - 1), std::numeric_limits<std::uint64_t>::max()) {}

std::uint64_t Partition::key(const Index3& block) const { return morton_key(joined_.representative(block)); }

int Partition::owner(const Index3& block) const { return rank_of(cuts_, key(block)); }

std::vector<std::uint64_t> Partition::cut(std::vector<Load> loads, std::span<const double> weights) {
  std::ranges::sort(loads, {}, &Load::key);
  const double all = std::accumulate(loads.begin(), loads.end(), 0.0, [](double sum, const Load& l) { return sum + l.cost; });
  const double all_weights = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<std::uint64_t> cuts;
  double wanted = 0.0, before = 0.0;
  std::size_t i = 0;
  for (std::size_t r = 0; r + 1 < weights.size(); ++r) {
    wanted += all * weights[r] / all_weights;
    while (i < loads.size()) {  // a piece goes to the rank that gets more than half of it
      std::size_t end = i;
      double piece = 0.0;
      for (; end < loads.size() && loads[end].key == loads[i].key; ++end) piece += loads[end].cost;
      if (before + 0.5 * piece > wanted) break;
      before += piece;
      i = end;
    }
    cuts.push_back(i < loads.size() ? loads[i].key : std::numeric_limits<std::uint64_t>::max());
  }
  return cuts;
}

double Partition::largest_cost(std::span<const Load> loads, std::span<const std::uint64_t> cuts) {
  std::vector<double> cost(cuts.size() + 1, 0.0);
  for (const Load& l : loads) cost[static_cast<std::size_t>(rank_of(cuts, l.key))] += l.cost;
  return *std::ranges::max_element(cost);
}

}  // namespace mpm
