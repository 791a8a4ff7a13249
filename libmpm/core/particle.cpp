#include "libmpm/core/particle.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "libmpm/base/error.hpp"

namespace mpm {

bool all_finite(const Particle& p) {
  const auto finite = [](const auto& numbers) { return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); }); };
  return finite(p.position) && finite(p.velocity) && finite(p.affine) && finite(p.stress) && std::isfinite(p.internal);
}

Particle decode(const SingleRecord& r, const RecordFrame& frame) {
  Particle p;
  Eigen::Map<Vec3>(p.position) = position_of(r, frame);
  for (std::size_t i = 0; i < 3; ++i) {
    p.velocity[i] = frame.velocity[static_cast<Eigen::Index>(i)] + double{r.velocity[i]};
    p.affine[i] = r.affine_x[i];
    p.affine[3 + i] = r.affine_y[i];
    p.affine[6 + i] = r.affine_z[i];
    p.stress[3 + i] = r.stress_shear[i];
  }
  p.volume = r.volume;
  p.id = r.id;
  p.stress[0] = r.stress_xx;
  p.stress[1] = r.stress_yy;
  p.stress[2] = r.stress_zz;
  p.internal = r.internal;
  return p;
}

void encode(const Particle& p, int cell, const RecordFrame& frame, SingleRecord& r) {
  if (p.id > largest_single_id) {
    throw ConfigError("more than " + std::to_string(largest_single_id) +
                      " particles have entered: their numbers do not fit into a particle of single precision; use double precision");
  }
  constexpr double cell_units = 1 << position_bits, farthest = 2 * block_edge * cell_units;  // step() ends a run with larger displacements
  for (std::size_t i = 0; i < 3; ++i) {
    const double at = std::nearbyint((p.position[i] / frame.cell_size - 0.5 - first_node(frame.block[i])) * cell_units);
    const double first = (cell >> (2 * i) & 3) * cell_units;
    const bool stays = cell < block_nodes;
    const double low = stays ? first : -farthest, high = stays ? first + (cell_units - 1.0) : farthest;
    r.position[i] = static_cast<std::int32_t>(at > low ? std::min(at, high) : low);  // not a number: low
    r.velocity[i] = static_cast<float>(p.velocity[i] - frame.velocity[static_cast<Eigen::Index>(i)]);
    r.affine_x[i] = static_cast<float>(p.affine[i]);
    r.affine_y[i] = static_cast<float>(p.affine[3 + i]);
    r.affine_z[i] = static_cast<float>(p.affine[6 + i]);
    r.stress_shear[i] = static_cast<float>(p.stress[3 + i]);
  }
  r.volume = static_cast<float>(p.volume);
  r.id = static_cast<std::uint32_t>(p.id);
  r.stress_xx = static_cast<float>(p.stress[0]);
  r.stress_yy = static_cast<float>(p.stress[1]);
  r.stress_zz = static_cast<float>(p.stress[2]);
  r.internal = static_cast<float>(p.internal);
}

}  // namespace mpm
