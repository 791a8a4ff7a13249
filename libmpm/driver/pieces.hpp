#pragma once
/// All particles of a run, piece by piece, so that files need memory for one piece at a time: the first rank never holds the particles of
/// the others.

#include <functional>

#include "libmpm/core/state.hpp"
#include "libmpm/io/snapshot.hpp"

namespace mpm {

/// How large a piece is.
struct PieceSize {
  std::uint64_t particles = std::uint64_t{1} << 17;  ///< of a piece, at most (blocks: but for a block that holds more): 25 MB
};

/// Calls f for the particles of all ranks in the order of their identity numbers; on the first rank.
/// @throws what f throws, after all ranks have done their part
void for_each_piece(const State& state, const Scene& scene, const std::function<void(const ParticleTable&)>& f, PieceSize size = {});
/// What the other ranks do meanwhile.
void send_pieces(const State& state, PieceSize size = {});

/// A block and how many particles it holds.
struct BlockHead {
  Index3 block{};          ///< its coordinate
  std::int32_t count = 0;  ///< its particles
};
/// Lists the occupied blocks of all ranks in their order, then calls f with grids that hold them, in that order; on the first rank.
/// @param heads  gets the list. @throws what the two throw, after all ranks have done their part
void for_each_grid_piece(const State& state, const std::function<void(std::span<const BlockHead>)>& heads,
                         const std::function<void(const Grid&)>& f, PieceSize size = {});
/// What the other ranks do meanwhile.
void send_grid_pieces(const State& state);

}  // namespace mpm
