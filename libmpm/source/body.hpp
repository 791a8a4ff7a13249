#pragma once
/// A body: particles that fill a simple shape.

#include <cstdint>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/outline.hpp"
#include "libmpm/source/lattice.hpp"

namespace mpm {

class ParameterReport;
struct Scene;
struct State;

/// [[body]]: particles that fill a simple shape.
struct BodySpec {
  /// What is inscribed in the box min to max.
  enum class Shape : std::uint8_t { box, cylinder, sphere } shape = Shape::box;  ///< form of the body
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< bounding box, m; cylinder (axis z) and sphere are inscribed
  Vec3 velocity = Vec3::Zero();                 ///< m/s
  Lattice lattice = Lattice::staggered;         ///< where its particles lie (fill_body)
  bool operator==(const BodySpec&) const = default;

  /// The keys of [[body]] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("shape", &BodySpec::shape, {"box", "cylinder", "sphere"})
        .text("Cylinder (axis z) and sphere are inscribed in the box min_m..max_m");
    table.add("min_m", &BodySpec::min).unit("m").range(-longest_length, longest_length).required().text("Lower corner of the bounding box");
    table.add("max_m", &BodySpec::max).unit("m").range(-longest_length, longest_length).required().text("Upper corner of the bounding box");
    table.add("velocity_m_s", &BodySpec::velocity).unit("m/s").range(-fastest_speed, fastest_speed).text("Initial velocity");
    table.add("lattice", &BodySpec::lattice, {"staggered", "aligned", "random"})
        .text(
            "staggered: a lattice whose layers across the velocity (across z for a body at rest) are shifted against each other, so that "
            "no "
            "gaps open where the flow spreads; aligned: a plain lattice; random: Poisson discs");
  }
  /// min is below max along every axis.
  void check(ParameterReport& report) const;
};

/// Exact volume of the whole body, m^3.
[[nodiscard]] double volume_of(const BodySpec& body);

/// Whether the interiors of a body and of a solid overlap.
[[nodiscard]] bool meets_solid(const BodySpec& body, const UprightSolid& solid);

/// Whether two bodies have common volume: tried at points over the common part of their bounding boxes, where it is a slice thinner than a
/// 24th of that part it may be missed.
[[nodiscard]] bool overlap(const BodySpec& a, const BodySpec& b);

/// Adds the particles of a body at rest in its reference state, which fill the shape with the body's exact volume. With mirror
/// planes only the computed part is filled; a particle on a plane keeps half its volume. On uneven ground particles whose centre is below
/// it are left out. Identity numbers rise with x fastest, then y, z.
///
/// A staggered lattice: layer n along the largest component of the velocity (z for a body at rest) is shifted within the lattice's cells
/// along the other two axes by the n-th point of the R2 sequence, less a half. Particles that follow one another on the same lines keep to
/// the same stream lines: where an obstacle spreads the flow the lines part by several cells, and the nodes between them are left without
/// material. Random: a cell has none, one or several particles (random_points). Mirror planes stay planes of symmetry: particles are
/// shifted away from them on both sides, and random points are those of the cells counted from the plane.
/// @param spacing  wanted distance of particles, m
/// @returns the number of lattice points of the whole body; 0 where not one fits into it, and then nothing was added
std::size_t fill_body(State& state, const BodySpec& body, const Scene& scene, double spacing);

}  // namespace mpm
