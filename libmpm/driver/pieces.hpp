#pragma once
/// All particles of a run, piece by piece, for files: memory holds one piece at a time, and the first rank never those of the others.

#include <cstdint>
#include <functional>
#include <span>

#include "libmpm/core/state.hpp"

namespace mpm {

/// How large a piece is.
struct PieceSize {
  std::uint64_t particles = std::uint64_t{1} << 13;  ///< at most, 1.6 MB of records; a block stays whole
};

/// Who gets the particles of all ranks by rising identity number; on the first rank.
struct ParticleSink {
  std::function<void(std::size_t particles)> begin;       ///< first: how many there are
  std::function<void(std::span<const Particle>)> append;  ///< the next ones
};
/// Called by all ranks: the others send theirs, and need no sink. @throws what the sink throws, after all ranks have done their part
void pass_particles(const State& state, const ParticleSink& sink, PieceSize size = {});

/// A block and how many particles it holds.
struct BlockHead {
  Index3 block{};          ///< its coordinate
  std::int32_t count = 0;  ///< its particles
};
/// Who gets the occupied blocks of all ranks in their order; on the first rank.
struct BlockSink {
  std::function<void(std::span<const BlockHead>)> begin;  ///< first: all of them
  std::function<void(const Grid&)> append;                ///< the next ones: those that the grid holds
};
/// As pass_particles().
void pass_blocks(const State& state, const BlockSink& sink, PieceSize size = {});

}  // namespace mpm
