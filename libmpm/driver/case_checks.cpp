#include "libmpm/driver/case_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmpm/base/error.hpp"
#include "libmpm/base/parameter.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/driver/terrain_raster.hpp"
#include "libmpm/impact/conveyor.hpp"
#include "libmpm/impact/inflow.hpp"

namespace mpm {

namespace {

/// What mirror planes do not bear: a shift of the scene against the grid, and what drives material across them.
void check_mirror_planes(const Case& c, ParameterReport& report) {
  if (!report.all_valid({"numerics.grid_offset_cells", "conveyor.mirror_y", "domain.mirror"})) return;
  TableReport own(report, "numerics");
  check_grid_offset(c, own);
  const MirrorPlanes mirror = mirror_planes(c);
  if (mirror.x && report.valid("numerics.slope_deg") && c.numerics.slope != 0.0)
    report.problem("numerics.slope_deg", "drives the material across the mirror plane x = 0; leave one of the two out");
  for (int axis = 0; axis < 2; ++axis) {
    for (std::size_t w = 0; mirror.across(axis) && w < c.walls.size(); ++w) {
      const std::string key = fmt::format("wall[{}].velocity_m_s", w);
      if (report.valid(key) && c.walls[w].velocity[axis] != 0.0)
        report.problem(key, fmt::format("moves across the mirror plane {} = 0; leave one of the two out", "xy"[axis]));
    }
  }
}

/// The filter's window is an odd number of bins, whose default height is that of the grid, and at least those that its parabola needs.
void check_measurement(const MeasurementSpec& measurement, double cell_size, ParameterReport& report) {
  const std::string name = "measurement.filter_length_m";
  if (!measurement.filter_length || !report.all_valid({name, "measurement.bin_height_m", "numerics.cell_size_m"})) return;
  const double length = *measurement.filter_length, bin = measurement.bin_height.value_or(0.5 * cell_size), bins = length / bin;
  constexpr double most_bins = 9999.0;
  if (bins > most_bins) {
    return report.problem(
        name, fmt::format("= {} is {:.6g} bins of {} m, more than {}; give a shorter filter or higher bins", length, bins, bin, most_bins));
  }
  const double odd = std::max(3.0, 2.0 * std::round(0.5 * (bins - 1.0)) + 1.0);
  constexpr double rounding = 1e-6;  // of lengths given to six digits
  if (std::abs(bins - odd) > rounding * odd) {
    report.problem(name, fmt::format("= {} is {:.6g} bin{} of {} m; give an odd number of bins, at least 3, such as {:.6g} m", length, bins,
                                     std::abs(bins - 1.0) < rounding ? "" : "s", bin, odd * bin));
  }
}

/// Friction of the obstacle as a part of the material's.
void resolve_obstacle_friction(ObstacleSpec& obstacle, const MaterialParameters& material, ParameterReport& report) {
  for (const auto& p : parameters_of<MaterialParameters>().all()) {
    if (!report.valid("material." + p.info.name)) return;
  }
  TableReport own(report, "obstacle");
  obstacle.resolve_friction(material, own);
}

/// Numerics of a flow against an obstacle unless the case gives them: four tenths of the steps, half the memory of a particle. With AFLIP
/// both change less than the grid does (docs/design.md "Time step", docs/precision.md). The other transfers lose energy in every step, and
/// other laws do not yield before a longer step makes them unstable.
void resolve_numerics(Case& c, const ParameterReport& report) {
  if (!c.conveyor || !c.obstacle) return;
  if (!report.given("numerics.cfl") && c.numerics.transfer == Transfer::aflip && c.material.keeps_compaction()) c.numerics.cfl = 1.0;
  if (!report.given("numerics.precision")) c.numerics.precision = Precision::single_precision;
}

/// Whether a body at rest fills the space between walls or mirror planes on four sides, on a floor: it cannot spread.
bool is_enclosed(const Case& c, const BodySpec& body) {
  if (body.shape != BodySpec::Shape::box || !body.velocity.isZero(0.0)) return false;
  const double rounding = 1e-9 * (body.max - body.min).maxCoeff();
  const auto is_held = [&](int axis, double face, double inwards) {
    const bool mirror = axis == 0 ? c.domain.mirror_x : axis == 1 && c.domain.mirror_y;
    if (mirror && inwards > 0.0 && face <= rounding) return true;
    return std::ranges::any_of(c.walls, [&](const WallSpec& wall) {
      return inwards * wall.normal[axis] > 1.0 - 1e-9 && std::abs(wall.point[axis] - face) <= rounding;
    });
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (!is_held(axis, body.min[axis], 1.0) || (axis < 2 && !is_held(axis, body.max[axis], -1.0))) return false;
  }
  return true;
}

/// The arm against the obstacle that carries it, and against the belt.
void check_arm(const Case& c, ParameterReport& report) {
  if (!c.arm) return;
  if (!c.obstacle) {
    if (report.valid("obstacle")) report.problem("arm", "is given without an obstacle to carry it; give [obstacle]");
    return;
  }
  if (!ObstacleSpec::plan_is_valid(TableReport(report, "obstacle")) || !report.valid("obstacle.height_m")) return;
  TableReport own(report, "arm");
  c.arm->check_on(*c.obstacle, "obstacle", own);
  if (c.conveyor && report.all_valid({"arm.length_m", "conveyor.width_m"}) && c.arm->length >= c.conveyor->width) {
    report.problem("arm.length_m", fmt::format("= {} reaches the side walls of the belt, {:.6g} m; give a shorter one, or a larger "
                                               "conveyor.width_m",
                                               c.arm->length, c.conveyor->width));
  }
}

/// A body against grid, domain and obstacle. @param path  of its entry, "body[0]"
void check_body(const Case& c, const BodySpec& body, const std::string& path, ParameterReport& report) {
  const std::string low = path + ".min_m", high = path + ".max_m";
  if (!report.all_valid({low, high})) return;
  const bool cell_size_valid = report.valid("numerics.cell_size_m");
  const double thinnest = (body.max - body.min).minCoeff(), cell_size = c.numerics.cell_size, spacing = c.numerics.particle_spacing();
  constexpr double slack = 1.0 - 1e-9;  // rounding of the corners
  if (cell_size_valid && report.valid("numerics.particles_per_cell") && thinnest < spacing * slack) {
    report.problem(high, fmt::format("- min_m is {:.9g} m at the thinnest, less than the distance of particles, {:.9g} m; give a larger "
                                     "body or finer cells",
                                     thinnest, spacing));
  }
  constexpr double reach = 4.0e6;  // cells from the origin: 2^20 blocks of four, with some room
  const double farthest = std::max(body.max.cwiseAbs().maxCoeff(), body.min.cwiseAbs().maxCoeff());
  if (cell_size_valid && farthest > reach * cell_size) {
    report.problem(high, fmt::format("or min_m is {:.9g} m from the origin, beyond the {:g} cells of {:.9g} m that the grid reaches; move "
                                     "the scene to the origin, or take larger cells",
                                     farthest, reach, cell_size));
  }
  if (report.all_valid({"domain.min_m", "domain.max_m"}) &&
      ((body.min.array() < c.domain.min.array()).any() || (body.max.array() > c.domain.max.array()).any()))
    report.problem(high, "or min_m lies outside [domain]; enlarge the domain or move the body");
  if (!c.obstacle || !ObstacleSpec::plan_is_valid(TableReport(report, "obstacle")) ||
      !report.all_valid({"obstacle.height_m", "obstacle.base_m", path + ".shape"}))
    return;
  std::vector<UprightSolid> solids = solids_of(c);
  if (!report.all_valid({"arm.length_m", "arm.depth_m", "arm.base_m", "arm.height_m"})) solids.erase(solids.begin() + 1, solids.end());
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (meets_solid(body, solids[i]))
      report.problem(high, fmt::format("and min_m reach into the {0}; move the body, it may touch the {0}", i == 0 ? "obstacle" : "arm"));
  }
}

/// A custom scene, or a conveyor, which brings its own.
void check_scene(const Case& c, ParameterReport& report) {
  if (c.conveyor) {
    for (const auto& [table, count] : {std::pair{"body", c.bodies.size()}, {"wall", c.walls.size()}}) {
      for (std::size_t i = 0; i < count; ++i)
        report.problem(fmt::format("{}[{}]", table, i), "is given beside [conveyor], which brings its own; leave out one of the two");
    }
  } else if (c.bodies.empty() && report.valid("body")) {
    report.problem("", "the scene is empty; give [conveyor], or at least one [[body]]");
  }
  for (std::size_t i = 0; i < c.bodies.size(); ++i) check_body(c, c.bodies[i], fmt::format("body[{}]", i), report);
  const auto valid = [&](std::size_t i) {
    return report.all_valid({fmt::format("body[{}].min_m", i), fmt::format("body[{}].max_m", i), fmt::format("body[{}].shape", i)});
  };
  for (std::size_t i = 1; i < c.bodies.size(); ++i) {
    const auto other = std::ranges::find_if(c.bodies.begin(), c.bodies.begin() + static_cast<std::ptrdiff_t>(i),
                                            [&](const BodySpec& earlier) { return overlap(earlier, c.bodies[i]); });
    const auto j = static_cast<std::size_t>(other - c.bodies.begin());
    if (j < i && valid(i) && valid(j)) {
      report.problem(
          fmt::format("body[{}].max_m", i),
          fmt::format("and min_m: the body overlaps body[{}], so that the snow there would count twice; move or cut one of them", j));
    }
  }
}

/// Whether a case is valid in all that its domain follows from.
bool domain_is_valid(const Case& c, const ParameterReport& report) {
  if (!report.all_valid({"domain", "domain.min_m", "domain.max_m", "domain.mirror", "numerics.cell_size_m", "numerics.gravity_m_s2",
                         "output.duration_s", "obstacle.width_m", "material.hardening_xi"}))
    return false;
  if (!c.conveyor) return true;
  const auto valid = [&](const auto& p) { return report.valid("conveyor." + p.info.name); };
  return report.all_valid({"conveyor", "conveyor.inflow"}) && std::ranges::all_of(parameters_of<ConveyorSpec>().all(), valid);
}

using Ground = std::shared_ptr<const HeightField>;

/// Uneven ground; empty without, and where it is not valid.
Ground ground_of(const Case& c, const ParameterReport& report) {
  const bool valid = c.terrain && c.terrain->raster && report.all_valid({"terrain", "terrain.file", "terrain.raster"});
  return valid ? height_field(*c.terrain) : nullptr;
}

/// Corners that the case leaves out do not cut off a part of a belt: ground at its true altitude, a long strip.
void resolve_domain(Case& c, const Ground& ground, const ParameterReport& report) {
  if (!c.conveyor || (c.terrain && !ground) || !domain_is_valid(c, report)) return;
  const Eigen::AlignedBox3d belt = conveyor_domain(*c.conveyor, conveyor_setting(c, ground));
  if (!report.given("domain.min_m")) c.domain.min = c.domain.min.cwiseMin(belt.min());
  if (!report.given("domain.max_m")) c.domain.max = c.domain.max.cwiseMax(belt.max());
}

/// Uneven ground against domain, mirror planes and conveyor.
void check_terrain(const Case& c, const Ground& ground, ParameterReport& report) {
  if (!ground) return;
  if (c.conveyor && c.conveyor->sidewall_contact != Contact::slip && report.valid("conveyor.sidewall_contact")) {
    report.problem("terrain",
                   "is given beside side walls that drag the snow along x, and so into a slope; give "
                   "conveyor.sidewall_contact = \"slip\"");
  }
  if (c.conveyor && c.conveyor->slip_ratio < 1.0 && report.valid("conveyor.inflow_slip_ratio"))
    report.problem("terrain", "is given beside conveyor.inflow_slip_ratio, which refers to a level floor; leave out one of the two");
  if (!domain_is_valid(c, report)) return;
  const std::string key = report.given("terrain.file") ? "terrain.file" : "terrain.raster";
  if (c.obstacle && ObstacleSpec::plan_is_valid(TableReport(report, "obstacle")) && report.valid("obstacle.height_m")) {
    const UprightSolid solid = c.obstacle->solid();
    const double height = ground->at(solid.outline.centre()).height;
    if (height >= solid.top || (c.conveyor && std::abs(height) > c.conveyor->flow_height)) {
      report.problem(
          key,
          fmt::format(
              "puts the ground at z = {0:.6g} m where the obstacle stands; top of the obstacle, run-up and pressures count from z = 0, "
              "subtract {0:.6g} m from all heights",
              height));
    }
  }
  const MirrorPlanes mirror = mirror_planes(c);
  const Eigen::AlignedBox3d domain = case_domain(c, ground);
  Vec2 low = domain.min().head<2>(), high = domain.max().head<2>();
  for (const auto& [axis, mirrored] : {std::pair{0, mirror.x}, {1, mirror.y}}) {
    if (mirrored) low[axis] = std::min(low[axis], -high[axis]);
  }
  for (const std::string& problem : terrain_problems(*ground, low, high, mirror)) report.problem(key, problem);
}

/// A run ends with a row of series.csv, later than asked.
void check_rows(const OutputSpec& output, ParameterReport& report) {
  const std::string name = "output.series_per_second";
  constexpr double least = 0.1;  // rows up to the duration
  if (!report.all_valid({name, "output.duration_s"}) || output.duration * output.series_per_second >= least) return;
  report.problem(name, fmt::format("= {} has its first row long after output.duration_s = {} s; give at least {:.6g}",
                                   output.series_per_second, output.duration, 1.0 / output.duration));
}

/// What a run of a conveyor computes before its first step: the weight of the snow at rest, and the windows of the measurements.
void check_start(const Case& c, ParameterReport& report) {
  if (!c.conveyor || !domain_is_valid(c, report)) return;
  for (const auto& p : parameters_of<MaterialParameters>().all()) {
    if (!report.valid("material." + p.info.name)) return;
  }
  const double height = std::max(c.conveyor->flow_height, Inflow(*c.conveyor).highest());
  constexpr int layers = 8;
  try {
    settled_column(make_material(c.material), c.material.density() * c.numerics.gravity, height, layers);
  } catch (const UnstableError&) {
    report.problem("material",
                   fmt::format("cannot carry its own weight over conveyor.flow_height_m = {:.6g} m; give a stiffer one", height));
  }
  if (!c.obstacle || !ObstacleSpec::plan_is_valid(TableReport(report, "obstacle")) ||
      !report.all_valid({"measurement.bin_height_m", "measurement.filter_length_m"}))
    return;
  try {
    (void)impact_geometry(c);
  } catch (const ConfigError& error) {
    report.problem(report.given("measurement.bin_height_m") ? "measurement.bin_height_m" : "numerics.cell_size_m", error.what());
  }
}

/// A given domain leaves in the snow between inlet and outlet, on uneven ground along the middle of the belt.
void check_domain_of_conveyor(const Case& c, const Ground& ground, ParameterReport& report) {
  if (!c.conveyor || !domain_is_valid(c, report) || !report.valid("conveyor.width_m")) return;
  const ConveyorSpec& belt = *c.conveyor;
  const double half = 0.5 * belt.width;
  Eigen::AlignedBox3d needed(Vec3(0.0, belt.mirror_y ? 0.0 : -half, 0.0), Vec3(0.0, half, belt.flow_height));
  if (belt.feed == ConveyorSpec::Feed::window) {
    needed.min().x() = -belt.upstream_length;
    needed.max().x() = belt.downstream_length;
  }
  if (ground) {
    const auto [low, high] = std::minmax(
        {ground->at({needed.min().x(), 0.0}).height, ground->at({0.0, 0.0}).height, ground->at({needed.max().x(), 0.0}).height});
    needed.min().z() = low;
    needed.max().z() = high + belt.flow_height;
  }
  const int axes = c.terrain && !ground ? 2 : 3;  // the height of ground that is not valid is not known
  constexpr double rounding = 1e-9;
  for (const auto& [key, outside, low] : {std::tuple{"domain.min_m", Vec3(c.domain.min - needed.min()), true},
                                          std::tuple{"domain.max_m", Vec3(needed.max() - c.domain.max), false}}) {
    int axis = 0;
    if (!report.given(key) || outside.head(axes).maxCoeff(&axis) <= rounding) continue;
    report.problem(key, fmt::format("cuts off a part of the flow that [conveyor] feeds; give {} {:.6g} m in {}",
                                    low ? "at most" : "at least", low ? needed.min()[axis] : needed.max()[axis], "xyz"[axis]));
  }
}

/// Means belong to one state of a flow that meets an obstacle.
void check_stop(const Case& c, ParameterReport& report) {
  const std::string name = "output.stop_when_steady";
  if (!report.all_valid({name, "obstacle", "conveyor"}) || c.output.stop_when_steady == 0.0 || !c.conveyor) return;
  if (!c.obstacle) {
    report.problem(name, fmt::format("= {} has no obstacle to wait for; give [obstacle], or leave the key out", c.output.stop_when_steady));
  } else if (!c.conveyor->inflow.empty()) {
    report.problem(name, fmt::format("= {} needs a steady inflow, and [[conveyor.inflow]] varies it; leave out one of the two",
                                     c.output.stop_when_steady));
  }
}

}  // namespace

