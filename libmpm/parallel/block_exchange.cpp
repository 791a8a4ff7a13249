#include "libmpm/parallel/block_exchange.hpp"

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/base/thread_time.hpp"
#include "libmpm/core/state.hpp"
#include "libmpm/parallel/block_message.hpp"

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

int fields_of(const Grid& grid) { return grid.keeps_old_nodes() ? 2 : 1; }
/// Accessor nodes_of(block, field): field 0 are the nodes of a block, field 1 the nodes before the update, if the grid keeps them.
auto fields_of_nodes(Grid& grid) {
  return [&grid](std::int32_t block, int field) -> NodeBlock& { return field == 0 ? grid.nodes(block) : grid.old_nodes(block); };
}

/// The same for a field by number of block.
auto nodes_of_field(std::span<NodeBlock> field) {
  return [field](std::int32_t block, int) -> NodeBlock& { return field[static_cast<std::size_t>(block)]; };
}

template <class NodesOf>
Messages packed(const NodesByRank& wanted, int fields, const NodesOf& nodes_of) {
  Messages out;
  for (const auto& [rank, all] : wanted) {
    Message& message = out[rank];
    for (const SentNodes& sent : all) {
      for (int f = 0; f < fields; ++f) put_nodes(message, nodes_of(sent.nodes, f), sent.extent);
    }
  }
  return out;
}

template <class T>
std::vector<int> ranks_in(const std::map<int, T>& map) {
  std::vector<int> ranks;
  for (const auto& [rank, value] : map) ranks.push_back(rank);
  return ranks;
}

using Clock = std::chrono::steady_clock;

std::size_t total_nodes(const std::vector<SentNodes>& all) {
  std::size_t nodes = 0;
  for (const SentNodes& sent : all) nodes += nodes_in(sent.extent);
  return nodes;
}

void check_size(const Message& message, std::size_t expected) {
  if (message.size() != expected) throw Error(ExitCode::internal, "internal error: ranks disagree about the blocks at their border");
}

}  // namespace

/// From its creation to its end a rank waits for others. It keeps its core busy meanwhile.
class BlockExchange::Waiting {
 public:
  /// @param sum  to which the time is added, s
  Waiting(BlockExchange& exchange, double& sum) : exchange_(exchange), sum_(sum) {}
  ~Waiting() {
    sum_ += std::chrono::duration<double>(Clock::now() - start_).count();
    exchange_.step_waited_ += thread_seconds() - thread_start_;
  }
  Waiting(const Waiting&) = delete;
  Waiting& operator=(const Waiting&) = delete;

 private:
  BlockExchange& exchange_;
  double& sum_;
  Clock::time_point start_ = Clock::now();
  double thread_start_ = thread_seconds();
};

// ---- Instructions of the first rank, errors and sums ------------------------------------------------------------------------------------

void BlockExchange::begin(Task task) {
  busy_ = true;
  constexpr Task of_files[] = {Task::start, Task::restore, Task::particles, Task::blocks};
  counting_ = std::ranges::find(of_files, task) == std::end(of_files);
}

void BlockExchange::instruct(Task task, const State& state, double dt) {
  begin(task);
  if (!first()) return;
  Message message;
  put(message, task);
  for (const double v : {dt, state.time, state.max_speed}) put(message, v);
  for (const std::uint64_t v : {state.step, state.next_id, state.source_count}) put(message, v);
  transport_.broadcast(message);
}

Ranks::Instruction BlockExchange::next_instruction(State& state) {
  Message message;
  transport_.broadcast(message);
  MessageReader reader(message);
  Instruction instruction;
  instruction.task = reader.get<Task>();
  instruction.dt = reader.get<double>();
  state.time = reader.get<double>();
  state.max_speed = reader.get<double>();
  state.step = reader.get<std::uint64_t>();
  state.next_id = reader.get<std::uint64_t>();
  state.source_count = reader.get<std::uint64_t>();
  begin(instruction.task);
  return instruction;
}

void BlockExchange::done() {
  busy_ = false;
  if (step_start_) costs_.note_step(omp_get_max_threads() * (thread_seconds() - *step_start_ - step_waited_), own_cost_);
  step_start_.reset();
}

