#include "libmpm/parallel/block_exchange.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/core/block_table.hpp"
#include "libmpm/parallel/message.hpp"

namespace mpm {

namespace {

constexpr int own_part = -1;  ///< Summand::from

/// Coordinate of a neighbour. @param slot  neighbour_slot
Index3 beside(const Index3& block, int slot) { return {block[0] + slot % 3 - 1, block[1] + slot / 3 % 3 - 1, block[2] + slot / 9 - 1}; }

/// Forward offset number k = 0 .. 7: bit 0 one block along x, bit 1 along y, bit 2 along z.
constexpr int forward_slot(int k) { return neighbour_slot(k & 1, k >> 1 & 1, k >> 2); }
constexpr int backward_slot(int k) { return 26 - forward_slot(k); }
/// The nodes of the block at forward offset k that a block's particles touch.
constexpr std::array<int, 3> touched(int k) { return {(k & 1) != 0 ? 2 : 4, (k & 2) != 0 ? 2 : 4, (k & 4) != 0 ? 2 : 4}; }
std::size_t nodes_in(const std::array<int, 3>& extent) { return static_cast<std::size_t>(extent[0] * extent[1] * extent[2]); }

int colour_of(const Index3& block) { return (block[0] & 1) | (block[1] & 1) << 1 | (block[2] & 1) << 2; }

/// Calls f(first node, number) for the rows of some nodes of a block.
template <class F>
void for_each_row(const std::array<int, 3>& extent, F&& f) {
  for (int z = 0; z < extent[2]; ++z) {
    for (int y = 0; y < extent[1]; ++y) f(block_edge * y + block_edge * block_edge * z, extent[0]);
  }
}

void put_nodes(Message& message, const NodeBlock& nodes, const std::array<int, 3>& extent) {
  for_each_row(extent, [&](int first, int count) {
    const auto* bytes = reinterpret_cast<const std::byte*>(nodes.node + first);
    message.insert(message.end(), bytes, bytes + static_cast<std::size_t>(count) * sizeof(Node));
  });
}

/// Replaces nodes by those of a message. @returns what follows them in the message
const std::byte* get_nodes(const std::byte* bytes, NodeBlock& nodes, const std::array<int, 3>& extent) {
  for_each_row(extent, [&](int first, int count) {
    const std::size_t size = static_cast<std::size_t>(count) * sizeof(Node);
    std::memcpy(static_cast<void*>(nodes.node + first), bytes, size);
    bytes += size;
  });
  return bytes;
}

int fields_of(const Grid& grid) { return grid.keeps_old_nodes() ? 2 : 1; }
NodeBlock& field_of(Grid& grid, std::int32_t block, int field) { return field == 0 ? grid.nodes(block) : grid.old_nodes(block); }

std::size_t bytes_of(const Messages& messages) {
  std::size_t sum = 0;
  for (const auto& [rank, message] : messages) sum += message.size();
  return sum;
}

template <class T>
std::vector<int> ranks_in(const std::map<int, T>& map) {
  std::vector<int> ranks;
  for (const auto& [rank, value] : map) ranks.push_back(rank);
  return ranks;
}

void check_size(const Message& message, std::size_t expected) {
  if (message.size() != expected) throw Error(ExitCode::internal, "internal error: ranks disagree about the blocks at their border");
}

/// A block with its particles, as they are stored.
void put_block(Message& message, const Block& block) {
  const ParticleBin& bin = block.particles;
  put(message, block.coordinate);
  const Vec3& v = bin.frame.velocity;
  put(message, std::array<double, 3>{v.x(), v.y(), v.z()});
  put(message, bin.count());
  put(message, std::span<const std::uint8_t>(bin.cell));
  for (int s = 0; s < bin.count(); ++s) put(message, bin.bytes(s));
}
void get_blocks(const Message& message, Grid& grid) {
  MessageReader reader(message);
  std::vector<std::uint8_t> cells;
  std::vector<std::byte> records;
  while (!reader.at_end()) {
    const auto coordinate = reader.get<Index3>();
    const auto velocity = reader.get<std::array<double, 3>>();
    const auto count = static_cast<std::size_t>(reader.get<int>());
    cells.resize(count);
    records.resize(count * record_bytes(grid.precision()));
    reader.get(std::span(cells));
    reader.get(std::span(records));
    grid.restore({coordinate, Vec3(velocity[0], velocity[1], velocity[2]), cells, records});
  }
}

}  // namespace

BlockExchange::BlockExchange(Transport& transport, const Balancing& balancing)
    : transport_(transport), balancing_(balancing), partition_(transport.size()) {}

bool BlockExchange::at_border(const Index3& block) const {
  for (int n = 0; n < 27; ++n) {
    if (partition_.owner(beside(block, n)) != transport_.rank()) return true;
  }
  return false;
}

// ---- What the first rank says -----------------------------------------------------------------------------------------------------------

void BlockExchange::tell(Task task, const State& state, double dt) {
  busy_ = true;
  if (!first()) return;
  Message message;
  put(message, task);
  for (const double v : {dt, state.time, state.max_speed}) put(message, v);
  for (const std::uint64_t v : {state.step, state.next_id, state.source_count}) put(message, v);
  transport_.broadcast(message);
}

Ranks::Told BlockExchange::next(State& state) {
  Message message;
  transport_.broadcast(message);
  MessageReader reader(message);
  Told told;
  told.task = reader.get<Task>();
  told.dt = reader.get<double>();
  state.time = reader.get<double>();
  state.max_speed = reader.get<double>();
  state.step = reader.get<std::uint64_t>();
  state.next_id = reader.get<std::uint64_t>();
  state.source_count = reader.get<std::uint64_t>();
  busy_ = true;
  return told;
}

double BlockExchange::agree(double largest, const std::optional<BlockFault>& fault) {
  double numbers[2] = {std::isfinite(largest) ? largest : 0.0, fault ? 1.0 : 0.0};
  transport_.maximum(numbers);
  if (numbers[1] == 0.0) return numbers[0];
  Message mine, text;
  if (fault) {
    put(mine, fault->block);
    put(mine, std::span<const char>(fault->text));
  }
  std::optional<Index3> earliest;
  for (const Message& message : transport_.gather(std::move(mine))) {
    if (message.empty()) continue;
    MessageReader reader(message);
    const auto block = reader.get<Index3>();
    if (earliest && !comes_before(block, *earliest)) continue;
    earliest = block;
    text.assign(message.begin() + sizeof(Index3), message.end());
  }
  transport_.broadcast(text);
  done();
  throw UnstableError(std::string(reinterpret_cast<const char*>(text.data()), text.size()));
}

std::vector<std::vector<std::byte>> BlockExchange::gather(std::vector<std::byte> bytes) {
  if (!first()) traffic_.sum_bytes += bytes.size();
  return transport_.gather(std::move(bytes));
}

void BlockExchange::collect(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into) {
  Message mine;
  for (const auto b : from.occupied_blocks()) {
    if (wanted(from.block(b))) put_block(mine, from.block(b));
  }
  auto all = transport_.gather(std::move(mine));
  for (Message& message : all) {
    get_blocks(message, into);
    message = {};
  }
  into.refresh();
}

std::string BlockExchange::report(std::size_t particles) {
  Message mine;
  put(mine, static_cast<std::uint64_t>(particles));
  put(mine, traffic_);
  std::string text;
  int rank = 0;
  for (const Message& message : transport_.gather(std::move(mine))) {
    MessageReader reader(message);
    const auto now = reader.get<std::uint64_t>();
    const auto t = reader.get<Traffic>();
    text += (rank == 0 ? "{\"ranks\": [" : ",") + std::string("\n  {\"rank\": ") + std::to_string(rank);
    const std::pair<const char*, std::uint64_t> counts[] = {{"particles", now},
                                                            {"steps", t.steps},
                                                            {"particle_steps", t.particles},
                                                            {"neighbour_steps", t.neighbours},
                                                            {"part_bytes", t.part_bytes},
                                                            {"node_bytes", t.node_bytes},
                                                            {"migrant_bytes", t.migrant_bytes},
                                                            {"sum_bytes", t.sum_bytes},
                                                            {"moves", t.moves}};
    for (const auto& [name, count] : counts) text += std::string(", \"") + name + "\": " + std::to_string(count);
    text += "}";
    ++rank;
  }
  return text.empty() ? text : text + "\n]}\n";
}

// ---- Who owns what ----------------------------------------------------------------------------------------------------------------------

std::vector<Load> BlockExchange::loads(const Grid& grid, const Partition& partition) {
  Message mine;
  for (const auto b : grid.occupied_blocks())
    put(mine, Load{partition.key(grid.block(b).coordinate), static_cast<double>(grid.block(b).particles.count())});
  std::vector<Load> all;
  for (const Message& message : transport_.gather(std::move(mine))) {
    const std::size_t before = all.size();
    all.resize(before + message.size() / sizeof(Load));
    MessageReader(message).get(std::span(all).subspan(before));
  }
  return all;
}

/// Whether it is time to try new cuts.
bool BlockExchange::uneven() {
  if (balancing_.forced > 0) return steps_ % static_cast<std::uint64_t>(balancing_.forced) == 0;
  if (announced_ && steps_ - tried_at_ < static_cast<std::uint64_t>(balancing_.interval)) return false;
  if (!announced_) return true;
  return largest_load_ * transport_.size() > balancing_.threshold * static_cast<double>(particles_);
}

void BlockExchange::prepare(Grid& grid, const JoinedBlocks& joined) {
  Partition wanted = partition_;
  wanted.join(joined);
  if (uneven()) {
    tried_at_ = steps_;
    const std::vector<Load> all = loads(grid, wanted);
    Message cuts;
    if (first()) {
      std::vector<double> shares(static_cast<std::size_t>(transport_.size()), 1.0);
      if (balancing_.forced > 0) {
        const auto turn = static_cast<std::size_t>(steps_ / static_cast<std::uint64_t>(balancing_.forced));
        for (std::size_t r = 0; r < shares.size(); ++r) shares[r] += static_cast<double>((r + turn) % 3);
      }
      const auto better = Partition::cut(all, shares);
      const bool take = balancing_.forced > 0 ||
                        Partition::largest_cost(all, better) <= (1.0 - balancing_.gain) * Partition::largest_cost(all, wanted.cuts());
      const auto chosen = take ? std::span<const std::uint64_t>(better) : wanted.cuts();
      put(cuts, chosen);
    }
    transport_.broadcast(cuts);
    std::vector<std::uint64_t> taken(cuts.size() / sizeof(std::uint64_t));
    MessageReader(cuts).get(std::span(taken));
    wanted.set_cuts(std::move(taken));
  }
  if (!announced_ || !(wanted == partition_)) move_blocks(grid, wanted);
  ++steps_;
  ++traffic_.steps;
  traffic_.particles += own_particles_;
}

void BlockExchange::move_blocks(Grid& grid, const Partition& to) {
  Messages out;
  for (const auto b : grid.occupied_blocks()) {
    const int owner = to.owner(grid.block(b).coordinate);
    if (owner == transport_.rank()) continue;
    put_block(out[owner], grid.block(b));
    grid.clear(b);
  }
  partition_ = to;
  const Messages in = transport_.exchange(std::move(out));
  grid.ask_owners();
  for (const auto& [rank, message] : in) get_blocks(message, grid);
  fresh_ = true;
  ++traffic_.moves;
  grid.refresh();
}

BlockExchange::Borders BlockExchange::borders_of(const Grid& grid) const {
  Borders borders;
  for (const auto b : grid.occupied_blocks()) {
    const Block& block = grid.block(b);
    if (!block.at_border) continue;
    std::set<int> others;
    for (int n = 0; n < 27; ++n) others.insert(partition_.owner(beside(block.coordinate, n)));
    others.erase(transport_.rank());
    for (const int rank : others) borders[rank].push_back(block.coordinate);
  }
  return borders;
}

std::vector<std::int32_t> BlockExchange::announce(Grid& grid) {
  std::size_t own = 0;
  std::vector<Index3> occupied;
  for (const auto b : grid.occupied_blocks()) {
    own += static_cast<std::size_t>(grid.block(b).particles.count());
    occupied.push_back(grid.block(b).coordinate);
  }
  const bool as_before = !fresh_ && occupied == occupied_;  // then so are the borders
  Borders borders;
  if (!as_before) borders = borders_of(grid);
  double largest[2] = {as_before || (!fresh_ && borders == mine_) ? 0.0 : 1.0, static_cast<double>(own)};
  std::uint64_t all = own;
  transport_.maximum(largest);
  transport_.sum({&all, 1});
  particles_ = all;
  own_particles_ = own;
  largest_load_ = largest[1];
  announced_ = true;
  occupied_ = std::move(occupied);
  unchanged_ = as_before && largest[0] == 0.0;
  if (unchanged_) return needed_;  // by their numbers: a block that was needed and is has kept it
  if (largest[0] > 0.0) {
    if (!as_before) mine_ = std::move(borders);
    fresh_ = false;
    Messages out;
    for (const auto& [rank, blocks] : mine_) put(out[rank], std::span<const Index3>(blocks));
    theirs_.clear();
    for (const auto& [rank, message] : transport_.exchange(std::move(out))) {
      theirs_[rank].resize(message.size() / sizeof(Index3));
      MessageReader(message).get(std::span(theirs_[rank]));
    }
  }
  needed_.clear();
  for (const auto& [rank, blocks] : theirs_) {
    for (const Index3& block : blocks) {
      needed_.push_back(grid.block_at(block));
      for (int k = 1; k < 8; ++k) {
        const Index3 touched_block = beside(block, forward_slot(k));
        if (owns(touched_block)) needed_.push_back(grid.block_at(touched_block));
      }
    }
  }
  return needed_;
}

// ---- The layout of messages -------------------------------------------------------------------------------------------------------------

void BlockExchange::plan(Grid& grid) {
  if (unchanged_) return;
  for (const auto& [block, targets] : targets_) grid.block(block).parts = nullptr;
  targets_.clear();
  grid.return_lent();
  parts_to_.clear();
  parts_from_.clear();
  shared_.clear();
  nodes_to_.clear();
  nodes_from_.clear();
  plan_own_parts(grid);
  plan_shared(grid);
  for (const auto& [block, targets] : targets_) grid.block(block).parts = &targets;
}

namespace {

/// For each rank and block the nodes that are needed there: grows to what all of that rank's blocks touch.
using Needs = std::map<int, std::map<std::uint64_t, std::pair<std::int32_t, std::array<int, 3>>>>;

void add_need(Needs& needs, int rank, std::uint64_t key, std::int32_t block, const std::array<int, 3>& extent) {
  auto& [number, all] = needs[rank].try_emplace(key, block, extent).first->second;
  for (std::size_t axis = 0; axis < 3; ++axis) all[axis] = std::max(all[axis], extent[axis]);
}

}  // namespace

/// What own blocks give to blocks of other ranks, in the order of the blocks and of their neighbours.
void BlockExchange::plan_own_parts(Grid& grid) {
  Needs needs;
  for (const auto b : grid.occupied_blocks()) {
    const Block& block = grid.block(b);
    if (!block.at_border) continue;
    for (int k = 1; k < 8; ++k) {
      const auto slot = static_cast<std::size_t>(forward_slot(k));
      const std::int32_t to = block.neighbour[slot];
      if (grid.block(to).owned) continue;
      const int rank = partition_.owner(grid.block(to).coordinate);
      const std::int32_t lent = grid.lend_nodes();
      targets_.try_emplace(b, grid.block(b).neighbour).first->second[slot] = lent;
      parts_to_[rank].push_back({lent, touched(k)});
      add_need(needs, rank, morton_key(grid.block(to).coordinate), to, touched(k));
    }
  }
  for (const auto& [rank, blocks] : needs) {
    for (const auto& [key, need] : blocks) nodes_from_[rank].push_back({need.first, need.second});
  }
}

/// Own blocks whose nodes get parts from other ranks: all parts are summed afterwards, in the order of the colours.
void BlockExchange::plan_shared(Grid& grid) {
  Needs needs;
  std::map<std::int32_t, std::vector<Summand>> summands;
  for (const auto& [rank, blocks] : theirs_) {
    for (const Index3& block : blocks) {
      for (int k = 1; k < 8; ++k) {
        const Index3 coordinate = beside(block, forward_slot(k));
        if (!owns(coordinate)) continue;
        const std::int32_t to = grid.find(coordinate);
        std::size_t& before = parts_from_[rank];
        summands[to].push_back({colour_of(block), touched(k), rank, no_block, before});
        before += nodes_in(touched(k));
        add_need(needs, rank, morton_key(coordinate), to, touched(k));
      }
    }
  }
  for (auto& [to, all] : summands) {
    for (int k = 0; k < 8; ++k) {
      const std::int32_t from = grid.block(to).neighbour[static_cast<std::size_t>(backward_slot(k))];
      if (from == no_block || !grid.block(from).owned || grid.block(from).particles.count() == 0) continue;
      const std::int32_t lent = grid.lend_nodes();
      targets_.try_emplace(from, grid.block(from).neighbour).first->second[static_cast<std::size_t>(forward_slot(k))] = lent;
      all.push_back({colour_of(grid.block(from).coordinate), touched(k), own_part, lent, 0});
    }
    std::ranges::sort(all, {}, &Summand::colour);  // each colour comes once
    shared_.push_back({to, std::move(all)});
  }
  for (const auto& [rank, blocks] : needs) {
    for (const auto& [key, need] : blocks) nodes_to_[rank].push_back({need.first, need.second});
  }
}

// ---- In every step ----------------------------------------------------------------------------------------------------------------------

void BlockExchange::add_parts(Grid& grid) {
  const int fields = fields_of(grid);
  Messages out;
  for (const auto& [rank, parts] : parts_to_) {
    Message& message = out[rank];
    for (const OutPart& part : parts) {
      for (int f = 0; f < fields; ++f) put_nodes(message, field_of(grid, part.nodes, f), part.extent);
    }
  }
  traffic_.neighbours += out.size();
  traffic_.part_bytes += bytes_of(out);
  transport_.send(std::move(out));
  const Messages in = transport_.receive(ranks_in(parts_from_));
  for (const auto& [rank, nodes] : parts_from_) check_size(in.at(rank), static_cast<std::size_t>(fields) * nodes * sizeof(Node));
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < shared_.size(); ++i) {
    for (int f = 0; f < fields; ++f) {
      NodeBlock& sum = field_of(grid, shared_[i].block, f);
      for (const Summand& part : shared_[i].summands) {
        NodeBlock received;
        const NodeBlock* from = &received;
        if (part.from == own_part) {
          from = &field_of(grid, part.nodes, f);
        } else {
          const std::size_t nodes = nodes_in(part.extent);
          const std::size_t first = static_cast<std::size_t>(fields) * part.first + static_cast<std::size_t>(f) * nodes;
          get_nodes(in.find(part.from)->second.data() + first * sizeof(Node), received, part.extent);
        }
        for_each_row(part.extent, [&](int first, int count) {
          for (int n = first; n < first + count; ++n) sum.node[n] += from->node[n];
        });
      }
    }
  }
}

