#include "libmpm/parallel/halo_plan.hpp"

#include <algorithm>

namespace mpm {

namespace {

/// The nodes of the block at forward offset k (forward_slots) that a block's particles touch.
constexpr Extent touched(int k) { return {(k & 1) != 0 ? 2 : 4, (k & 2) != 0 ? 2 : 4, (k & 4) != 0 ? 2 : 4}; }

constexpr std::size_t forward(int k) { return static_cast<std::size_t>(forward_slots[static_cast<std::size_t>(k)]); }

/// For each rank and block, the nodes that the rank needs: the smallest extent that covers what its blocks touch.
using Needs = std::map<int, std::map<std::uint64_t, SentNodes>>;

void add_need(Needs& needs, int rank, std::uint64_t key, std::int32_t block, const Extent& extent) {
  Extent& all = needs[rank].try_emplace(key, SentNodes{block, extent}).first->second.extent;
  for (std::size_t axis = 0; axis < 3; ++axis) all[axis] = std::max(all[axis], extent[axis]);
}

/// In the order of the blocks on the Morton curve, which both sides know.
NodesByRank in_order(const Needs& needs) {
  NodesByRank all;
  for (const auto& [rank, blocks] : needs) {
    for (const auto& [key, nodes] : blocks) all[rank].push_back(nodes);
  }
  return all;
}

}  // namespace

void HaloPlan::renew(Grid& grid, const Ownership& ownership, const Borders& theirs) {
  for (const auto& [block, targets] : targets_) grid.block(block).parts = nullptr;
  targets_.clear();
  grid.return_lent();
  parts_to.clear();
  parts_from.clear();
  shared.clear();
  plan_own_parts(grid, ownership);
  plan_shared(grid, ownership, theirs);
  for (const auto& [block, targets] : targets_) grid.block(block).parts = &targets;
}

/// Contributions of own blocks to blocks of other ranks, in the order of the blocks and of their neighbours.
void HaloPlan::plan_own_parts(Grid& grid, const Ownership& ownership) {
  Needs needs;
  for (const auto b : grid.occupied_blocks()) {
    const Block& block = grid.block(b);
    if (!block.at_border) continue;
    for (int k = 1; k < 8; ++k) {
      const std::int32_t to = block.neighbour[forward(k)];
      if (grid.block(to).owned) continue;
      const int rank = ownership.owner(grid.block(to).coordinate);
      const std::int32_t lent = grid.lend_nodes();
      targets_.try_emplace(b, grid.block(b).neighbour).first->second[forward(k)] = lent;
      parts_to[rank].push_back({lent, touched(k)});
      add_need(needs, rank, morton_key(grid.block(to).coordinate), to, touched(k));
    }
  }
  nodes_from = in_order(needs);
}

/// Own blocks whose nodes get parts from other ranks: all parts are summed afterwards, in the order of the colours.
void HaloPlan::plan_shared(Grid& grid, const Ownership& ownership, const Borders& theirs) {
  Needs needs;
  std::map<std::int32_t, std::vector<Summand>> summands;
  for (const auto& [rank, blocks] : theirs) {
    for (const Index3& block : blocks) {
      for (int k = 1; k < 8; ++k) {
        const Index3 coordinate = neighbour_of(block, forward_slots[static_cast<std::size_t>(k)]);
        if (!ownership.owns(coordinate)) continue;
        const std::int32_t to = grid.find(coordinate);
        std::size_t& before = parts_from[rank];
        summands[to].push_back({colour_of(block), touched(k), rank, no_block, before});
        before += nodes_in(touched(k));
        add_need(needs, rank, morton_key(coordinate), to, touched(k));
      }
    }
  }
  for (auto& [to, all] : summands) {
    for (int k = 0; k < 8; ++k) {
      const std::int32_t from = grid.block(to).neighbour[26 - forward(k)];
      if (from == no_block || !grid.block(from).owned || grid.block(from).particles.count() == 0) continue;
      const std::int32_t lent = grid.lend_nodes();
      targets_.try_emplace(from, grid.block(from).neighbour).first->second[forward(k)] = lent;
      all.push_back({colour_of(grid.block(from).coordinate), touched(k), Summand::own, lent, 0});
    }
    std::ranges::sort(all, {}, &Summand::colour);  // each colour comes once
    shared.push_back({to, std::move(all)});
  }
  nodes_to = in_order(needs);
}

}  // namespace mpm