double BlockExchange::agree(double largest, const std::optional<BlockError>& error) {
  double numbers[2] = {std::isfinite(largest) ? largest : 0.0, error ? 1.0 : 0.0};
  reduce(sizeof numbers);
  {
    const Waiting waiting(*this, counts_.reduction_wait);
    transport_.maximum(numbers);
  }
  if (numbers[1] == 0.0) return numbers[0];
  Message mine, text;
  if (error) {
    put(mine, error->block);
    put(mine, std::span<const char>(error->text));
  }
  std::optional<Index3> earliest;
  for (const Message& message : transport_.gather(std::move(mine))) {
    if (message.empty()) continue;
    MessageReader reader(message);
    const auto block = reader.get<Index3>();
    if (earliest && !comes_before(block, *earliest)) continue;
    earliest = block;
    text.clear();
    put(text, std::span<const char>(reader.text()));
  }
  transport_.broadcast(text);
  done();
  throw UnstableError(MessageReader(text).text());
}

void BlockExchange::sum(std::span<std::uint64_t> numbers) {
  reduce(numbers.size_bytes());
  const Waiting waiting(*this, counts_.reduction_wait);
  transport_.sum(numbers);
}

std::vector<Message> BlockExchange::gather(Message mine) {
  if (counting_) ++counts_.gathers;
  if (counting_ && !first()) counts_.gathered_bytes += mine.size();
  return transport_.gather(std::move(mine));
}

void BlockExchange::collect(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into) {
  std::vector<std::int32_t> blocks;
  std::size_t particles = 0;
  for (const auto b : from.occupied_blocks()) {
    if (first() || !wanted(from.block(b))) continue;
    blocks.push_back(b);
    particles += static_cast<std::size_t>(from.block(b).particles.count());
  }
  Message mine;
  mine.reserve(message_bytes(blocks.size(), particles, from.precision()));
  for (const auto b : blocks) put_block(mine, from.block(b));
  auto all = transport_.gather(std::move(mine));
  for (Message& message : all) {
    get_blocks(message, into);
    message = {};
  }
  into.refresh();
}

std::vector<RankCounts> BlockExchange::counts(std::size_t particles) {
  RankCounts own = counts_;
  own.particles = particles;
  Message mine;
  put(mine, own);
  std::vector<RankCounts> all;
  for (const Message& message : transport_.gather(std::move(mine))) all.push_back(MessageReader(message).get<RankCounts>());
  return all;
}

// ---- Owners and borders -----------------------------------------------------------------------------------------------------------------

bool BlockExchange::takes(const Index3& block) {
  if (!counted_) return owns(block);
  ++counted_->try_emplace(morton_key(block), BlockHead{block, 0}).first->second.count;
  return false;
}

std::vector<BlockHead> BlockExchange::counted_blocks() {
  std::vector<BlockHead> heads;
  for (const auto& [key, head] : *counted_) heads.push_back(head);
  std::ranges::sort(heads, comes_before, &BlockHead::block);
  counted_.reset();
  return heads;
}

void BlockExchange::cut(const JoinedBlocks& joined, std::span<const BlockHead> heads) {
  ownership_.cut(joined, heads);
  plan_ = HaloPlan();  // of blocks that there may have been before
  fresh_ = true;
}

void BlockExchange::prepare(Grid& grid, const JoinedBlocks& joined) {
  if (ownership_.renew(grid, joined, costs_, now_)) {
    fresh_ = true;
    ++counts_.moves;
    grid.refresh();
  }
  if (measures()) step_start_ = thread_seconds();
  step_waited_ = 0.0;
  ++counts_.steps;
  counts_.particle_steps += own_particles_;
  counts_.block_steps += occupied_.size();
  counts_.border_steps += border_blocks_;
  counts_.neighbour_steps += mine_.size();
}

Borders BlockExchange::borders_of(const Grid& grid) const {
  Borders borders;
  for (const auto b : grid.occupied_blocks()) {
    const Block& block = grid.block(b);
    if (!block.at_border) continue;
    std::set<int> others;
    for (int n = 0; n < 27; ++n) others.insert(ownership_.owner(neighbour_of(block.coordinate, n)));
    others.erase(transport_.rank());
    for (const int rank : others) borders[rank].push_back(block.coordinate);
  }
  return borders;
}

