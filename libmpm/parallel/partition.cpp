#include "libmpm/parallel/partition.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "libmpm/core/grid.hpp"

namespace mpm {

namespace {

constexpr int bits_of_coordinate = 21;

/// Zero bits between the 21 bits of a number. @param zeros  0 to 2: how many
std::uint64_t spread_bits(std::uint64_t bits, int zeros) {
  // groups of 16, 8, 4, 2 and 1 bits, the gaps between which are wide enough
  static constexpr std::uint64_t groups[2][5] = {
      {0x0000FFFF0000FFFF, 0x00FF00FF00FF00FF, 0x0F0F0F0F0F0F0F0F, 0x3333333333333333, 0x5555555555555555},
      {0x001F00000000FFFF, 0x001F0000FF0000FF, 0x100F00F00F00F00F, 0x10C30C30C30C30C3, 0x1249249249249249}};
  if (zeros == 0) return bits;
  for (int n = 0; n < 5; ++n) bits = (bits | bits << (zeros * (16 >> n))) & groups[zeros - 1][n];
  return bits;
}

/// The key above `low` and at most `high` that ends with most zero bits. With layers the cut is then a plane, also where there are no
/// particles, and with a Morton curve it follows the faces of the largest cubes.
std::uint64_t roundest_key(std::uint64_t low, std::uint64_t high) {
  const int below = static_cast<int>(std::bit_width(low ^ high)) - 1;  // the highest bit in which they differ
  return high >> below << below;
}

int rank_of(std::span<const std::uint64_t> cuts, std::uint64_t key) {
  return static_cast<int>(std::ranges::upper_bound(cuts, key) - cuts.begin());
}

}  // namespace

std::uint64_t Curve::key(const Index3& block) const {
  constexpr std::int32_t middle = 1 << (bits_of_coordinate - 1);
  std::uint64_t key = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto bits = static_cast<std::uint64_t>(block[axis] + middle) & ((std::uint64_t{1} << bits_of_coordinate) - 1);
    key |= spread_bits(bits, spacing[axis] - 1) << shift[axis];
  }
  return key;
}

std::vector<Curve> Curve::all() {
  constexpr int n = bits_of_coordinate;
  return {morton(),
          {{2, 2, 1}, {n, n + 1, 0}},
          {{2, 1, 2}, {n, 0, n + 1}},
          {{1, 2, 2}, {0, n, n + 1}},
          {{1, 1, 1}, {2 * n, n, 0}},
          {{1, 1, 1}, {n, 2 * n, 0}},
          {{1, 1, 1}, {2 * n, 0, n}},
          {{1, 1, 1}, {n, 0, 2 * n}},
          {{1, 1, 1}, {0, 2 * n, n}},
          {{1, 1, 1}, {0, n, 2 * n}}};
}

Partition::Partition(int ranks) : cuts_(static_cast<std::size_t>(ranks - 1), std::numeric_limits<std::uint64_t>::max()) {}

std::uint64_t Partition::key(const Index3& block) const { return curve_.key(joined_.representative(block)); }

int Partition::owner(const Index3& block) const { return rank_of(cuts_, key(block)); }

bool Partition::at_border(const Index3& block) const {
  const int own = owner(block);
  for (int n = 0; n < 27; ++n) {
    if (owner(neighbour_of(block, n)) != own) return true;
  }
  return false;
}

void Partition::cut(std::span<const Load> loads, std::span<const double> weights) {
  std::vector<std::pair<std::uint64_t, double>> along;  // key and cost
  double all = 0.0, all_weights = 0.0;
  for (const Load& l : loads) along.emplace_back(key(l.block), l.cost);
  std::ranges::stable_sort(along, {}, &std::pair<std::uint64_t, double>::first);
  for (const auto& [key, cost] : along) all += cost;
  for (const double w : weights) all_weights += w;
  cuts_.clear();
  double wanted = 0.0, before = 0.0;
  std::size_t i = 0;
  for (std::size_t r = 0; r + 1 < weights.size(); ++r) {
    wanted += all * weights[r] / all_weights;
    while (i < along.size()) {  // a piece goes to the rank that gets more than half of it
      std::size_t end = i;
      double piece = 0.0;
      for (; end < along.size() && along[end].first == along[i].first; ++end) piece += along[end].second;
      if (before + 0.5 * piece > wanted) break;
      before += piece;
      i = end;
    }
    const bool between = 0 < i && i < along.size();
    cuts_.push_back(between            ? roundest_key(along[i - 1].first, along[i].first)
                    : i < along.size() ? along[i].first
                                       : std::numeric_limits<std::uint64_t>::max());
  }
}

void Partition::choose_curve(std::span<const Load> loads, std::span<const double> weights) {
  constexpr double at_border = 0.2;   // two ranks with 62 % of their blocks at borders computed 13 % more than one (avalanche_fr3)
  constexpr std::size_t most = 2048;  // blocks that are looked at: some 0.1 s
  std::vector<Load> some;
  const std::size_t step = loads.size() / most + 1;
  for (std::size_t i = 0; i < loads.size(); i += step) some.push_back(loads[i]);
  Partition best = *this;
  double least = std::numeric_limits<double>::infinity();
  for (const Curve& curve : Curve::all()) {
    curve_ = curve;
    cut(loads, weights);
    const double cost = largest_cost(some, at_border);
    if (cost < least) best = *this, least = cost;
  }
  *this = best;
}

double Partition::largest_cost(std::span<const Load> loads, double at_border_too) const {
  std::vector<double> cost(cuts_.size() + 1, 0.0);
  for (const Load& l : loads) {
    const double more = at_border_too > 0.0 && at_border(l.block) ? at_border_too * l.cost : 0.0;
    cost[static_cast<std::size_t>(owner(l.block))] += l.cost + more;
  }
  return *std::ranges::max_element(cost);
}

}  // namespace mpm
