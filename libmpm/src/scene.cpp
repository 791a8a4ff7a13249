#include "mpm/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "mpm/error.hpp"
#include "mpm/impact/conveyor.hpp"
#include "mpm/obstacle.hpp"

namespace mpm {

namespace {

constexpr double beyond = 1e4;  // m; taller than anything

Wall make_wall(const WallSpec& spec) { return {spec.point, spec.normal.normalized(), spec.contact, spec.friction, spec.velocity, true}; }

Boundary make_obstacle(const ObstacleSpec& spec, double cell_size) {
  const double top = spec.height.value_or(beyond);
  if (has_flat_front(spec)) {
    return RigidBox{Vec3(0.0, -0.5 * spec.width, -beyond), Vec3(spec.depth, 0.5 * spec.width, top), Contact::separable, spec.friction,
                    Vec3::Zero()};
  }
  const Upright solid{top, 0.5 * cell_size, Contact::separable, spec.friction, Vec3::Zero()};
  const ObstaclePlan plan = obstacle_plan(spec);
  if (plan.radius) return RigidCylinder{solid, *plan.radius, 0.0, *plan.radius};
  RigidPrism prism{solid, {}, 0.0, plan.depth, -0.5 * plan.width, 0.5 * plan.width};
  for (const auto& side : plan.sides) prism.sides.push_back({side.normal.x(), side.normal.y(), side.normal.dot(side.from)});
  return prism;
}

/// Puts a boundary of the case where it stands in the solver.
void shift(Wall& wall, const Vec3& by) { wall.point += by; }
void shift(Belt& belt, const Vec3& by) { shift(belt.plane, by); }
void shift(RigidBox& box, const Vec3& by) {
  box.min += by;
  box.max += by;
  box.reference += by;
}
void shift(Upright& solid, const Vec3& by) {
  solid.top += by.z();
  solid.reference += by;
}
void shift(RigidPrism& prism, const Vec3& by) {
  shift(prism.solid, by);
  for (auto& side : prism.sides) side.offset += side.normal_x * by.x() + side.normal_y * by.y();
  for (double* x : {&prism.min_x, &prism.max_x}) *x += by.x();
  for (double* y : {&prism.min_y, &prism.max_y}) *y += by.y();
}
void shift(RigidCylinder& cylinder, const Vec3& by) {
  shift(cylinder.solid, by);
  cylinder.centre_x += by.x();
  cylinder.centre_y += by.y();
}

double shape_volume(const BodySpec& body) {
  const Vec3 size = body.max - body.min;
  switch (body.shape) {
    case BodySpec::Shape::cylinder: return 0.25 * std::numbers::pi * size.prod();
    case BodySpec::Shape::sphere: return std::numbers::pi / 6.0 * size.prod();
    case BodySpec::Shape::box: break;
  }
  return size.prod();
}

bool inside_shape(const BodySpec& body, const Vec3& x) {
  const Vec3 r = (2.0 * x - body.min - body.max).cwiseQuotient(body.max - body.min);  // -1 .. 1 within the bounding box
  switch (body.shape) {
    case BodySpec::Shape::cylinder: return r.head<2>().squaredNorm() <= 1.0;
    case BodySpec::Shape::sphere: return r.squaredNorm() <= 1.0;
    case BodySpec::Shape::box: break;
  }
  return true;
}

void fill_body(State& state, const BodySpec& body, const Scene& scene, double spacing) {
  const Vec3 size = body.max - body.min;
  std::array<long, 3> count{};
  Vec3 step;
  for (int i = 0; i < 3; ++i) {
    count[static_cast<std::size_t>(i)] = std::max(1L, std::lround(size[i] / spacing));
    step[i] = size[i] / static_cast<double>(count[static_cast<std::size_t>(i)]);
  }
  struct Point {
    Vec3 x;
    double share;  ///< of its volume in the computed part: a half on a mirror plane, to which its image adds the other
  };
  const double on_plane = 1e-9 * spacing;  // lattice points are sums of rounded numbers
  std::vector<Point> points;
  std::size_t whole = 0;
  for (long k = 0; k < count[2]; ++k) {
    for (long j = 0; j < count[1]; ++j) {
      for (long i = 0; i < count[0]; ++i) {
        Vec3 x =
            body.min + step.cwiseProduct(Vec3(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5, static_cast<double>(k) + 0.5));
        if (!inside_shape(body, x)) continue;
        ++whole;
        double share = 1.0;
        for (const auto& [mirror, coordinate] : {std::pair{scene.mirror_x, &x.x()}, std::pair{scene.mirror_y, &x.y()}}) {
          if (!mirror || *coordinate > on_plane) continue;
          share *= *coordinate < -on_plane ? 0.0 : 0.5;
          *coordinate = 0.0;
        }
        if (share > 0.0) points.push_back({x, share});
      }
    }
  }
  if (whole == 0) throw ConfigError("[[body]] shape: not one particle fits into it; use a smaller [numerics] cell_size_m");
  const double volume = shape_volume(body) / static_cast<double>(whole);
  const double internal = initial_internal_of(scene.material);
  for (const auto& [x, share] : points) {
    Particle p{};
    for (int i = 0; i < 3; ++i) {
      p.position[i] = x[i] + scene.offset[i];
      p.velocity[i] = body.velocity[i];
    }
    p.volume = share * volume;
    p.internal = internal;
    p.id = state.next_id++;
    state.grid.insert(p);
  }
  state.max_speed = std::max(state.max_speed, body.velocity.norm());
}

}  // namespace

double lattice_spacing(const NumericsSpec& numerics) {
  return numerics.cell_size / std::cbrt(static_cast<double>(numerics.particles_per_cell));
}

Scene make_scene(const Case& c) {
  Scene scene{.material = make_material(c.material)};
  scene.domain_min = c.domain.min;
  scene.domain_max = c.domain.max;
  scene.mirror_x = c.domain.mirror_x;
  scene.mirror_y = c.domain.mirror_y;
  scene.transfer = c.numerics.transfer;
  scene.flip_ratio = c.numerics.flip_ratio;
  scene.cfl = c.numerics.cfl;
  scene.gravity = c.numerics.gravity * Vec3(std::sin(c.numerics.slope), 0.0, -std::cos(c.numerics.slope));
  for (const WallSpec& wall : c.walls) scene.boundaries.emplace_back(make_wall(wall));
  if (c.conveyor) {
    Vec3 min, max;
    conveyor_domain(c, min, max);
    scene.domain_min = scene.domain_min.cwiseMax(min);
    scene.domain_max = scene.domain_max.cwiseMin(max);
    if (c.domain.mirror_x || c.domain.mirror_y) throw ConfigError("[domain] mirror: with a [conveyor], use [conveyor] mirror_y");
    scene.mirror_y = c.conveyor->mirror_y;
    for (auto& wall : conveyor_walls(*c.conveyor)) scene.boundaries.push_back(std::move(wall));
    scene.feed = std::make_shared<ConveyorFeed>(c, scene.material);
  }
  if (c.obstacle) {
    scene.obstacle = scene.boundaries.size();
    if (scene.mirror_y && !obstacle_plan(*c.obstacle).symmetric) {
      throw ConfigError(
          fmt::format("[obstacle] rotation_deg: the box turned by {:.4g} degrees is not symmetric about y = 0, and half of "
                      "the domain cannot stand for the whole; give mirror_y = false",
                      c.obstacle->rotation * 180.0 / std::numbers::pi));
    }
    scene.boundaries.push_back(make_obstacle(*c.obstacle, c.numerics.cell_size));
  }
  scene.offset = c.numerics.cell_size * c.numerics.grid_offset;
  if ((scene.mirror_x && scene.offset.x() != 0.0) || (scene.mirror_y && scene.offset.y() != 0.0))
    throw ConfigError("[numerics] grid_offset_cells: a mirror plane has to stay on the grid; give 0 along its axis");
  scene.domain_min += scene.offset;
  scene.domain_max += scene.offset;
  for (Boundary& boundary : scene.boundaries) std::visit([&](auto& b) { shift(b, scene.offset); }, boundary);
  return scene;
}

State make_state(const Case& c, const Scene& scene) {
  State state(c.numerics.cell_size);
  state.grid.keep_old_nodes(c.numerics.transfer == Transfer::flip);
  if (const auto* conveyor = dynamic_cast<const ConveyorFeed*>(scene.feed.get())) conveyor->fill(state);
  for (const BodySpec& body : c.bodies) fill_body(state, body, scene, lattice_spacing(c.numerics));
  state.grid.refresh();
  return state;
}

}  // namespace mpm
