#include "libmpm/parallel/ownership.hpp"

#include <algorithm>

#include "libmpm/parallel/block_message.hpp"

namespace mpm {

namespace {

constexpr std::size_t particles_of_a_round = std::size_t{1} << 16;  ///< sent at once by a rank when blocks move: 13 MB

}  // namespace

bool Ownership::at_border(const Index3& block) const { return !owns(block) || partition_.at_border(block); }

/// Gives all ranks the partition of the first rank.
void Ownership::share(Partition& partition) const {
  Message message;
  if (transport_.rank() == 0) {
    put(message, partition.curve());
    put(message, partition.cuts());
  }
  transport_.broadcast(message);
  MessageReader reader(message);
  const auto curve = reader.get<Curve>();
  partition.set(curve, reader.values<std::uint64_t>());
}

void Ownership::cut(const JoinedBlocks& joined, std::span<const BlockHead> heads) {
  partition_.join(joined);
  std::vector<Load> all;
  for (const BlockHead& head : heads) all.push_back({head.block, static_cast<double>(head.count)});
  const std::vector<double> equal(static_cast<std::size_t>(transport_.size()), 1.0);
  if (transport_.rank() == 0) partition_.choose_curve(all, equal);
  share(partition_);
}

bool Ownership::renew(Grid& grid, const JoinedBlocks& joined, const BlockCosts& costs, const std::optional<Evenness>& now) {
  Partition wanted = partition_;
  wanted.join(joined);
  if (trials_.due(steps_, now)) {
    improve_cuts(grid, costs, wanted);
    trials_.note(steps_, !std::ranges::equal(wanted.cuts(), partition_.cuts()));
  }
  ++steps_;
  if (now && wanted == partition_) return false;
  move_blocks(grid, wanted);
  return true;
}

/// Loads of the blocks of all ranks; empty except on the first rank.
std::vector<Load> Ownership::loads(const Grid& grid, const BlockCosts& costs) {
  Message mine;
  const auto blocks = grid.occupied_blocks();
  const std::vector<double> cost = costs.of_occupied_blocks(grid);
  for (std::size_t i = 0; i < blocks.size(); ++i) put(mine, Load{grid.block(blocks[i]).coordinate, cost[i]});
  std::vector<Load> all;
  for (const Message& message : transport_.gather(std::move(mine))) {
    const auto some = MessageReader(message).values<Load>();
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

/// Moves the cuts so that the load becomes even, unless the gain is too small. Alike on all ranks.
void Ownership::improve_cuts(const Grid& grid, const BlockCosts& costs, Partition& partition) {
  const BlockCosts nothing_measured;  // costs are numbers of particles: tests repeat the same moves
  const std::vector<Load> all = loads(grid, balancing_.forced > 0 ? nothing_measured : costs);
  if (transport_.rank() == 0) {
    std::vector<double> weights(static_cast<std::size_t>(transport_.size()), 1.0);
    if (balancing_.forced > 0) {
      const auto turn = static_cast<std::size_t>(steps_ / static_cast<std::uint64_t>(balancing_.forced));
      for (std::size_t r = 0; r < weights.size(); ++r) weights[r] += static_cast<double>((r + turn) % 3);
    }
    Partition better = partition;
    better.cut(all, weights);
    if (trials_.worthwhile(partition.largest_cost(all), better.largest_cost(all))) partition = better;
  }
  share(partition);
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
