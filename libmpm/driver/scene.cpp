#include "libmpm/driver/scene.hpp"

#include <fmt/format.h>

#include "libmpm/base/error.hpp"
#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/boundary/obstacle.hpp"
#include "libmpm/core/health.hpp"
#include "libmpm/core/joined_blocks.hpp"
#include "libmpm/driver/terrain_raster.hpp"
#include "libmpm/impact/conveyor.hpp"

namespace mpm {

namespace {

constexpr double above_all = 1e4;  // m; above every domain

Wall make_wall(const WallSpec& spec, ContactRule rule) {
  return {spec.point, spec.normal.normalized(), spec.contact, spec.friction, spec.velocity, true, rule};
}

Boundary make_obstacle(const ObstacleSpec& spec, const Numerics& numerics, const MirrorPlanes& mirror) {
  const double top = spec.height.value_or(above_all), cell_size = numerics.cell_size;
  if (numerics.contact == ContactRule::surface) {
    return SurfaceSolid(outline_of(spec.shape), top, spec.friction, Vec3::Zero(), cell_size, {mirror.x, mirror.y});
  }
  const ObstaclePlan plan = obstacle_plan(spec);
  if (plan.flat_front) {
    return RigidBox{Vec3(0.0, -0.5 * plan.width, -above_all), Vec3(plan.depth, 0.5 * plan.width, top), Contact::separable, spec.friction,
                    Vec3::Zero()};
  }
  const VerticalSolid solid{top, 0.5 * cell_size, Contact::separable, spec.friction, Vec3::Zero()};
  const Outline outline = outline_of(spec.shape);
  if (outline.circle) return RigidCylinder{solid, *outline.circle};
  return RigidPrism{solid, outline.half_planes(), 0.0, plan.depth, -0.5 * plan.width, 0.5 * plan.width};
}

ConveyorSetting conveyor_setting(const Case& c, const std::shared_ptr<const HeightField>& ground) {
  return {.cell_size = c.numerics.cell_size,
          .particle_spacing = c.numerics.particle_spacing(),
          .gravity = c.numerics.gravity,
          .slope = c.numerics.slope,
          .duration = c.output.duration,
          .offset = c.numerics.offset(),
          .ground = ground};
}

}  // namespace

MirrorPlanes mirror_planes(const Case& c) { return {c.domain.mirror_x, c.domain.mirror_y || (c.conveyor && c.conveyor->mirror_y)}; }

CaseDomain case_domain(const Case& c, const std::shared_ptr<const HeightField>& ground) {
  CaseDomain domain{c.domain.min, c.domain.max};
  if (!c.conveyor) return domain;
  Vec3 min, max;
  conveyor_domain(*c.conveyor, conveyor_setting(c, ground), min, max);
  return {domain.min.cwiseMax(min), domain.max.cwiseMin(max)};
}

CaseScene make_scene(const Case& c) {
  CaseScene scene{{.material = make_material(c.material, c.numerics.precision)}, {}, {}};
  const std::shared_ptr<const HeightField> ground = c.terrain ? height_field(*c.terrain) : nullptr;
  const CaseDomain domain = case_domain(c, ground);
  scene.domain_min = domain.min;
  scene.domain_max = domain.max;
  scene.mirror = mirror_planes(c);
  scene.numerics = c.numerics;
  scene.gravity = c.numerics.gravity_vector();
  for (const WallSpec& wall : c.walls) scene.boundaries.emplace_back(make_wall(wall, c.numerics.contact));
  if (c.terrain) {
    scene.terrain = scene.boundaries.size();
    scene.boundaries.emplace_back(Terrain{ground, c.terrain->contact, c.terrain->friction, c.terrain->speed, c.numerics.contact});
  }
  if (c.conveyor) {
    if (c.domain.mirror_x || c.domain.mirror_y) throw ConfigError("[domain] mirror: with a [conveyor], use [conveyor] mirror_y");
    for (auto& wall : conveyor_walls(*c.conveyor, c.numerics.contact, !c.terrain)) scene.boundaries.push_back(std::move(wall));
    scene.source = std::make_shared<ConveyorSource>(*c.conveyor, scene.material, conveyor_setting(c, ground));
  }
  if (c.obstacle) {
    scene.obstacle = scene.boundaries.size();
    scene.layered = {*scene.obstacle};
    if (scene.mirror.y && !obstacle_plan(*c.obstacle).symmetric) {
      throw ConfigError(
          "[obstacle]: its plan is not symmetric about y = 0, so that half of the domain cannot replace the whole; give mirror_y = false");
    }
    scene.boundaries.push_back(make_obstacle(*c.obstacle, c.numerics, scene.mirror));
  }
  scene.offset = c.numerics.offset();
  detail::CollectedProblems problems;
  c.numerics.check_offset(scene.mirror, problems);
  problems.throw_if_any();
  scene.domain_min += scene.offset;
  scene.domain_max += scene.offset;
  for (Boundary& boundary : scene.boundaries) std::visit([&](auto& b) { b.translate(scene.offset); }, boundary);
  return scene;
}

namespace {

void fill(State& state, const Case& c, const Scene& scene) {
  if (scene.source) scene.source->fill(state);
  for (const BodySpec& body : c.bodies) {
    if (fill_body(state, body, scene, c.numerics.particle_spacing()) == 0)
      throw ConfigError(
          "[[body]] shape: not one particle fits into it, or above the ground; use a smaller [numerics] cell_size_m, or move it");
  }
}

/// How many particles each block will hold; on the first rank.
std::vector<BlockHead> particles_of_blocks(const Case& c, const Scene& scene, Ranks& ranks) {
  State state(c.numerics.cell_size, c.numerics.precision);
  state.grid.divide(&ranks);
  ranks.count_blocks();
  fill(state, c, scene);
  return ranks.counted_blocks();
}

}  // namespace

State make_state(const Case& c, const Scene& scene, Ranks* ranks) {
  State state(c.numerics.cell_size, c.numerics.precision);
  if (ranks != nullptr) {
    std::vector<BlockHead> heads;
    if (ranks->first())
      heads = particles_of_blocks(c, scene, *ranks);  // an error in the case ends the run here, where the others wait for no answer
    ranks->instruct(Task::start, state);
    ranks->cut(JoinedBlocks(scene, c.numerics.cell_size, state.time), heads);
    state.grid.divide(ranks);
  }
  fill(state, c, scene);
  state.grid.refresh();
  if (ranks != nullptr) ranks->done();
  return state;
}

std::vector<std::string> particles_inside_boundaries(const State& state, const CaseScene& scene) {
  Ranks* const ranks = state.grid.ranks();
  if (ranks != nullptr) ranks->instruct(Task::inside, state);
  std::vector<std::string> warnings;
  for (std::size_t b = 0; b < scene.boundaries.size(); ++b) {
    if (scene.source && b != scene.obstacle) continue;
    const HeldParticles held = particles_inside(state, scene, scene.boundaries[b]);
    if (held.count == 0) continue;
    const std::string which = b == scene.obstacle  ? "the [obstacle]"
                              : b == scene.terrain ? "the [terrain]"
                                                   : fmt::format("[[wall]] number {}", b + 1);
    warnings.push_back(fmt::format("warning: {} {} inside {}, which holds {}, {} for one; move the [[body]] out of it, or the boundary",
                                   counted(held.count, "particle"), held.count == 1 ? "is" : "are", which, held.count == 1 ? "it" : "them",
                                   held.first));
  }
  if (ranks != nullptr) ranks->done();
  return warnings;
}

}  // namespace mpm
