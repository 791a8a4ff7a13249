#include "libmpm/driver/pieces.hpp"

#include <algorithm>
#include <utility>

#include "libmpm/base/first_error.hpp"
#include "libmpm/core/particle_order.hpp"

namespace mpm {

namespace {

/// The values that all ranks send; on the first rank.
template <class T>
std::vector<T> gathered(std::vector<T> own, Ranks* ranks) {
  if (ranks == nullptr) return own;
  Message mine;
  put(mine, std::span<const T>(own));
  own = {};
  std::vector<T> all;
  for (const Message& message : ranks->gather(std::move(mine))) {
    const std::size_t before = all.size();
    all.resize(before + message.size() / sizeof(T));
    MessageReader(message).get(std::span(all).subspan(before));
  }
  return all;
}

/// Division of the particles of all ranks into pieces: piece i has the identity numbers first[i] .. first[i + 1] - 1.
struct Cuts {
  std::vector<std::uint64_t> first = {0};
  std::uint64_t particles = 0;  ///< of all pieces
};

/// Makes the division, equal on all ranks, from counts in intervals of numbers. @param end  above all numbers
Cuts cuts_of(const ParticleOrder& own, std::uint64_t end, Ranks* ranks, std::uint64_t most) {
  const std::uint64_t stretch = std::max<std::uint64_t>(1, most / 8);
  std::vector<std::uint64_t> counts((end + stretch - 1) / stretch, 0);
  for (std::size_t i = 0; i < own.size(); ++i) ++counts[own.id(i) / stretch];
  if (ranks != nullptr) ranks->sum(counts);
  Cuts cuts;
  std::uint64_t piece = 0;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    if (piece > 0 && piece + counts[s] > most) {
      cuts.first.push_back(s * stretch);
      piece = 0;
    }
    piece += counts[s];
    cuts.particles += counts[s];
  }
  cuts.first.push_back(end);
  return cuts;
}

std::vector<BlockHead> heads_of(const Grid& grid) {
  std::vector<BlockHead> heads;
  for (const auto b : grid.occupied_blocks()) heads.push_back({grid.block(b).coordinate, grid.block(b).particles.count()});
  return heads;
}

/// First blocks of the pieces.
std::vector<Index3> cuts_of(std::span<const BlockHead> heads, std::uint64_t most) {
  std::vector<Index3> cuts;
  std::uint64_t piece = 0;
  for (const BlockHead& head : heads) {
    const auto count = static_cast<std::uint64_t>(head.count);
    if (cuts.empty() || piece + count > most) {
      cuts.push_back(head.block);
      piece = 0;
    }
    piece += count;
  }
  return cuts;
}

}  // namespace

void pass_particles(const State& state, const ParticleSink& sink, PieceSize size) {
  Ranks* const ranks = state.grid.ranks();
  if (ranks != nullptr) ranks->instruct(Task::particles, state);
  const bool first = ranks == nullptr || ranks->first();
  const ParticleOrder own(state.grid);
  const Cuts cuts = cuts_of(own, state.next_id, ranks, size.particles);
  FirstError error;  // the other ranks continue to send
  if (first) error.attempt([&] { sink.begin(cuts.particles); });
  std::size_t at = 0;
  for (std::size_t i = 1; i < cuts.first.size(); ++i) {
    std::vector<Particle> piece;
    const std::size_t end = own.first_from(cuts.first[i]);
    piece.reserve(end - at);
    for (; at < end; ++at) piece.push_back(own[at]);
    piece = gathered(std::move(piece), ranks);
    if (ranks != nullptr) std::ranges::sort(piece, {}, &Particle::id);
    if (first) error.attempt([&] { sink.append(piece); });
  }
  if (ranks != nullptr) ranks->done();
  error.rethrow();
}

void pass_blocks(const State& state, const BlockSink& sink, PieceSize size) {
  Ranks* const ranks = state.grid.ranks();
  if (ranks == nullptr) {
    sink.begin(heads_of(state.grid));
    return sink.append(state.grid);
  }
  ranks->instruct(Task::blocks, state);
  auto heads = gathered(heads_of(state.grid), ranks);
  std::ranges::sort(heads, comes_before, &BlockHead::block);
  Message shared;
  put(shared, std::span<const Index3>(cuts_of(heads, size.particles)));
  ranks->share(shared);
  const auto cuts = MessageReader(shared).values<Index3>();
  FirstError error;  // the other ranks continue to send
  if (ranks->first()) error.attempt([&] { sink.begin(heads); });
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    Grid piece(state.grid.cell_size(), state.grid.precision());
    const auto wanted = [&](const Block& block) {
      const Index3& c = block.coordinate;
      return !comes_before(c, cuts[i]) && (i + 1 == cuts.size() || comes_before(c, cuts[i + 1]));
    };
    ranks->collect(state.grid, wanted, piece);
    if (ranks->first()) error.attempt([&] { sink.append(piece); });
  }
  ranks->done();
  error.rethrow();
}

}  // namespace mpm
