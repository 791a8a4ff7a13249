#include "libmpm/parallel/ownership.hpp"

#include <algorithm>

#include "libmpm/parallel/block_message.hpp"

namespace mpm {

namespace {

constexpr std::size_t particles_of_a_round = std::size_t{1} << 16;  ///< sent at once by a rank when blocks move: 13 MB

}  // namespace

bool Ownership::at_border(const Index3& block) const {
  for (int n = 0; n < 27; ++n) {
    if (!owns(neighbour_of(block, n))) return true;
  }
  return false;
}

void Ownership::cut(const JoinedBlocks& joined, std::span<const BlockHead> heads) {
  partition_.join(joined);
  std::vector<Load> all;
  for (const BlockHead& head : heads) all.push_back({partition_.key(head.block), static_cast<double>(head.count)});
  Message cuts;
  const std::vector<double> shares(static_cast<std::size_t>(transport_.size()), 1.0);
  if (transport_.rank() == 0) put(cuts, std::span<const std::uint64_t>(Partition::cut(std::move(all), shares)));
  transport_.broadcast(cuts);
  partition_.set_cuts(MessageReader(cuts).values<std::uint64_t>());
}

bool Ownership::renew(Grid& grid, const JoinedBlocks& joined, const BlockCosts& costs, const std::optional<Evenness>& now) {
  Partition wanted = partition_;
  wanted.join(joined);
  if (trials_.due(steps_, now)) {
    wanted.set_cuts(better_cuts(grid, costs, wanted));
    trials_.note(steps_, !std::ranges::equal(wanted.cuts(), partition_.cuts()));
  }
  ++steps_;
  if (now && wanted == partition_) return false;
  move_blocks(grid, wanted);
  return true;
}

/// Loads of the blocks of all ranks; empty except on the first rank.
std::vector<Load> Ownership::loads(const Grid& grid, const BlockCosts& costs, const Partition& partition) {
  Message mine;
  const auto blocks = grid.occupied_blocks();
  const std::vector<double> cost = costs.of_occupied_blocks(grid);
  for (std::size_t i = 0; i < blocks.size(); ++i) put(mine, Load{partition.key(grid.block(blocks[i]).coordinate), cost[i]});
  std::vector<Load> all;
  for (const Message& message : transport_.gather(std::move(mine))) {
    const auto some = MessageReader(message).values<Load>();
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

/// Cuts that make the load even, or the present cuts if the gain is too small; the same on all ranks.
std::vector<std::uint64_t> Ownership::better_cuts(const Grid& grid, const BlockCosts& costs, const Partition& wanted) {
  const BlockCosts nothing_measured;  // costs are numbers of particles: tests repeat the same moves
  const std::vector<Load> all = loads(grid, balancing_.forced > 0 ? nothing_measured : costs, wanted);
  Message cuts;
  if (transport_.rank() == 0) {
    std::vector<double> weights(static_cast<std::size_t>(transport_.size()), 1.0);
    if (balancing_.forced > 0) {
      const auto turn = static_cast<std::size_t>(steps_ / static_cast<std::uint64_t>(balancing_.forced));
      for (std::size_t r = 0; r < weights.size(); ++r) weights[r] += static_cast<double>((r + turn) % 3);
    }
    const auto better = Partition::cut(all, weights);
    const bool take = trials_.worthwhile(Partition::largest_cost(all, wanted.cuts()), Partition::largest_cost(all, better));
    put(cuts, take ? std::span<const std::uint64_t>(better) : wanted.cuts());
  }
  transport_.broadcast(cuts);
  return MessageReader(cuts).values<std::uint64_t>();
}

/// In rounds, to bound the size of the messages: at the start the first rank holds all particles.
void Ownership::move_blocks(Grid& grid, const Partition& to) {
  std::vector<std::int32_t> leaving;
  for (const auto b : grid.occupied_blocks()) {
    if (to.owner(grid.block(b).coordinate) != transport_.rank()) leaving.push_back(b);
  }
  partition_ = to;
  grid.ask_owners();
  std::size_t next = 0;
  for (double more[1] = {1.0}; more[0] > 0.0;) {
    Messages out;
    for (std::size_t count = 0; next < leaving.size() && count < particles_of_a_round; ++next) {
      const Block& block = grid.block(leaving[next]);
      count += static_cast<std::size_t>(block.particles.count());
      put_block(out[to.owner(block.coordinate)], block);
      grid.clear(leaving[next]);
    }
    for (const auto& [rank, message] : transport_.exchange(std::move(out))) get_blocks(message, grid);
    more[0] = next < leaving.size() ? 1.0 : 0.0;
    transport_.maximum(more);
  }
}

}  // namespace mpm
