#include "libmpm/core/particle_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <type_traits>

#include "libmpm/core/transfer.hpp"

namespace mpm {

namespace {

/// Where a boundary is and how it acts there, as one particle sees it.
struct Surface {
  double distance = 0.0;                 ///< of the particle, m; negative behind it
  Vec3 normal = Vec3::UnitZ();           ///< unit, into the material
  Vec3 velocity = Vec3::Zero();          ///< m/s
  Contact contact = Contact::separable;  ///< how it acts
  double friction = 0.0;                 ///< mu
};

/// The surface of each kind of boundary near x; a default one where x is clearly before it.
Surface surface_at(const SurfaceSolid& solid, const Vec3& x, double) {
  if (!solid.solid().bounds().contains(x)) return {};
  const UprightSolid::Nearest nearest = solid.solid().nearest(x);
  return {.distance = nearest.distance, .normal = nearest.normal, .friction = solid.friction()};
}
Surface surface_at(const Wall& wall, const Vec3& x, double time) {
  return {x.dot(wall.normal) - wall.plane_distance(time), wall.normal, wall.surface_velocity(x, time), wall.contact, wall.friction};
}
Surface surface_at(const Terrain& ground, const Vec3& x, double) {
  const HeightField::Surface below = ground.surface(x);
  const Vec3 normal = below.normal();
  return {(x.z() - below.height) * normal.z(), normal, ground.velocity(below.slope), ground.contact, ground.friction};
}

/// Whether a boundary acts at its surface, and that is in a box.
bool is_in(const Eigen::AlignedBox3d& box, const SurfaceSolid& solid, double) { return solid.solid().bounds().intersects(box); }
bool is_in(const Eigen::AlignedBox3d& box, const auto& boundary, double time) {
  return boundary.rule == ContactRule::surface && boundary.reaches(box.min(), box.max(), time);
}

/// Puts the particles of a block that are too deep behind one boundary, the b-th, back to it.
template <class B>
void put_back(Grid& grid, std::int32_t index, std::size_t b, const B& boundary, double time, double density,
              std::vector<ParticleImpulse>& taken) {
  const Block& block = grid.block(index);
  const ParticleBin& bin = block.particles;
  const double dx = grid.cell_size();
  const std::int32_t first = first_node(block.coordinate[2]), last = first + block_edge - 1;
  with_record_type(grid.precision(), [&](auto type) {
    for (int s = 0; s < bin.count(); ++s) {
      const Surface surface = surface_at(boundary, position_of(bin.record<decltype(type)>(s), bin.frame), time);
      if (surface.distance >= -deepest_particle * dx) continue;
      Particle p = bin[s];
      const Vec3 before = velocity_of(p), at = position_of(p);
      Eigen::Map<Vec3>(p.position) += std::min(-surface.distance, dx) * surface.normal;
      Eigen::Map<Vec3>(p.velocity) = contact_velocity(before, surface.normal, surface.velocity, surface.contact, surface.friction);
      relocate(grid, index, s, p);
      const auto layer = std::clamp(static_cast<std::int32_t>(std::lround(at.z() / dx)), first, last);
      if (taken.empty() || taken.back().boundary != b || taken.back().layer != layer) taken.push_back({b, layer, {}});
      taken.back().impulse.add(density * p.volume * (before - velocity_of(bin[s])), at - boundary.reference_point(), surface.velocity);
    }
  });
}

}  // namespace

std::vector<ParticleImpulse> return_to_surface(Grid& grid, std::int32_t index, std::span<const Boundary> boundaries, double time,
                                               double density) {
  std::vector<ParticleImpulse> taken;
  const auto box = block_box(grid.block(index).coordinate, grid.cell_size(), 1.0);  // a particle moves less than a cell in a step
  const auto is_solid_in_box = [&](const Boundary& boundary) {
    const auto* const solid = std::get_if<SurfaceSolid>(&boundary);
    return solid != nullptr && is_in(box, *solid, time);
  };
  if (std::ranges::none_of(boundaries, is_solid_in_box)) return taken;
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    std::visit(
        [&]<class B>(const B& boundary) {
          if constexpr (!std::is_same_v<B, NodalSolid>) {
            if (is_in(box, boundary, time)) put_back(grid, index, b, boundary, time, density, taken);
          }
        },
        boundaries[b]);
  }
  return taken;
}

}  // namespace mpm
