#pragma once
/// What each block costs: measured computing time.
///
/// The time for the motion and the stresses of a block's particles is measured block by block. What else a rank computes (particles to the
/// grid, walls, contact with an obstacle, sorting) is measured for all its blocks together, and shared among them in proportion. Contact
/// concerns a few blocks only, which this does not know; but when blocks have left a rank that takes too long, its other blocks are found
/// to cost more, until all ranks take equally long.

#include <vector>

#include "libmpm/core/grid.hpp"

namespace mpm {

/// Computing time of a step for each particle, by block.
class BlockCosts {
 public:
  /// Makes room. @param numbers  Grid::numbers()
  void reserve(std::size_t numbers);
  /// Notes what a block's particles took. Threads may note different blocks at the same time. @param time  s
  void note(const Block& block, std::int32_t number, int particles, double time) noexcept;
  /// Notes what a whole step took on this rank. @param time  computing time of all threads, without waiting, s
  /// @param expected  sum of of_occupied_blocks(), s
  void note_step(double time, double expected);
  /// Computing time for each occupied block, s. A block that has not been measured takes as long as the measured ones do for as many
  /// particles.
  [[nodiscard]] std::vector<double> of_occupied_blocks(const Grid& grid) const;

 private:
  struct Measured {
    Index3 block{};     ///< the number may belong to another block by now
    double cost = 0.0;  ///< s for each particle; 0: not measured
  };
  std::vector<Measured> measured_;  ///< by number of block
  double whole_ = 1.0;              ///< time of a step over the sum of the measured times
};

}  // namespace mpm
