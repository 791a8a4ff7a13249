#include "libmpm/parallel/ownership.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace mpm {

// ---- Intervals of a curve --------------------------------------------------------------------------------------------------------------

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

// ---- Blocks as messages ----------------------------------------------------------------------------------------------------------------

namespace {

/// Appends a block to a message.
void put_block(Message& message, const Block& block) {
  const ParticleBin& bin = block.particles;
  put(message, block.coordinate);
  const Vec3& v = bin.frame.velocity;
  put(message, std::array<double, 3>{v.x(), v.y(), v.z()});
  put(message, bin.count());
  put(message, std::span<const std::uint8_t>(bin.cell));
  for (int s = 0; s < bin.count(); ++s) put(message, bin.bytes(s));
}

/// Puts all blocks of a message into a grid. Call Grid::refresh() afterwards.
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

void collect_blocks(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into) {
  RankGroup& ranks = from.ranks();
  std::vector<std::int32_t> blocks;
  std::size_t bytes = 0;  // known at the start: a message that grows takes twice the memory
  for (const auto b : from.occupied_blocks()) {
    if (ranks.first() || !wanted(from.block(b))) continue;
    blocks.push_back(b);
    const auto particles = static_cast<std::size_t>(from.block(b).particles.count());
    bytes += sizeof(Index3) + 3 * sizeof(double) + sizeof(int) + particles * (1 + record_bytes(from.precision()));
  }
  Message mine;
  mine.reserve(bytes);
  for (const auto b : blocks) put_block(mine, from.block(b));
  auto all = ranks.gather(std::move(mine));
  for (Message& message : all) {
    get_blocks(message, into);
    message = {};
  }
  into.refresh();
}

// ---- Moves -----------------------------------------------------------------------------------------------------------------------------

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
