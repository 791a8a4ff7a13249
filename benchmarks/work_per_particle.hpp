#pragma once
/// Bytes and floating-point operations of one particle in one step, counted by hand from the code.
///
/// Bytes: the least traffic with memory, every cache line counted once for each kernel and direction, as if a block's nodes
/// (7 kB) stayed in cache while its particles are worked on. A written line is read before. c is the number of particles a cell; every
/// cell has one node.
///   Particle: 3 lines of 64 bytes: position, volume, velocity, id | 8 of the affine matrix | its ninth, stress, internal variable.
///   Beside it: cell 1 byte, order 2 bytes. Node: 32 bytes.
///
/// Operations: + - * / sqrt and comparisons that feed a result count one, a fused multiply-add two; selects, shuffles, loads count none.
/// The transfers work on four components (three of momentum or velocity, one of mass) and are counted with all four, even if a
/// component is only copied: this gives the fraction of busy multiply-add units.

namespace mpm::benchmarks {

struct Work {
  double bytes;
  double flops;
  friend constexpr Work operator+(Work a, Work b) { return {a.bytes + b.bytes, a.flops + b.flops}; }
  friend constexpr Work operator*(double s, Work a) { return {s * a.bytes, s * a.flops}; }
};

inline constexpr double line_bytes = 64.0, node_bytes = 32.0, particle_bytes = 3.0 * line_bytes;

/// Reads the whole particle and its order. A node is zeroed (read + write) and summed into (read + write).
/// Operations of contribution() and add() in core/particle_to_grid.cpp, each on 4 components:
///   offset f 2; volume scales 2; three columns a_x a_y a_z of mass or force: 3 each, 9; base m v - f.a: 2 + 6;
///   weights 3 + 2 + 2 + 2 = 9; per k of 3: three products and one sum, 4; per j of 3: two products, two sums, 3 fma, one sum, 11
///   = 2 + 2 + 9 + 8 + 9 + 3 (4 + 3 * 11) = 141.
/// Per cell: the two halves of 27 sums joined and added to the halo, 54. Per block of 64 cells: 216 halo nodes added to the grid.
constexpr Work particle_to_grid_work(double c) {
  return {particle_bytes + 2.0 + 4.0 * node_bytes / c, 4.0 * (141.0 + 54.0 / c + 216.0 / 64.0 / c)};
}

/// Reads the order and the nodes, reads and writes position, velocity and the affine matrix (all three lines), writes the cell (read +
/// write). Operations of grid_to_particle, each on 4 components:
///   offset 2; weights 9; gather_pair: doubled weights 3, per k of 3: [per j of 3: 7] + m 1 + v 4 + y 2 + x 5 = 33, and the last axis 1 + 4
///   + 5 + 5 + 2 = 3 + 99 + 17 = 119; affine matrix 3 * 3; position 2; speed 1 + 2 + 1; cell 2 = 2 + 9 + 119 + 9 + 2 + 4 + 2 = 147.
constexpr Work grid_to_particle_work(double c) { return {2.0 * particle_bytes + 2.0 + 2.0 + node_bytes / c, 4.0 * 147.0}; }

/// Reads the second line, reads and writes the third.
/// Operations of HenckyElastic::update_stress with the short series (strains below 3 %), one component:
///   dt L 9; strain from stress 13;
///   exp(2 eps) - I: double 6, square 27, invariants 3 + 14, series of order 8 at 4: 32, evaluation 21, expm1 27, scaling 10 = 140;
///   P = dl + dl B 54; f b f^T - I 48; |dl|^2 18;
///   1/2 log(I + D): trace, scale, deviator 14, square and invariants 44, series of order 11: 44, evaluation 21, log1p 26, trace 8 = 157;
///   stress 10; NaN check 7.
constexpr Work elastic_law_work() { return {3.0 * line_bytes, 9.0 + 13.0 + 140.0 + 54.0 + 48.0 + 18.0 + 157.0 + 10.0 + 7.0}; }

/// Newton corrections until the slowest lane of a group has settled: typical of a step's small strain. The first starts from the base
/// state, the others need an evaluation each.
inline constexpr double newton_corrections = 3.0;

/// The same lines; the elastic trial and
///   yield check: p, q^2 14, sinh(xi X) 18, y 8 = 41;
///   return map inside the surface: base state 13, its Y, v, e, w, slopes and surface 29, whether it is inside 5; per correction 16; per
///   evaluation: sinh and cosh increments 33, Y and the others 29 = 62; convergence and soundness 24; ratio u and result 20.
constexpr Work yielding_law_work() {
  const Work elastic = elastic_law_work();
  return {elastic.bytes, elastic.flops + 41.0 + 47.0 + newton_corrections * 16.0 + (newton_corrections - 1.0) * 62.0 + 24.0 + 20.0};
}
/// The same, without a return.
constexpr Work unyielding_law_work() {
  const Work elastic = elastic_law_work();
  return {elastic.bytes, elastic.flops + 41.0};
}

/// A node is read and written: 1 / m, v = p / m + dt g: 1 + 4 * 2, mass sum 1.
constexpr Work grid_update_work(double c) { return {2.0 * node_bytes / c, 10.0 / c}; }

/// Cells are read twice (collecting, counting) and the order is written (read + write). A migrant is read and written to the outbox
/// (200 bytes, read + write), read from there and written into its new page (read + write), and its slot filled by the last particle.
/// @param migrating fraction of the particles that change block
constexpr Work sort_work(double migrating) {
  return {2.0 + 4.0 + migrating * (particle_bytes + 3.0 * 200.0 + 2.0 * particle_bytes + 3.0 * particle_bytes), 0.0};
}

/// The whole step. The law works on lines that grid_to_particle has just loaded into the cache, so its bytes do not count again.
/// @param yielding fraction of the particles that yield; @param migrating fraction that changes block
constexpr Work step_work(double c, double yielding, double migrating) {
  const Work law = yielding * yielding_law_work() + (1.0 - yielding) * unyielding_law_work();
  return particle_to_grid_work(c) + grid_update_work(c) + grid_to_particle_work(c) + Work{0.0, law.flops} + sort_work(migrating);
}

}  // namespace mpm::benchmarks
