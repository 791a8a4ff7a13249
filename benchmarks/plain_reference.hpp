#pragma once
/// The method in its plainest form: one particle at a time, a dense grid, no lanes, no blocks, the law with double. Timed results
/// are checked against it. It uses the library's law templates and contact rule of boundaries, which have their own tests.
///
/// Every check throws std::runtime_error with the quantity that differs and the difference.

#include <cstdint>
#include <vector>

#include "kernels.hpp"

namespace mpm::benchmarks {

/// Nodes over the bounding box of a set of particles.
class PlainGrid {
 public:
  PlainGrid(const std::vector<Particle>& particles, double cell_size);

  void scatter(const std::vector<Particle>& particles, const TransferOptions& options);
  void update(const Scene& scene, double dt, double time);
  /// v_p, C_p, x_p (APIC).
  void gather(Particle& p, double dt) const;

  [[nodiscard]] bool contains(const Index3& node) const;
  Node& node(const Index3& index) { return nodes_[place(index)]; }
  [[nodiscard]] const Node& node(const Index3& index) const { return nodes_[place(index)]; }
  [[nodiscard]] Node largest() const;  ///< largest magnitude of each component

 private:
  [[nodiscard]] std::size_t place(const Index3& index) const;
  template <class F>
  void for_each_weight(const double* position, F&& f) const;

  double cell_size_;
  Index3 low_{}, size_{};
  std::vector<Node> nodes_;
};

/// The scalar law on one particle.
void apply_law_plainly(Particle& p, const AnyMaterial& material, double dt);

/// Checks particle_to_grid: the grid against the particles.
void check_scatter(const Grid& grid, const TransferOptions& options);
/// Checks update_nodes and gather (dt = 0: no motion): the particles against `before`, the particles at particle_to_grid.
void check_nodes_and_gather(const Problem& problem, const std::vector<Particle>& before, const TransferOptions& scattered);
/// Checks the law: the particles against `before`, the particles before the update (same order).
void check_law(const Problem& problem, const std::vector<Particle>& before, double dt);
/// Checks a whole step: the particles against `before`, the particles before the step (any order).
void check_step(const Problem& problem, const std::vector<Particle>& before, double dt, double time_before);
/// Checks the order: every particle is in the block and the cell of its base node, and none is lost or duplicate.
void check_order(const Grid& grid, std::uint64_t particles);

}  // namespace mpm::benchmarks
