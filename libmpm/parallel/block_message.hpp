#pragma once
/// Blocks with their particles as messages between ranks: as they are stored, so that nothing is rounded on the way.

#include <functional>

#include "libmpm/base/message.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

/// Appends a block to a message.
void put_block(Message& message, const Block& block);
/// Bytes of so many blocks with so many particles: a message that grows takes twice the memory.
constexpr std::size_t message_bytes(std::size_t blocks, std::size_t particles, Precision precision) {
  return blocks * (sizeof(Index3) + 3 * sizeof(double) + sizeof(int)) + particles * (1 + record_bytes(precision));
}
/// Puts all blocks of a message into a grid. Call Grid::refresh() afterwards.
void get_blocks(const Message& message, Grid& grid);

/// Copies blocks of the other ranks with their particles into a grid of the first; all ranks call it. @param into  not divided among ranks
/// @param wanted  which blocks; called on the rank that owns the block
void collect_blocks(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into);

}  // namespace mpm