void DomainSpec::check(ParameterReport& report) const {
  for (int axis = 0; axis < 3 && report.all_valid({"min_m", "max_m"}); ++axis) {
    if (!(min[axis] < max[axis]))
      report.problem("max_m", fmt::format("is not above min_m in {}: {} <= {}; exchange them", "xyz"[axis], max[axis], min[axis]));
  }
}

void resolve_case(Case& c, ParameterReport& report) {
  resolve_numerics(c, report);
  check_mirror_planes(c, report);
  check_measurement(c.measurement, c.numerics.cell_size, report);
  const ObstacleSpec* const obstacle = c.obstacle ? &*c.obstacle : nullptr;
  if (c.obstacle) resolve_obstacle_friction(*c.obstacle, c.material, report);
  for (std::size_t i = 0; i < c.bodies.size(); ++i) {  // in a body that stays at rest, the pressures on a staggered lattice drift apart
    if (!report.given(fmt::format("body[{}].lattice", i)) && is_enclosed(c, c.bodies[i])) c.bodies[i].lattice = Lattice::aligned;
  }
  if (!report.valid("conveyor")) return;
  if (c.conveyor) resolve_conveyor(*c.conveyor, {c.numerics.cell_size, c.numerics.gravity, c.material, obstacle}, report);
  check_arm(c, report);
  check_scene(c, report);
  const Ground ground = ground_of(c, report);
  resolve_domain(c, ground, report);
  check_terrain(c, ground, report);
  check_stop(c, report);
  check_rows(c.output, report);
  check_domain_of_conveyor(c, ground, report);
  check_start(c, report);
}

}  // namespace mpm
