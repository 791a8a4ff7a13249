#include "libmpm/driver/scene.hpp"

#include <fmt/format.h>

#include <map>
#include <type_traits>

#include "libmpm/base/error.hpp"
#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/core/health.hpp"
#include "libmpm/driver/terrain_raster.hpp"
#include "libmpm/impact/conveyor.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "libmpm/parallel/joined_blocks.hpp"

namespace mpm {

namespace {

Boundary make_solid(UprightSolid solid, double friction, const Numerics& numerics, const MirrorPlanes& mirror) {
  if (numerics.contact == ContactRule::surface) return SurfaceSolid(std::move(solid), friction, Vec3::Zero(), numerics.cell_size, mirror);
  const double skin = solid.outline.along_axes() ? 0.0 : 0.5 * numerics.cell_size;
  return NodalSolid{std::move(solid), skin, Contact::separable, friction, Vec3::Zero()};
}

}  // namespace

MirrorPlanes mirror_planes(const Case& c) { return {c.domain.mirror_x, c.domain.mirror_y || (c.conveyor && c.conveyor->mirror_y)}; }

std::vector<UprightSolid> solids_of(const Case& c) {
  std::vector<UprightSolid> solids;
  if (c.obstacle) solids.push_back(c.obstacle->solid());
  if (c.obstacle && c.arm) solids.push_back(c.arm->solid(*c.obstacle));
  return solids;
}

void check_grid_offset(const Case& c, ParameterReport& report) {
  const MirrorPlanes mirror = mirror_planes(c);
  for (int axis = 0; axis < 2; ++axis) {
    const double offset = c.numerics.grid_offset[axis];
    if (!mirror.across(axis) || offset == 0.0) continue;
    const std::string name(1, "xy"[axis]);
    report.problem("grid_offset_cells", "shifts the mirror plane " + name + " = 0 off the grid by " + number_text(offset) + " cells in " +
                                            name + "; give 0 there, or compute the whole without the mirror");
  }
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

Eigen::AlignedBox3d case_domain(const Case& c, const std::shared_ptr<const HeightField>& ground) {
  const Eigen::AlignedBox3d domain(c.domain.min, c.domain.max);
  return c.conveyor ? domain.intersection(conveyor_domain(*c.conveyor, conveyor_setting(c, ground))) : domain;
}

CaseScene make_scene(const Case& c) {
  CaseScene scene{{.material = make_material(c.material, c.numerics.precision)}, {}};
  const std::shared_ptr<const HeightField> ground = c.terrain ? height_field(*c.terrain) : nullptr;
  const Eigen::AlignedBox3d domain = case_domain(c, ground);
  scene.domain_min = domain.min();
  scene.domain_max = domain.max();
  scene.mirror = mirror_planes(c);
  scene.numerics = static_cast<const StepNumerics&>(c.numerics);
  scene.gravity = c.numerics.gravity_vector();
  BoundaryTables::for_each([&]<class T>() {
    const BoundarySetting setting{c.numerics.contact, ground};
    if constexpr (std::is_pointer_v<decltype(T::of(c))>) {
      for (const auto& entry : *T::of(c)) scene.boundaries.emplace_back(entry.boundary(setting));
    } else if (T::of(c)) {
      scene.boundaries.emplace_back(T::of(c)->boundary(setting));
    }
  });
  if (c.conveyor) {
    if (c.domain.mirror_x || c.domain.mirror_y) throw ConfigError("[domain] mirror: with a [conveyor], use [conveyor] mirror_y");
    for (auto& wall : conveyor_walls(*c.conveyor, c.numerics.contact, !c.terrain)) scene.boundaries.push_back(std::move(wall));
    scene.source = std::make_shared<ConveyorSource>(*c.conveyor, scene.material, conveyor_setting(c, ground));
  }
  if (c.obstacle && scene.mirror.y && !outline_of(c.obstacle->shape).symmetric()) {
    throw ConfigError(
        "[obstacle]: its plan is not symmetric about y = 0, so that half of the domain cannot replace the whole; give mirror_y = false");
  }
  for (UprightSolid& solid : solids_of(c)) {
    (scene.obstacle ? scene.arm : scene.obstacle) = scene.boundaries.size();
    scene.boundaries.push_back(make_solid(std::move(solid), c.obstacle->friction, c.numerics, scene.mirror));
  }
  if (scene.obstacle) scene.layered = {*scene.obstacle};
  scene.offset = c.numerics.offset();
  detail::CollectedProblems problems;
  check_grid_offset(c, problems);
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

/// Owns no block: a grid takes none of the particles, and they are counted.
class CountedBlocks : public OneRank {
 public:
  [[nodiscard]] bool owns(const Index3& block) const override { return ++counts_[block], false; }
  /// In the order of the blocks.
  [[nodiscard]] std::vector<BlockHead> heads() const {
    std::vector<BlockHead> heads;
    for (const auto& [block, count] : counts_) heads.push_back({block, count});
    return heads;
  }

 private:
  mutable std::map<Index3, std::int32_t, decltype([](const Index3& a, const Index3& b) { return comes_before(a, b); })> counts_;
};

/// How many particles each block will hold.
std::vector<BlockHead> particles_of_blocks(const Case& c, const Scene& scene) {
  CountedBlocks counted;
  State state(c.numerics.cell_size, c.numerics.precision);
  state.grid.divide(counted);
  fill(state, c, scene);
  return counted.heads();
}

}  // namespace

State make_state(const Case& c, const Scene& scene, BlockExchange* ranks) {
  State state(c.numerics.cell_size, c.numerics.precision);
  if (ranks != nullptr) {
    std::vector<BlockHead> heads;
    if (ranks->first())
      heads = particles_of_blocks(c, scene);  // an error in the case ends the run here, where the others wait for no answer
    ranks->instruct(Task::start, state);
    ranks->cut(JoinedBlocks(scene, c.numerics.cell_size, state.time), heads);
    state.grid.divide(*ranks);
  }
  fill(state, c, scene);
  state.grid.refresh();
  state.grid.ranks().done();
  return state;
}

std::vector<std::string> particles_inside_boundaries(const State& state, const CaseScene& scene) {
  Ranks& ranks = state.grid.ranks();
  ranks.instruct(Task::inside, state);
  std::vector<std::string> warnings;
  for (std::size_t b = 0; b < scene.boundaries.size(); ++b) {
    if (scene.source && b != scene.obstacle && b != scene.arm) continue;
    const BuriedParticles buried = buried_particles(state, scene, scene.boundaries[b]);
    if (buried.count == 0) continue;
    const std::string which = b == scene.obstacle                                    ? "the [obstacle]"
                              : b == scene.arm                                       ? "the [arm]"
                              : std::holds_alternative<Terrain>(scene.boundaries[b]) ? "the [terrain]"
                                                                                     : fmt::format("[[wall]] number {}", b + 1);
    warnings.push_back(fmt::format("warning: {} {} inside {}, which holds {}, {} for one; move the [[body]] out of it, or the boundary",
                                   counted(buried.count, "particle"), buried.count == 1 ? "is" : "are", which,
                                   buried.count == 1 ? "it" : "them", buried.first));
  }
  ranks.done();
  return warnings;
}

}  // namespace mpm