void BlockExchange::return_nodes(Grid& grid) {
  const int fields = fields_of(grid);
  Messages out;
  for (const auto& [rank, blocks] : nodes_to_) {
    Message& message = out[rank];
    for (const Returned& r : blocks) {
      for (int f = 0; f < fields; ++f) put_nodes(message, field_of(grid, r.block, f), r.extent);
    }
  }
  traffic_.node_bytes += bytes_of(out);
  transport_.send(std::move(out));
  const Messages in = transport_.receive(ranks_in(nodes_from_));
  for (const auto& [rank, message] : in) {
    std::size_t nodes = 0;
    for (const Returned& r : nodes_from_[rank]) nodes += nodes_in(r.extent);
    check_size(message, static_cast<std::size_t>(fields) * nodes * sizeof(Node));
    const std::byte* bytes = message.data();
    for (const Returned& r : nodes_from_[rank]) {
      for (int f = 0; f < fields; ++f) bytes = get_nodes(bytes, field_of(grid, r.block, f), r.extent);
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
        if (partition_.owner(beside(block.coordinate, block.outbox_to[m])) != rank) continue;
        put(message, static_cast<std::uint32_t>(i));
        put(message, block.outbox_to[m]);
        put(message, block.outbox[m]);
      }
    }
  }
  traffic_.migrant_bytes += bytes_of(out);
  transport_.send(std::move(out));
  for (const auto& [rank, message] : transport_.receive(ranks_in(theirs_))) {
    MessageReader reader(message);
    while (!reader.at_end()) {
      const auto block = reader.get<std::uint32_t>();
      const auto to = reader.get<std::uint8_t>();
      grid.block(grid.find_any(theirs_[rank].at(block))).send(reader.get<Migrant>(), to);
    }
  }
}

}  // namespace mpm