/// Exchanges the lists of blocks with particles at the common border with the neighbouring ranks.
void BlockExchange::exchange_borders() {
  ++counts_.exchanges;
  Messages out;
  for (const auto& [rank, blocks] : mine_) put(out[rank], std::span<const Index3>(blocks));
  theirs_.clear();
  for (const auto& [rank, message] : transport_.exchange(std::move(out))) theirs_[rank] = MessageReader(message).values<Index3>();
}

/// Ghosts, and own blocks whose nodes are touched by particles of other ranks.
std::vector<std::int32_t> BlockExchange::required_blocks(Grid& grid) const {
  std::vector<std::int32_t> needed;
  for (const auto& [rank, blocks] : theirs_) {
    for (const Index3& block : blocks) {
      needed.push_back(grid.block_at(block));
      for (const int slot : forward_slots) {
        const Index3 touched = neighbour_of(block, slot);
        if (owns(touched)) needed.push_back(grid.block_at(touched));
      }
    }
  }
  return needed;
}

std::vector<std::int32_t> BlockExchange::announce(Grid& grid) {
  std::size_t own = 0;
  std::vector<Index3> occupied;
  border_blocks_ = 0;
  for (const auto b : grid.occupied_blocks()) {
    const Block& block = grid.block(b);
    own += static_cast<std::size_t>(block.particles.count());
    border_blocks_ += block.at_border ? 1 : 0;
    occupied.push_back(block.coordinate);
  }
  const bool as_before = !fresh_ && occupied == occupied_;  // and therefore the same borders
  Borders borders;
  if (!as_before) borders = borders_of(grid);
  const std::vector<double> costs = costs_.of_occupied_blocks(grid);
  own_cost_ = std::accumulate(costs.begin(), costs.end(), 0.0);
  double largest[2] = {as_before || (!fresh_ && borders == mine_) ? 0.0 : 1.0, own_cost_};
  constexpr double nanosecond = 1e-9;
  std::uint64_t all[2] = {own, static_cast<std::uint64_t>(std::llround(own_cost_ / nanosecond))};
  reduce(sizeof largest);
  {
    const Waiting waiting(*this, counts_.reduction_wait);
    transport_.maximum(largest);
  }
  sum(all);
  now_ = {all[0], nanosecond * static_cast<double>(all[1]), largest[1]};
  own_particles_ = own;
  occupied_ = std::move(occupied);
  unchanged_ = as_before && largest[0] == 0.0;
  if (unchanged_) return needed_;  // these numbers are still valid: a block that stays keeps its number
  if (largest[0] > 0.0) {
    if (!as_before) mine_ = std::move(borders);
    fresh_ = false;
    exchange_borders();
  }
  needed_ = required_blocks(grid);
  return needed_;
}

void BlockExchange::plan(Grid& grid) {
  if (!unchanged_) plan_.renew(grid, ownership_, theirs_);
  costs_.reserve(grid.numbers());
}

// ---- In every step ----------------------------------------------------------------------------------------------------------------------

void BlockExchange::count(const Messages& out, std::uint64_t& bytes) {
  counts_.messages += out.size();
  for (const auto& [rank, message] : out) bytes += message.size();
}

void BlockExchange::reduce(std::size_t bytes) {
  if (!counting_) return;
  ++counts_.reductions;
  counts_.reduced_bytes += bytes;
}

void BlockExchange::send_parts(Grid& grid) { send_parts_of(plan_.all(), fields_of(grid), fields_of_nodes(grid)); }
void BlockExchange::add_parts(Grid& grid) { add_parts_of(fields_of(grid), fields_of_nodes(grid)); }
void BlockExchange::send_parts(std::span<NodeBlock> field, const BlockChoice& givers) {
  send_parts_of(plan_.some(givers), 1, nodes_of_field(field));
}
void BlockExchange::add_parts(std::span<NodeBlock> field) { add_parts_of(1, nodes_of_field(field)); }

template <class NodesOf>
void BlockExchange::send_parts_of(const HaloLayout& layout, int fields, const NodesOf& nodes_of) {
  parts_ = &layout;
  Messages out = packed(layout.parts_to, fields, nodes_of);
  count(out, counts_.part_bytes);
  std::map<int, std::size_t> sizes;
  for (const auto& [rank, nodes] : layout.parts_from) sizes[rank] = static_cast<std::size_t>(fields) * nodes * sizeof(Node);
  transport_.start(MessageKind::parts, std::move(out), sizes);
}

