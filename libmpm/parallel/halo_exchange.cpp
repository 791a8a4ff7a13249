#include "libmpm/parallel/halo_exchange.hpp"

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "libmpm/base/error.hpp"

namespace mpm {

// ---- Which nodes, and their places in the messages -------------------------------------------------------------------------------------

namespace {

/// The nodes of the block at forward offset k (forward_directions) that a block's particles touch.
constexpr Extent touched(int k) { return {(k & 1) != 0 ? 2 : 4, (k & 2) != 0 ? 2 : 4, (k & 4) != 0 ? 2 : 4}; }

constexpr std::size_t forward(int k) { return static_cast<std::size_t>(forward_directions[static_cast<std::size_t>(k)]); }

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
  for (const auto& [block, targets] : targets_) {
    grid.block(block).buffers = nullptr;
    grid.block(block).outer = false;
  }
  targets_.clear();
  grid.free_buffers();
  find_touches(grid, ownership, theirs);
  for (const auto& [block, targets] : targets_) grid.block(block).buffers = &targets;
  all_ = layout_of([](const Index3&) { return true; });
  some_.reset();
}

const HaloLayout& HaloPlan::of(const BlockChoice& givers) {
  if (!givers) return all_;
  if (!some_) some_ = layout_of(givers);
  return *some_;
}

/// In an order that both sides know: of the blocks with particles, and of their neighbours.
void HaloPlan::find_touches(Grid& grid, const Ownership& ownership, const Borders& theirs) {
  out_.clear();
  in_.clear();
  own_.clear();
  const auto new_buffer = [&](std::int32_t from, int k) {
    const std::int32_t buffer = grid.new_buffer();
    return targets_.try_emplace(from, grid.block(from).neighbour).first->second[forward(k)] = buffer;
  };
  std::set<std::int32_t> shared;
  for (const auto b : grid.occupied_blocks()) {
    if (!grid.block(b).at_border) continue;
    for (int k = 1; k < 8; ++k) {
      const std::int32_t to = grid.block(b).neighbour[forward(k)];
      if (grid.block(to).owned) continue;
      grid.block(b).outer = true;
      out_.push_back({grid.block(b).coordinate, k, to, ownership.owner(grid.block(to).coordinate), new_buffer(b, k)});
    }
    for (int k = 0; k < 8 && grid.block(b).outer; ++k) {
      const std::int32_t to = grid.block(b).neighbour[forward(k)];
      if (grid.block(to).owned) shared.insert(to);
    }
  }
  for (const auto& [rank, blocks] : theirs) {
    for (const Index3& giver : blocks) {
      for (int k = 1; k < 8; ++k) {
        const Index3 coordinate = neighbour_of(giver, forward_directions[static_cast<std::size_t>(k)]);
        if (!ownership.owns(coordinate)) continue;
        in_.push_back({giver, k, grid.find(coordinate), rank, no_block});
        shared.insert(in_.back().to);
      }
    }
  }
  for (const auto to : shared) {
    for (int k = 0; k < 8; ++k) {
      const std::int32_t from = grid.block(to).neighbour[26 - forward(k)];
      if (from == no_block || !grid.block(from).owned || grid.block(from).particles.count() == 0) continue;
      own_.push_back({grid.block(from).coordinate, k, to, Summand::own, new_buffer(from, k)});
    }
  }
}

HaloLayout HaloPlan::layout_of(const BlockChoice& givers) const {
  HaloLayout layout;
  Needs mine, theirs;
  std::map<std::int32_t, std::vector<Summand>> summands;
  for (const Touch& t : out_) {
    if (!givers(t.giver)) continue;
    layout.parts_to[t.rank].push_back({t.buffer, touched(t.k)});
    add_need(mine, t.rank, morton_key(neighbour_of(t.giver, forward_directions[static_cast<std::size_t>(t.k)])), t.to, touched(t.k));
  }
  for (const Touch& t : in_) {
    if (!givers(t.giver)) continue;
    std::size_t& before = layout.parts_from[t.rank];
    summands[t.to].push_back({colour_of(t.giver), touched(t.k), t.rank, no_block, before});
    before += nodes_in(touched(t.k));
    add_need(theirs, t.rank, morton_key(neighbour_of(t.giver, forward_directions[static_cast<std::size_t>(t.k)])), t.to, touched(t.k));
  }
  for (const Touch& t : own_) {
    if (givers(t.giver)) summands[t.to].push_back({colour_of(t.giver), touched(t.k), Summand::own, t.buffer, 0});
  }
  layout.nodes_from = in_order(mine);
  layout.nodes_to = in_order(theirs);
  for (auto& [to, all] : summands) {
    std::ranges::sort(all, {}, &Summand::colour);  // each colour comes once
    layout.shared.push_back({to, std::move(all)});
  }
  const auto whole = [](const SharedBlock& s) {
    return std::ranges::all_of(s.summands, [](const Summand& part) { return part.from == Summand::own; });
  };
  layout.complete = static_cast<std::size_t>(std::partition(layout.shared.begin(), layout.shared.end(), whole) - layout.shared.begin());
  return layout;
}

// ---- The messages ----------------------------------------------------------------------------------------------------------------------

namespace {

/// Calls f(first node, number) for the rows of some nodes of a block.
template <class F>
void for_each_row(const Extent& extent, F&& f) {
  for (int z = 0; z < extent[2]; ++z) {
    for (int y = 0; y < extent[1]; ++y) f(block_edge * y + block_edge * block_edge * z, extent[0]);
  }
}

void put_nodes(Message& message, const NodeBlock& nodes, const Extent& extent) {
  for_each_row(extent, [&](int first, int count) {
    const auto* bytes = reinterpret_cast<const std::byte*>(nodes.node + first);
    put(message, std::span(bytes, static_cast<std::size_t>(count) * sizeof(Node)));
  });
}

/// Replaces nodes by those of a message. @returns what follows them in the message
const std::byte* get_nodes(const std::byte* bytes, NodeBlock& nodes, const Extent& extent) {
  for_each_row(extent, [&](int first, int count) {
    const std::size_t size = static_cast<std::size_t>(count) * sizeof(Node);
    std::memcpy(static_cast<void*>(nodes.node + first), bytes, size);
    bytes += size;
  });
  return bytes;
}

Messages packed(const NodesByRank& wanted, const NodeFields& fields) {
  Messages out;
  for (const auto& [rank, all] : wanted) {
    Message& message = out[rank];
    for (const SentNodes& sent : all) {
      for (int f = 0; f < fields.count(); ++f) put_nodes(message, fields.of(sent.nodes, f), sent.extent);
    }
  }
  return out;
}

std::size_t total_nodes(const std::vector<SentNodes>& all) {
  std::size_t nodes = 0;
  for (const SentNodes& sent : all) nodes += nodes_in(sent.extent);
  return nodes;
}

void check_size(const Message& message, std::size_t expected) {
  if (message.size() != expected) throw Error(ExitCode::internal, "internal error: ranks disagree about the blocks at their border");
}

/// Sums the nodes of some shared blocks. @param in  what the other ranks contribute; may be empty where only own parts are added
void add_shared(std::span<const SharedBlock> shared, const Messages& in, const NodeFields& fields) {
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < shared.size(); ++i) {
    for (int f = 0; f < fields.count(); ++f) {
      NodeBlock& all = fields.of(shared[i].block, f);
      for (const Summand& part : shared[i].summands) {
        NodeBlock received;
        const NodeBlock* from = &received;
        if (part.from == Summand::own) {
          from = &fields.of(part.nodes, f);
        } else {
          const std::size_t first = fields.bytes(part.first) + static_cast<std::size_t>(f) * nodes_in(part.extent) * sizeof(Node);
          get_nodes(in.find(part.from)->second.data() + first, received, part.extent);
        }
        for_each_row(part.extent, [&](int first, int nodes) {
          for (int n = first; n < first + nodes; ++n) all.node[n] += from->node[n];
        });
      }
    }
  }
}

}  // namespace

