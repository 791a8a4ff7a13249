#pragma once
/// What the ranks of a program do together besides the functions of the core. The first rank decides (driver/worker.hpp).

#include "libmpm/core/ranks.hpp"

namespace mpm {

/// Names of all tasks.
struct Task : CoreTask {
  /// Those that are not of the core.
  enum Number : TaskNumber {
    inside = CoreTask::count,  ///< particles that start inside a boundary
    observe,                   ///< particles that an observer wants to see
    particles,                 ///< all particles by their numbers, for a file
    blocks,                    ///< all blocks in their order, for a file
    report,                    ///< what was exchanged
    start,                     ///< the particles of t = 0
    restore,                   ///< the particles of a checkpoint
    end,                       ///< nothing follows
  };
};

/// What the first rank sends to start a task.
struct Instruction {
  TaskNumber task = Task::end;  ///< what to do
  double dt = 0.0;              ///< time step, s; CoreTask::step only
};

}  // namespace mpm
