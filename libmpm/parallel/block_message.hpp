#pragma once
/// Blocks with their particles as messages between ranks: as they are stored, so that nothing is rounded on the way.

#include "libmpm/base/message.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

/// Appends a block to a message.
void put_block(Message& message, const Block& block);
/// Puts all blocks of a message into a grid. Call Grid::refresh() afterwards.
void get_blocks(const Message& message, Grid& grid);

}  // namespace mpm
