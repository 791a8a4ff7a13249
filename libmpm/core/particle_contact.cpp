#include "libmpm/core/particle_contact.hpp"

#include <algorithm>

#include "libmpm/core/transfer.hpp"

namespace mpm {

std::vector<ParticleImpulse> return_to_surface(Grid& grid, std::int32_t index, std::span<const Boundary> boundaries, double density) {
  std::vector<ParticleImpulse> taken;
  const Block& block = grid.block(index);
  const ParticleBin& bin = block.particles;
  const double dx = grid.cell_size();
  const auto box = block_box(block.coordinate, dx, 1.0);  // a particle moves less than a cell in a step
  const std::int32_t first = first_node(block.coordinate[2]), last = first + block_edge - 1;
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const auto* const solid = std::get_if<SurfaceSolid>(&boundaries[b]);
    if (solid == nullptr) continue;
    const UprightSolid& geometry = solid->solid();
    const Eigen::AlignedBox3d bounds = geometry.bounds();
    if (!bounds.intersects(box)) continue;
    const Vec3 margin = Vec3::Constant(0.5 * deepest_particle * dx);
    const Eigen::AlignedBox3d deep(bounds.min() + margin, bounds.max() - margin);  // outside of it no particle is too deep
    with_record_type(grid.precision(), [&](auto type) {
      for (int s = 0; s < bin.count(); ++s) {
        const Vec3 x = position_of(bin.record<decltype(type)>(s), bin.frame);
        if (!deep.contains(x)) continue;
        const UprightSolid::Nearest surface = geometry.nearest(x);
        if (surface.distance >= -deepest_particle * dx) continue;
        Particle p = bin[s];
        const Vec3 before = velocity_of(p), at = position_of(p);
        const Vec3 after = contact_velocity(before, surface.normal, Vec3::Zero(), Contact::separable, solid->friction());
        Eigen::Map<Vec3>(p.position) += std::min(-surface.distance, dx) * surface.normal;
        Eigen::Map<Vec3>(p.velocity) = after;
        relocate(grid, index, s, p);
        const auto layer = std::clamp(static_cast<std::int32_t>(std::lround(at.z() / dx)), first, last);
        if (taken.empty() || taken.back().boundary != b || taken.back().layer != layer) taken.push_back({b, layer});
        taken.back().impulse.add(density * p.volume * (before - velocity_of(bin[s])), at - solid->reference_point(), Vec3::Zero());
      }
    });
  }
  return taken;
}

}  // namespace mpm
