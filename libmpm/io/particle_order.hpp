#pragma once
/// The particles of a grid in the order of their identity numbers.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "libmpm/core/grid.hpp"

namespace mpm {

/// The places of all particles by ascending identity number, 16 bytes for each. The grid must not change while this object is used.
class ParticleOrder {
 public:
  /// Of this rank's particles. @param keep  selects particles; empty: all
  explicit ParticleOrder(const Grid& grid, const std::function<bool(const Particle&)>& keep = {}) : grid_(grid) {
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

  [[nodiscard]] std::size_t size() const { return order_.size(); }              ///< particles
  [[nodiscard]] std::uint64_t id(std::size_t i) const { return order_[i].id; }  ///< of the i-th
  [[nodiscard]] Particle operator[](std::size_t i) const {                      ///< the i-th
    return grid_.block(order_[i].block).particles[order_[i].slot];
  }
  /// Place of the first particle whose number is not below this.
  [[nodiscard]] std::size_t first_from(std::uint64_t id) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(order_, id, {}, &Place::id) - order_.begin());
  }

 private:
  struct Place {
    std::uint64_t id;
    std::int32_t block, slot;
  };
  const Grid& grid_;
  std::vector<Place> order_;
};

}  // namespace mpm
