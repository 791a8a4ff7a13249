#include "libmpm/driver/pieces.hpp"

#include <algorithm>
#include <utility>

#include "libmpm/parallel/block_exchange.hpp"

namespace mpm {

namespace {

/// Division of the particles of all ranks into pieces: piece i has the identity numbers first[i] .. first[i + 1] - 1.
struct Cuts {
  std::vector<std::uint64_t> first = {0};
  std::vector<std::size_t> before = {0};  ///< particles of the pieces before
  std::size_t particles = 0;              ///< of all pieces

  [[nodiscard]] std::size_t pieces() const { return before.size(); }
  /// The first piece of a rank: each has a stretch of them.
  [[nodiscard]] std::size_t first_of(int rank, int ranks) const {
    return pieces() * static_cast<std::size_t>(rank) / static_cast<std::size_t>(ranks);
  }
};

/// Makes the division, equal on all ranks, from counts in intervals of numbers. @param end  above all numbers
Cuts cuts_of(const ParticleOrder& own, std::uint64_t end, RankGroup& ranks, std::uint64_t most) {
  constexpr std::uint64_t most_stretches = std::uint64_t{1} << 20;
  const std::uint64_t stretch = std::max({std::uint64_t{1}, most / 8, end / most_stretches});
  std::vector<std::uint64_t> counts((end + stretch - 1) / stretch, 0);
  for (std::size_t i = 0; i < own.size(); ++i) ++counts[own.id(i) / stretch];
  ranks.sum(counts);
  Cuts cuts;
  std::uint64_t piece = 0;
  for (std::size_t s = 0; s < counts.size(); ++s) {
    if (piece > 0 && piece + counts[s] > most) {
      cuts.first.push_back(s * stretch);
      cuts.before.push_back(cuts.particles);
      piece = 0;
    }
    piece += counts[s];
    cuts.particles += counts[s];
  }
  cuts.first.push_back(end);
  return cuts;
}

/// With many ranks pieces are smaller: what a rank sends at once is a piece for each of the others.
std::uint64_t most_of(PieceSize size, int ranks) {
  constexpr std::uint64_t at_once = std::uint64_t{1} << 16, least = 1 << 10;  // particles: 13 MB, 0.2 MB
  return std::min(size.particles, std::max(least, at_once / static_cast<std::uint64_t>(ranks)));
}

}  // namespace

void pass_particles(const State& state, const ParticleSink& sink, PieceSize size) {
  Ranks& ranks = state.grid.ranks();
  ranks.instruct(Task::particles, state);
  const int all = ranks.size(), me = ranks.rank();
  const ParticleOrder own(state.grid);
  const Cuts cuts = cuts_of(own, state.next_id, ranks, most_of(size, all));
  const std::size_t mine = cuts.first_of(me, all);
  sink.begin(cuts.particles, mine < cuts.pieces() ? cuts.before[mine] : cuts.particles);
  const std::size_t rounds = (cuts.pieces() + static_cast<std::size_t>(all) - 1) / static_cast<std::size_t>(all);
  for (std::size_t round = 0; round < rounds; ++round) {
    std::vector<Particle> piece;
    std::map<int, Message> out;
    for (int rank = 0; rank < all; ++rank) {
      const std::size_t p = cuts.first_of(rank, all) + round;
      if (p >= cuts.first_of(rank + 1, all)) continue;
      const std::size_t first = own.first_from(cuts.first[p]), end = own.first_from(cuts.first[p + 1]);
      std::vector<Particle> part;
      part.reserve(end - first);
      for (std::size_t i = first; i < end; ++i) part.push_back(own[i]);
      if (rank == me) {
        piece = std::move(part);
      } else if (!part.empty()) {
        put(out[rank], std::span<const Particle>(part));
      }
    }
    for (const auto& [rank, message] : ranks.exchange(std::move(out))) {
      const auto others = MessageReader(message).values<Particle>();
      piece.insert(piece.end(), others.begin(), others.end());
    }
    if (all > 1) std::ranges::sort(piece, {}, &Particle::id);
    if (!piece.empty()) sink.append(piece);
  }
}

void write_particles(SnapshotWriter& file, const State& state, const Scene& scene) {
  pass_particles(state, {.begin = [&](std::size_t particles, std::size_t before) { file.begin(particles, before, state.grid.ranks()); },
                         .append = [&](std::span<const Particle> piece) { file.append(piece, scene); }});
  file.commit();
}

}  // namespace mpm