void HaloExchange::count(const Messages& out, std::uint64_t& bytes) {
  counts_.messages += out.size();
  for (const auto& [rank, message] : out) bytes += message.size();
}

void HaloExchange::send_parts(const NodeFields& fields, const HaloLayout& layout) {
  parts_ = &layout;
  Messages out = packed(layout.parts_to, fields);
  count(out, counts_.part_bytes);
  std::map<int, std::size_t> sizes;
  for (const auto& [rank, nodes] : layout.parts_from) sizes[rank] = fields.bytes(nodes);
  transport_.start(MessageKind::parts, std::move(out), sizes);
}

void HaloExchange::add_parts(const NodeFields& fields) {
  const std::span shared(parts_->shared);
  add_shared(shared.first(parts_->complete), {}, fields);
  Messages in;
  {
    const StepClock::Waiting waiting(clock_, counts_.part_wait);
    in = transport_.finish(MessageKind::parts);
  }
  for (const auto& [rank, nodes] : parts_->parts_from) check_size(in.at(rank), fields.bytes(nodes));
  add_shared(shared.subspan(parts_->complete), in, fields);
}

void HaloExchange::send_nodes(const NodeFields& fields, const HaloLayout& layout) {
  nodes_ = &layout;
  Messages out = packed(layout.nodes_to, fields);
  count(out, counts_.node_bytes);
  std::map<int, std::size_t> sizes;
  for (const auto& [rank, all] : layout.nodes_from) sizes[rank] = fields.bytes(total_nodes(all));
  transport_.start(MessageKind::nodes, std::move(out), sizes);
}

void HaloExchange::receive_nodes(const NodeFields& fields) {
  Messages in;
  {
    const StepClock::Waiting waiting(clock_, counts_.node_wait);
    in = transport_.finish(MessageKind::nodes);
  }
  for (const auto& [rank, all] : nodes_->nodes_from) {
    const Message& message = in.at(rank);
    check_size(message, fields.bytes(total_nodes(all)));
    const std::byte* bytes = message.data();
    for (const SentNodes& sent : all) {
      for (int f = 0; f < fields.count(); ++f) bytes = get_nodes(bytes, fields.of(sent.nodes, f), sent.extent);
    }
  }
}

}  // namespace mpm
