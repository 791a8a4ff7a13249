#pragma once
/// All particles of a run, piece by piece, for files: memory holds one piece at a time, and the first rank never holds all particles of the
/// others.

#include <cstdint>
#include <functional>
#include <span>

#include "libmpm/core/state.hpp"

namespace mpm {

/// Size of a piece.
struct PieceSize {
  std::uint64_t particles = std::uint64_t{1} << 13;  ///< at most, 1.6 MB of records; a block stays whole
};

/// Receives the particles of all ranks by ascending identity number; on the first rank.
struct ParticleSink {
  std::function<void(std::size_t particles)> begin;       ///< called first, with the number of particles
  std::function<void(std::span<const Particle>)> append;  ///< receives the next ones
};
/// Collective: the other ranks send their particles and need no sink. @throws the error of the sink, after all ranks have finished
void pass_particles(const State& state, const ParticleSink& sink, PieceSize size = {});

/// A block and the number of its particles.
struct BlockHead {
  Index3 block{};          ///< its coordinate
  std::int32_t count = 0;  ///< its particles
};
/// Receives the occupied blocks of all ranks in their order; on the first rank.
struct BlockSink {
  std::function<void(std::span<const BlockHead>)> begin;  ///< called first, with all of them
  std::function<void(const Grid&)> append;                ///< receives the next ones, in a grid
};
/// As pass_particles().
void pass_blocks(const State& state, const BlockSink& sink, PieceSize size = {});

}  // namespace mpm
