#pragma once
/// Blocks with their particles as messages between ranks: as they are stored, so that nothing is rounded on the way.

#include <functional>

#include "libmpm/base/message.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

/// Appends a block to a message.
void put_block(Message& message, const Block& block);
/// Puts all blocks of a message into a grid. Call Grid::refresh() afterwards.
void get_blocks(const Message& message, Grid& grid);

/// Copies blocks of the other ranks with their particles into a grid of the first; all ranks call it. @param into  not divided among ranks
/// @param wanted  which blocks; called on the rank that owns the block
void collect_blocks(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into);

}  // namespace mpm
