#include "libmpm/parallel/halo_exchange.hpp"

#include <cstring>
#include <utility>

#include "libmpm/base/error.hpp"

namespace mpm {

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
