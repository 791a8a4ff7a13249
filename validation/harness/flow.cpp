#include "validation/harness/flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/snapshot.hpp"

namespace mpm::validation {
namespace {

constexpr double beyond = 1e4;  // m: solids may have no underside, or no top

/// Section of the boundaries with the plane y = 0. Walls that run along it are not seen.
void add_boundaries(FlowPicture& picture, const Scene& scene) {
  for (const Boundary& boundary : scene.boundaries) {
    if (const auto* wall = std::get_if<Wall>(&boundary)) {
      const Vec3 point = wall->travels ? Vec3(wall->point + picture.time * wall->velocity) : wall->point;
      const Vec3& n = wall->normal;
      if (std::hypot(n.x(), n.z()) > 1e-6) picture.walls.push_back({point.x(), point.z(), n.x(), n.z()});
    }
    const UprightSolid* const solid = geometry_of(boundary);
    if (const auto along = solid != nullptr ? solid->outline.section(0.0) : std::nullopt)
      picture.boxes.push_back({along->low, std::max(-beyond, solid->base), along->high, std::min(beyond, solid->top)});
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
  frame_writer(folder, 0, info).write(particles);
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
