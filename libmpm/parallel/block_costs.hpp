#pragma once
/// What the particles of each block cost: measured computing time.

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
  /// Computing time for the particles of each occupied block, s. A block that has not been measured takes as long as the measured ones do
  /// for as many particles.
  [[nodiscard]] std::vector<double> of_occupied_blocks(const Grid& grid) const;

 private:
  struct Measured {
    Index3 block{};     ///< the number may belong to another block by now
    double cost = 0.0;  ///< s for each particle; 0: not measured
  };
  std::vector<Measured> measured_;  ///< by number of block
};

}  // namespace mpm
