#pragma once
/// All particles of a run by rising identity number, piece by piece, for files: each rank gets one stretch of the numbers and writes it.
/// Memory holds one piece at a time, and no rank holds the particles of all.

#include <cstdint>
#include <functional>
#include <span>

#include "libmpm/core/state.hpp"
#include "libmpm/io/snapshot.hpp"

namespace mpm {

/// Size of a piece.
struct PieceSize {
  std::uint64_t particles = std::uint64_t{1} << 13;  ///< at most, 1.6 MB of records
};

/// Who gets the particles, on every rank. It does not throw: the other ranks go on.
struct ParticleSink {
  /// First: how many particles there are on all ranks, and how many of them have smaller numbers than those of this rank.
  std::function<void(std::size_t particles, std::size_t before)> begin;
  std::function<void(std::span<const Particle>)> append;  ///< the next ones of this rank, by rising number
};
/// Called by all ranks; the first instructs the others (Task::particles). RankTasks::done() is left to the caller.
void pass_particles(const State& state, const ParticleSink& sink, PieceSize size = {});

/// Writes all particles, on all ranks. @param file  on the first rank it says what is written. @throws as SnapshotWriter::commit
void write_particles(SnapshotWriter& file, const State& state, const Scene& scene);

}  // namespace mpm
