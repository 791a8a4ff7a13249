#include "libmpm/core/particle_order.hpp"

#include <algorithm>

namespace mpm {

ParticleOrder::ParticleOrder(const Grid& grid, const std::function<bool(const Particle&)>& keep) : grid_(grid) {
  std::size_t most = 0;
  for (const auto b : grid.occupied_blocks()) most += static_cast<std::size_t>(grid.block(b).particles.count());
  order_.reserve(most);
  for (const auto b : grid.occupied_blocks()) {
    const ParticleBin& bin = grid.block(b).particles;
    for (std::int32_t s = 0; s < bin.count(); ++s) {
      const Particle p = bin[s];
      if (!keep || keep(p)) order_.push_back({p.id, b, s});
    }
  }
  std::ranges::sort(order_, {}, &Place::id);
}

std::size_t ParticleOrder::first_from(std::uint64_t id) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(order_, id, {}, &Place::id) - order_.begin());
}

}  // namespace mpm
