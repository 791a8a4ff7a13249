#include "libmpm/parallel/balancing.hpp"

#include <algorithm>

namespace mpm {

namespace {

constexpr double renewed = 0.5;  ///< by each measurement: a block's state changes within some tens of steps

}  // namespace

void BlockCosts::reserve(std::size_t index_end) { measured_.resize(std::max(index_end, measured_.size())); }

void BlockCosts::note(const Block& block, std::int32_t number, int particles, double time) noexcept {
  Measured& m = measured_[static_cast<std::size_t>(number)];
  const double cost = time / particles;
  m = {block.coordinate, m.block == block.coordinate && m.cost > 0.0 ? (1.0 - renewed) * m.cost + renewed * cost : cost};
}

void BlockCosts::note_step(double time, double expected) {
  if (expected > 0.0 && time > 0.0) whole_ *= (1.0 - renewed) + renewed * time / expected;
}

std::vector<double> BlockCosts::of_occupied_blocks(const Grid& grid) const {
  constexpr double typical = 1e-7;  // s for each particle, until something is measured
  double time = 0.0, particles = 0.0;
  const auto cost_of = [&](std::int32_t b) {
    const auto number = static_cast<std::size_t>(b);
    return number < measured_.size() && measured_[number].block == grid.block(b).coordinate ? measured_[number].cost : 0.0;
  };
  for (const auto b : grid.occupied_blocks()) {
    const double cost = cost_of(b), count = grid.block(b).particles.count();
    if (cost == 0.0) continue;
    time += cost * count;
    particles += count;
  }
  const double mean = particles > 0.0 ? time / particles : typical;
  std::vector<double> costs;
  for (const auto b : grid.occupied_blocks()) {
    const double cost = cost_of(b);
    costs.push_back(whole_ * grid.block(b).particles.count() * (cost > 0.0 ? cost : mean));
  }
  return costs;
}

}  // namespace mpm
