#include "libmpm/parallel/block_exchange.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/core/state.hpp"

namespace mpm {

namespace {

template <class T>
std::vector<int> ranks_in(const std::map<int, T>& map) {
  std::vector<int> ranks;
  for (const auto& [rank, value] : map) ranks.push_back(rank);
  return ranks;
}

}  // namespace

// ---- Instructions of the first rank, errors and sums ------------------------------------------------------------------------------------

void BlockExchange::begin(TaskNumber task) {
  busy_ = true;
  constexpr TaskNumber of_particles[] = {Task::start, Task::restore, Task::observe, Task::particles, Task::blocks};
  counting_ = std::ranges::find(of_particles, task) == std::end(of_particles);
}

void BlockExchange::instruct(TaskNumber task, const State& state, double dt) {
  begin(task);
  if (!first()) return;
  Message message;
  put(message, task);
  for (const double v : {dt, state.time, state.max_speed}) put(message, v);
  for (const std::uint64_t v : {state.step, state.next_id, state.source_count}) put(message, v);
  transport_.broadcast(message);
}

Instruction BlockExchange::next_instruction(State& state) {
  Message message;
  transport_.broadcast(message);
  MessageReader reader(message);
  Instruction instruction;
  instruction.task = reader.get<TaskNumber>();
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
  if (const auto computed = clock_.stop()) costs_.note_step(omp_get_max_threads() * *computed, own_cost_);
}

double BlockExchange::largest_or_throw(double own, const std::optional<BlockError>& error) {
  double numbers[2] = {std::isfinite(own) ? own : 0.0, error ? 1.0 : 0.0};
  reduce(sizeof numbers);
  {
    const StepClock::Waiting waiting(clock_, counts_.reduction_wait);
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
  const StepClock::Waiting waiting(clock_, counts_.reduction_wait);
  transport_.sum(numbers);
}

std::vector<Message> BlockExchange::gather(Message mine) {
  if (counting_) ++counts_.gathers;
  if (counting_ && !first()) counts_.gathered_bytes += mine.size();
  return transport_.gather(std::move(mine));
}

// ---- Owners and borders -----------------------------------------------------------------------------------------------------------------

void BlockExchange::cut(const JoinedBlocks& joined, std::span<const BlockHead> heads) {
  ownership_.cut(joined, heads);
  plan_ = HaloPlan();  // of blocks that there may have been before
  fresh_ = true;
}

void BlockExchange::begin_step(State& state, const Scene& scene, double dt) {
  instruct(Task::step, state, dt);
  if (ownership_.renew(state.grid, JoinedBlocks(scene, state.grid.cell_size(), state.time), costs_, now_)) {
    fresh_ = true;
    ++counts_.moves;
    state.grid.refresh();
  }
  if (measures()) clock_.start();
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
      needed.push_back(grid.find_or_create(block));
      for (const int direction : forward_directions) {
        const Index3 touched = neighbour_of(block, direction);
        if (owns(touched)) needed.push_back(grid.find_or_create(touched));
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
    const StepClock::Waiting waiting(clock_, counts_.reduction_wait);
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
  costs_.reserve(grid.index_end());
}

// ---- In every step ----------------------------------------------------------------------------------------------------------------------

void BlockExchange::reduce(std::size_t bytes) {
  if (!counting_) return;
  ++counts_.reductions;
  counts_.reduced_bytes += bytes;
}

void BlockExchange::exchange_migrants(Grid& grid) {
  Messages out;
  for (const auto& [rank, blocks] : mine_) {
    Message& message = out[rank];
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const Block& block = grid.block(grid.find(blocks[i]));
      block.outbox.for_each([&, to = rank](const Migrant& m) {
        if (ownership_.owner(neighbour_of(block.coordinate, m.to)) != to) return;
        put(message, static_cast<std::uint32_t>(i));
        put(message, m);
      });
    }
  }
  halo_.count(out, counts_.migrant_bytes);
  transport_.send(std::move(out));
  Messages in;
  {
    const StepClock::Waiting waiting(clock_, counts_.migrant_wait);
    in = transport_.receive(ranks_in(theirs_));
  }
  for (const auto& [rank, message] : in) {
    MessageReader reader(message);
    while (!reader.at_end()) {
      const auto block = reader.get<std::uint32_t>();
      grid.send(grid.find_any(theirs_[rank].at(block)), reader.get<Migrant>());
    }
  }
}

}  // namespace mpm
