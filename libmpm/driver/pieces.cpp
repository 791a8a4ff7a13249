#include "libmpm/driver/pieces.hpp"

#include <algorithm>
#include <exception>

namespace mpm {

namespace {

/// Keeps the first exception, and does nothing more after it: the other ranks must be heard to the end.
class Guard {
 public:
  template <class F>
  void operator()(F&& f) {
    if (error_) return;
    try {
      f();
    } catch (...) {
      error_ = std::current_exception();
    }
  }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::exception_ptr error_;
};

/// This rank's particles with the numbers first .. end - 1.
Message packed(const ParticleOrder& own, std::uint64_t first, std::uint64_t end) {
  Message message;
  for (std::size_t i = own.first_from(first); i < own.first_from(end); ++i) put(message, own[i]);
  return message;
}

std::vector<Particle> unpacked(const std::vector<Message>& messages) {
  std::vector<Particle> all;
  for (const Message& message : messages) {
    const std::size_t before = all.size();
    all.resize(before + message.size() / sizeof(Particle));
    MessageReader(message).get(std::span(all).subspan(before));
  }
  std::ranges::sort(all, {}, &Particle::id);
  return all;
}

std::vector<BlockHead> own_heads(const Grid& grid) {
  std::vector<BlockHead> heads;
  for (const auto b : grid.occupied_blocks()) heads.push_back({grid.block(b).coordinate, grid.block(b).particles.count()});
  return heads;
}

/// First blocks of pieces.
std::vector<Index3> cuts_of(std::span<const BlockHead> heads, std::uint64_t most) {
  std::vector<Index3> cuts;
  std::uint64_t sum = 0;
  for (const BlockHead& head : heads) {
    const auto count = static_cast<std::uint64_t>(head.count);
    if (cuts.empty() || sum + count > most) {
      cuts.push_back(head.block);
      sum = 0;
    }
    sum += count;
  }
  return cuts;
}

/// Brings the blocks of one piece after another to the first rank, and calls f(grid) there.
template <class F>
void collect_pieces(const Grid& grid, std::span<const Index3> cuts, F&& f) {
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    Grid piece(grid.cell_size(), grid.precision());
    const auto wanted = [&](const Block& block) {
      return !comes_before(block.coordinate, cuts[i]) && (i + 1 == cuts.size() || comes_before(block.coordinate, cuts[i + 1]));
    };
    grid.ranks()->collect(grid, wanted, piece);
    f(piece);
  }
}

}  // namespace

void for_each_piece(const State& state, const Scene& scene, const std::function<void(const ParticleTable&)>& f, PieceSize size) {
  Ranks* const ranks = state.grid.ranks();
  if (ranks != nullptr) ranks->tell(Task::columns, state);
  const ParticleOrder own(state);
  if (ranks == nullptr) {
    for (std::size_t first = 0; first < own.size(); first += size.particles) {
      f(particle_table(
          std::min<std::size_t>(size.particles, own.size() - first), [&](std::size_t i) { return own[first + i]; }, scene));
    }
    return;
  }
  Guard guard;
  for (std::uint64_t first = 0; first < state.next_id; first += size.particles) {
    const auto particles = unpacked(ranks->gather(packed(own, first, first + size.particles)));
    if (particles.empty()) continue;
    guard([&] {
      f(particle_table(
          particles.size(), [&](std::size_t i) { return particles[i]; }, scene));
    });
  }
  ranks->done();
  guard.rethrow();
}

void send_pieces(const State& state, PieceSize size) {
  const ParticleOrder own(state);
  for (std::uint64_t first = 0; first < state.next_id; first += size.particles)
    state.grid.ranks()->gather(packed(own, first, first + size.particles));
}

void for_each_grid_piece(const State& state, const std::function<void(std::span<const BlockHead>)>& heads,
                         const std::function<void(const Grid&)>& f, PieceSize size) {
  Ranks* const ranks = state.grid.ranks();
  if (ranks == nullptr) {
    heads(own_heads(state.grid));
    return f(state.grid);
  }
  ranks->tell(Task::blocks, state);
  Message mine, shared;
  put(mine, std::span<const BlockHead>(own_heads(state.grid)));
  std::vector<BlockHead> all;
  for (const Message& message : ranks->gather(std::move(mine))) {
    const std::size_t before = all.size();
    all.resize(before + message.size() / sizeof(BlockHead));
    MessageReader(message).get(std::span(all).subspan(before));
  }
  std::ranges::sort(all, comes_before, &BlockHead::block);
  const std::vector<Index3> cuts = cuts_of(all, size.particles);
  put(shared, std::span<const Index3>(cuts));
  ranks->share(shared);
  Guard guard;
  guard([&] { heads(all); });
  collect_pieces(state.grid, cuts, [&](const Grid& piece) { guard([&] { f(piece); }); });
  ranks->done();
  guard.rethrow();
}

void send_grid_pieces(const State& state) {
  Ranks& ranks = *state.grid.ranks();
  Message mine, shared;
  put(mine, std::span<const BlockHead>(own_heads(state.grid)));
  ranks.gather(std::move(mine));
  ranks.share(shared);
  std::vector<Index3> cuts(shared.size() / sizeof(Index3));
  MessageReader(shared).get(std::span(cuts));
  collect_pieces(state.grid, cuts, [](const Grid&) {});
}

}  // namespace mpm