template <class NodesOf>
void BlockExchange::add_parts_of(int fields, const NodesOf& nodes_of) {
  Messages in;
  const auto sum = [&](std::size_t begin, std::size_t end) {
#pragma omp parallel for schedule(static)
    for (std::size_t i = begin; i < end; ++i) {
      for (int f = 0; f < fields; ++f) {
        NodeBlock& all = nodes_of(parts_->shared[i].block, f);
        for (const Summand& part : parts_->shared[i].summands) {
          NodeBlock received;
          const NodeBlock* from = &received;
          if (part.from == Summand::own) {
            from = &nodes_of(part.nodes, f);
          } else {
            const std::size_t nodes = nodes_in(part.extent);
            const std::size_t first = static_cast<std::size_t>(fields) * part.first + static_cast<std::size_t>(f) * nodes;
            get_nodes(in.find(part.from)->second.data() + first * sizeof(Node), received, part.extent);
          }
          for_each_row(part.extent, [&](int first, int nodes) {
            for (int n = first; n < first + nodes; ++n) all.node[n] += from->node[n];
          });
        }
      }
    }
  };
  sum(0, parts_->complete);
  {
    const Waiting waiting(*this, counts_.part_wait);
    in = transport_.finish(MessageKind::parts);
  }
  for (const auto& [rank, nodes] : parts_->parts_from) check_size(in.at(rank), static_cast<std::size_t>(fields) * nodes * sizeof(Node));
  sum(parts_->complete, parts_->shared.size());
}

void BlockExchange::send_nodes(Grid& grid, const HaloLayout& layout) {
  nodes_ = &layout;
  const int fields = fields_of(grid);
  Messages out = packed(layout.nodes_to, fields, fields_of_nodes(grid));
  count(out, counts_.node_bytes);
  std::map<int, std::size_t> sizes;
  for (const auto& [rank, all] : layout.nodes_from) sizes[rank] = static_cast<std::size_t>(fields) * total_nodes(all) * sizeof(Node);
  transport_.start(MessageKind::nodes, std::move(out), sizes);
}

void BlockExchange::receive_nodes(Grid& grid) {
  const int fields = fields_of(grid);
  const auto nodes_of = fields_of_nodes(grid);
  Messages in;
  {
    const Waiting waiting(*this, counts_.node_wait);
    in = transport_.finish(MessageKind::nodes);
  }
  for (const auto& [rank, all] : nodes_->nodes_from) {
    const Message& message = in.at(rank);
    check_size(message, static_cast<std::size_t>(fields) * total_nodes(all) * sizeof(Node));
    const std::byte* bytes = message.data();
    for (const SentNodes& sent : all) {
      for (int f = 0; f < fields; ++f) bytes = get_nodes(bytes, nodes_of(sent.nodes, f), sent.extent);
    }
  }
}

void BlockExchange::exchange_migrants(Grid& grid) {
  Messages out;
  for (const auto& [rank, blocks] : mine_) {
    Message& message = out[rank];
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const Block& block = grid.block(grid.find(blocks[i]));
      for (std::size_t m = 0; block.outbox_neighbours != 0 && m < block.outbox.size(); ++m) {
        if (ownership_.owner(neighbour_of(block.coordinate, block.outbox_to[m])) != rank) continue;
        put(message, static_cast<std::uint32_t>(i));
        put(message, block.outbox_to[m]);
        put(message, block.outbox[m]);
      }
    }
  }
  count(out, counts_.migrant_bytes);
  transport_.send(std::move(out));
  Messages in;
  {
    const Waiting waiting(*this, counts_.migrant_wait);
    in = transport_.receive(ranks_in(theirs_));
  }
  for (const auto& [rank, message] : in) {
    MessageReader reader(message);
    while (!reader.at_end()) {
      const auto block = reader.get<std::uint32_t>();
      const auto to = reader.get<std::uint8_t>();
      grid.block(grid.find_any(theirs_[rank].at(block))).send(reader.get<Migrant>(), to);
    }
  }
}

}  // namespace mpm
