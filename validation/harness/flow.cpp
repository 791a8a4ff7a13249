#include "validation/harness/flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/snapshot.hpp"

namespace mpm::validation {
namespace {

constexpr double below = -1e4;  // m: solids reach down to the floor

/// Box that a solid cuts out of the plane y = 0: x_min, z_min, x_max, z_max; empty where it does not meet that plane.
using Section = std::optional<std::array<double, 4>>;
Section section(const RigidBox& box) {
  if (box.min.y() > 0.0 || box.max.y() < 0.0) return {};
  return std::array{box.min.x(), box.min.z(), box.max.x(), box.max.z()};
}
Section section(const RigidCylinder& c) {
  if (std::abs(c.centre_y) >= c.radius) return {};
  const double half = std::sqrt(c.radius * c.radius - c.centre_y * c.centre_y);
  return std::array{c.centre_x - half, below, c.centre_x + half, c.solid.top};
}
Section section(const RigidPrism& prism) {
  double low = prism.min_x, high = prism.max_x;
  for (const RigidPrism::Side& side : prism.sides) {  // n_x x <= offset
    if (side.normal_x < 0.0) low = std::max(low, side.offset / side.normal_x);
    if (side.normal_x > 0.0) high = std::min(high, side.offset / side.normal_x);
    if (side.normal_x == 0.0 && side.offset < 0.0) return {};
  }
  if (!(low < high)) return {};
  return std::array{low, below, high, prism.solid.top};
}

Section section(const SurfaceSolid& solid) {
  const Outline& outline = solid.outline();
  if (const auto& c = outline.circle) {
    if (std::abs(c->centre.y()) >= c->radius) return {};
    const double half = std::sqrt(c->radius * c->radius - c->centre.y() * c->centre.y());
    return std::array{c->centre.x() - half, below, c->centre.x() + half, solid.top()};
  }
  double low = below, high = -below;
  for (const OutlineSide& side : outline.sides()) {  // n_x x <= offset
    const double offset = side.normal.dot(side.from), n_x = side.normal.x();
    if (n_x < -on_surface) low = std::max(low, offset / n_x);
    if (n_x > on_surface) high = std::min(high, offset / n_x);
    if (std::abs(n_x) <= on_surface && offset < 0.0) return {};
  }
  if (!(low < high)) return {};
  return std::array{low, below, high, solid.top()};
}

/// Section of the boundaries with the plane y = 0. Walls that run along it are not seen.
void add_boundaries(FlowPicture& picture, const Scene& scene) {
  for (const Boundary& boundary : scene.boundaries) {
    if (const auto* wall = std::get_if<Wall>(&boundary)) {
      const Vec3 point = wall->travels ? Vec3(wall->point + picture.time * wall->velocity) : wall->point;
      const Vec3& n = wall->normal;
      if (std::hypot(n.x(), n.z()) > 1e-6) picture.walls.push_back({point.x(), point.z(), n.x(), n.z()});
    }
    const Section solid = std::visit(
        [](const auto& b) -> Section {
          if constexpr (requires { section(b); }) return section(b);
          return {};
        },
        boundary);
    if (solid) picture.boxes.push_back(*solid);
  }
}

}  // namespace

std::string to_string(FlowField field) {
  switch (field) {
    case FlowField::speed: return "speed";
    case FlowField::velocity_x: return "velocity_x";
    case FlowField::velocity_z: return "velocity_z";
    case FlowField::pressure: return "pressure";
    case FlowField::stress_xx: return "stress_xx";
    case FlowField::density: return "density";
  }
  return "unknown";
}

FlowPicture flow_picture(const std::filesystem::path& directory, const State& state, const Scene& scene, FlowPicture picture) {
  const double half_width = picture.slice_half_width;
  const ParticleTable particles =
      particle_table(state, scene, [half_width](const Particle& p) { return half_width <= 0.0 || std::abs(p.position[1]) <= half_width; });
  SnapshotInfo info;
  info.time = picture.time = state.time;
  info.step = static_cast<std::int64_t>(state.step);
  info.version = build_info().version;
  info.reference_density = density_of(scene.material);
  info.mirror_x = scene.mirror.x;
  info.mirror_y = scene.mirror.y;
  const std::filesystem::path folder = directory / fmt::format("flow-{}", picture.id);
  make_directory(folder);
  write_frame(folder, 0, particles, info);
  picture.snapshot = frame_path(folder, 0);
  add_boundaries(picture, scene);
  return picture;
}

FlowPicture flow_picture_of_run(const std::filesystem::path& run_directory, int index, const Case& c, FlowPicture picture) {
  picture.snapshot = frame_path(run_directory, index);
  picture.time = hdf5::Reader(picture.snapshot).real("time_s");
  add_boundaries(picture, make_scene(c));
  return picture;
}

}  // namespace mpm::validation
