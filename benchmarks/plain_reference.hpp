#pragma once
/// The method in its plainest form: one particle at a time, a dense grid, no lanes, no blocks, the law with double. What was timed is
/// checked against it. It shares with the library the law's template and the boundaries' contact rule, which have tests of their own.
///
/// Every check throws std::runtime_error with what differs and by how much.

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

/// The grid holds what particle_to_grid must make of the particles.
void check_scatter(const Grid& grid, const TransferOptions& options);
/// The particles hold what update_nodes, gather (dt = 0: nothing moves) must make of `before`, the particles that particle_to_grid saw.
void check_nodes_and_gather(const Problem& problem, const std::vector<Particle>& before, const TransferOptions& scattered);
/// The particles hold what the law must make of `before` (same order).
void check_law(const Problem& problem, const std::vector<Particle>& before, double dt);
/// The particles hold what a whole step must make of `before` (any order).
void check_step(const Problem& problem, const std::vector<Particle>& before, double dt, double time_before);
/// Every particle is in the block and the cell of its base node, in the cell's run of the order, and none is lost or double.
void check_order(const Grid& grid, std::uint64_t particles);

}  // namespace mpm::benchmarks
