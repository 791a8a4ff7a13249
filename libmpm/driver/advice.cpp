#include "libmpm/driver/advice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>

#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/driver/terrain_raster.hpp"
#include "libmpm/impact/conveyor.hpp"
#include "libmpm/impact/inflow.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/impact/steady.hpp"

namespace mpm {

namespace {

using Finding = std::optional<Advice>;

/// A case with a conveyor and an obstacle; most rules apply to these.
struct Impact {
  const Case& c;
  const ConveyorSpec& belt;
  const ObstacleSpec& mast;
  double speed;  ///< greatest of the inflow, m/s

  [[nodiscard]] double width() const { return mast.width(); }
  [[nodiscard]] double depth() const { return belt.flow_height; }
  [[nodiscard]] double dx() const { return c.numerics.cell_size; }
  [[nodiscard]] double froude() const { return belt.velocity / std::sqrt(c.numerics.gravity * depth()); }
  [[nodiscard]] double gravity() const { return c.numerics.gravity * std::cos(c.numerics.slope); }  ///< against which snow rises, m/s^2
  [[nodiscard]] double bound() const { return depth() + 0.5 * speed * speed / gravity(); }          ///< H + v^2/2g, Bernoulli's, m
  [[nodiscard]] double splash_time() const { return 2.0 * speed / gravity(); }
  [[nodiscard]] bool window() const { return belt.feed == ConveyorSpec::Feed::window; }
};

/// A number as text, with few digits.
std::string n(double x) { return fmt::format("{:.3g}", x); }
/// The same, rounded so that a bound that is recommended holds.
std::string at_most(double x) { return n(std::stod(n(x)) > x ? x * (1.0 - 4e-3) : x); }
std::string at_least(double x) { return n(std::stod(n(x)) < x ? x * (1.0 + 4e-3) : x); }

// ---- Resolution -------------------------------------------------------------------------------------------------------------------------

/// Grid errors by cells across: validation/cases/avalanche_convergence. Five cells for parameter studies, seven for single results: README.
Finding cells_across(const Impact& i) {
  const double least = 5.0, cells = std::min(i.width(), i.depth()) / i.dx();
  if (cells >= least - 1e-6) return {};
  const bool narrow = i.width() <= i.depth();
  const GridUncertainty u = grid_uncertainty(grid_resolution(i.c));
  const std::string known = std::isfinite(u.force)
                                ? fmt::format("at this resolution the force is known to about {:.0f} % and the run-up to {:.0f} %",
                                              100.0 * u.force, 100.0 * u.runup)
                                : "no grid study says how wrong force and run-up are here";
  return Advice{"cells_across", fmt::format("{} cells {}", n(cells), narrow ? "across the obstacle (w/dx)" : "in the flow height (H/dx)"),
                known + " (validation/cases/avalanche_convergence)",
                fmt::format("take numerics.cell_size_m = {} for a parameter study (5 cells), {} for a single result (7 cells)",
                            at_most(std::min(i.width(), i.depth()) / 5.0), at_most(std::min(i.width(), i.depth()) / 7.0))};
}

/// The force is proportional to the number of rows of nodes on the obstacle: validation/cases/avalanche_convergence,
/// "Contact on nodes". With contact at the surface the obstacle has its own width.
Finding nodal_width(const Impact& i) {
  if (i.c.numerics.contact != ContactRule::nodal || !outline_of(i.mast.shape).along_axes() || i.c.numerics.grid_offset.y() != 0.0)
    return {};
  constexpr double tolerance = 0.05;
  const double cells = i.width() / i.dx(), ratio = nodal_width_ratio(cells);
  if (std::abs(ratio - 1.0) <= tolerance) return {};
  const double odd = 2.0 * std::floor(0.5 * cells) + 1.0;
  return Advice{
      "nodal_width", fmt::format("{} cells across the obstacle (w/dx) with numerics.contact = \"nodal\"", n(cells)),
      fmt::format("{:.0f} rows of nodes stop the flow, so that the obstacle acts {} times as wide as it is, and the force is wrong by "
                  "about as much (validation/cases/avalanche_convergence)",
                  ratio * cells, n(ratio)),
      fmt::format("take an odd number of cells, numerics.cell_size_m = {}, or numerics.contact = \"surface\"", n(i.width() / odd))};
}

/// Gaps open where the obstacle spreads an aligned lattice: docs/cases.md, "Choosing the numerics".
Finding aligned_lattice(const Impact& i) {
  const double cells = i.width() / i.dx();
  const bool even = std::abs(0.5 * cells - std::round(0.5 * cells)) < 1e-6;
  if (i.belt.lattice != Lattice::aligned || i.c.numerics.contact != ContactRule::surface || !even) return {};
  return Advice{"aligned_lattice", fmt::format("conveyor.lattice = \"aligned\" with {} cells across the obstacle", n(cells)),
                "with an even number of cells thin jets come out up to a third too low (docs/cases.md)", "leave out lattice: staggered"};
}

/// Least distance between two parallel lines that hold an outline, m.
double thickness_of(const Outline& outline) {
  if (const auto circle = outline.circle()) return 2.0 * circle->radius;
  double least = std::numeric_limits<double>::infinity();
  for (const Outline::Side& side : outline.sides()) {
    double farthest = 0.0;
    for (const Outline::Side& other : outline.sides()) farthest = std::max(farthest, -side.distance(other.from));
    least = std::min(least, farthest);
  }
  return least;
}

/// The points of opposite sides act on the same nodes: seen at 0.17 cells, where particles pass through, and at 0.05, where the force is
/// 11 % too high.
Finding thin_obstacle(const Case& c) {
  if (!c.obstacle) return {};
  const double thickness = thickness_of(outline_of(c.obstacle->shape)), dx = c.numerics.cell_size;
  if (thickness >= dx * (1.0 - 1e-6)) return {};
  return Advice{"thin_obstacle", fmt::format("{} cells across the thinnest part of the obstacle", n(thickness / dx)),
                "snow passes through an obstacle that is thinner than a cell, and the force on it is wrong",
                fmt::format("take numerics.cell_size_m = {}, or a thicker obstacle with the same front", at_most(thickness))};
}

// ---- Time -------------------------------------------------------------------------------------------------------------------------------

/// impact_steady_criteria: no interval starts before 2 v/g, none is shorter than v/g, and a strip is constant for a part of the run only.
Finding splash_and_duration(const Impact& i) {
  if (i.c.numerics.gravity <= 0.0) return {};
  const double needed = 1.5 * i.splash_time(), duration = i.c.output.duration,
               constant = std::min(duration, constant_flow(i.belt, i.gravity(), duration).until);
  if (constant >= needed) return {};
  const std::string strip = i.window() ? "" : fmt::format(", of which the strip is not thinned from its rear for {} s", n(constant));
  const double longer = i.window() ? 1.0 : 1.0 + 1.0 / i.froude();
  return Advice{
      "splash_and_duration", fmt::format("output.duration_s = {} s{} against 2 v/g = {} s", n(duration), strip, n(i.splash_time())),
      fmt::format("the first splash is in the air for 2 v/g, and a steady interval has to last another v/g: a run of less than {} s has "
                  "no means, only the first impact",
                  n(longer * needed)),
      fmt::format("take output.duration_s = {} s or more; means get better with time", n(std::ceil(longer * i.splash_time() * 2.0)))};
}

/// Means are of one state of the flow (impact_steady_criteria).
Finding inflow_varies(const Impact& i) {
  const double until = constant_flow(i.belt, i.gravity(), i.c.output.duration).from;
  if (until == 0.0) return {};
  return Advice{"inflow_varies", fmt::format("the inflow at the obstacle varies until {} s", n(until)),
                fmt::format("output.duration_s = {} s: means{} are of the last row of the inflow, not of its strongest part",
                            n(i.c.output.duration), i.c.output.duration > until ? "" : ", of which there will be none,"),
                "take the peaks, or give each stage of the inflow a run of its own"};
}

/// Slow flows pile up over a distance, not a time: least_passage_heights.
Finding flow_passage(const Impact& i) {
  const Inflow inflow(i.belt);
  const double duration = i.c.output.duration, way = inflow.travelled(duration), reach = std::max(i.width(), i.depth());
  const double filled = i.window() ? i.belt.upstream_length + i.belt.downstream_length : 0.0,
               needed = std::max(filled, least_passage_heights * reach);
  if (way >= needed || needed / i.belt.velocity < 1.5 * i.splash_time()) return {};  // the rule above requires a longer run
  return Advice{
      "flow_passage", fmt::format("the flow travels {} m in output.duration_s = {} s", n(way), n(duration)),
      fmt::format("the snow that was there at the start is still in front of the obstacle, and a pile needs about {:.0f} H (Table 2 of "
                  "the paper), here {} m, to become steady",
                  least_passage_heights, n(needed)),
      fmt::format("take output.duration_s = {} s", n(std::ceil(duration + (needed - way) / std::max(inflow.velocity(duration), 1e-3))))};
}

/// docs/cases.md: 50 rows a second resolve a window of 0.1 s.
Finding rows_in_force_window(const Impact& i) {
  const double rows = i.c.output.series_per_second * i.c.measurement.force_window;
  if (rows >= 3.0 - 1e-9) return {};
  return Advice{"rows_in_force_window", fmt::format("output.series_per_second = {} 1/s", n(i.c.output.series_per_second)),
                fmt::format("the moving mean behind the filtered peaks ([measurement] force_window_s = {} s) covers less than three rows",
                            n(i.c.measurement.force_window)),
                fmt::format("take output.series_per_second = {}", n(std::ceil(5.0 / i.c.measurement.force_window)))};
}

// ---- Snow and speed ---------------------------------------------------------------------------------------------------------------------

/// Compressibility of the model, not of snow: physics of the set-up, Sect. 6; the paper's fastest flow (Fr 7, 29 m/s) has v/c_P = 0.50.
Finding mach_number(const Impact& i) {
  constexpr double most = 0.6;
  const AnyMaterial material = make_material(i.c.material);
  const double c = wave_speed_of(material), mach = i.speed / c, bulk = bulk_speed_of(material), density = density_of(material);
  if (mach <= most) return {};
  const double modulus = density * (bulk > 0.0 ? bulk * bulk : c * c), head = 0.5 * density * i.speed * i.speed;
  return Advice{
      "mach_number", fmt::format("Mach number v/c_P = {} (v = {} m/s, elastic wave speed {} m/s)", n(mach), n(i.speed), n(c)),
      fmt::format("the snow of the model is compressed elastically where it stops: pressures are about {:.0f} % above those of snow that "
                  "is not; the paper's fastest flow has 0.50",
                  100.0 * (hencky_stagnation_pressure(i.speed, density, modulus) / head - 1.0)),
      fmt::format("raise material.young_modulus_pa by a factor of {} (the time step falls with its root)",
                  n(std::ceil(mach * mach / 0.25)))};
}

/// Compression of a layer by its own weight: rho g H / (K + 4G/3) = g H / c_P^2.
Finding wave_speed(const Impact& i) {
  constexpr double most_settlement = 0.05, stiffest = 1000.0;
  const double c = wave_speed_of(make_material(i.c.material)), settlement = i.c.numerics.gravity * i.depth() / (c * c);
  if (settlement > most_settlement) {
    return Advice{"wave_speed", fmt::format("elastic wave speed {} m/s", n(c)),
                  fmt::format("the layer settles by {} under its own weight; the paper's snow has 58 m/s and 0.5 %",
                              settlement < 0.5 ? fmt::format("{:.0f} %", 100.0 * settlement) : "most of its depth"),
                  "check the unit of the stiffness: material.young_modulus_pa is in Pa, 1e6 in the paper"};
  }
  if (c > stiffest) {
    return Advice{"wave_speed", fmt::format("elastic wave speed {} m/s", n(c)),
                  fmt::format("time steps are {:.0f} times shorter than those of the paper's snow, 58 m/s", c / 58.4),
                  "check the unit of the stiffness: material.young_modulus_pa is in Pa, 1e6 in the paper"};
  }
  return {};
}

/// A plastic compaction wave is slower than the flow: a shock forms before the obstacle (c^2 = K xi / ((1 + xi) rho), physics of Sect. 6).
Finding compaction_shock(const Impact& i) {
  const auto* snow = i.c.material.get_if<CamClay>();
  if (snow == nullptr || !i.window()) return {};
  const double xi = snow->hardening_xi, stiffness = bulk_modulus(snow->young_modulus, snow->poisson_ratio);
  const double c = std::sqrt(stiffness * xi / ((1.0 + xi) * i.c.material.density()));
  if (i.speed <= c) return {};
  return Advice{"compaction_shock",
                fmt::format("v = {} m/s is above the speed of plastic compaction, {} m/s (xi = {})", n(i.speed), n(c), n(xi)),
                "a shock of compacted snow forms before the obstacle and may reach the inlet of the window",
                fmt::format("compare with a longer conveyor.upstream_length_m, such as {} m", n(1.5 * i.belt.upstream_length))};
}

// ---- Geometry ---------------------------------------------------------------------------------------------------------------------------

/// An upper bound of the speed gained between inlet and obstacle; side walls reduce it.
Finding slope(const Impact& i) {
  constexpr double most_gain = 0.01, steepest = 60.0;  // deg
  const double angle = i.c.numerics.slope, degrees = angle * 180.0 / std::numbers::pi;
  if (std::abs(degrees) > steepest) {
    return Advice{
        "slope", fmt::format("numerics.slope_deg = {}", n(degrees)),
        "avalanches start between 25 and 60 degrees and meet structures on flatter ground (Schweizer et al. 2003, Rev. Geophys. 41)",
        "check the value; 90 degrees is a vertical wall"};
  }
  const double length = i.window() ? i.belt.upstream_length : conveyor_length(i.belt.velocity, i.c.output.duration);
  const double squared = i.belt.velocity * i.belt.velocity + 2.0 * i.c.numerics.gravity * std::sin(angle) * length;
  const double arrives = std::sqrt(std::max(squared, 0.0));
  if (std::abs(arrives / i.belt.velocity - 1.0) <= most_gain) return {};
  return Advice{
      "slope", fmt::format("numerics.slope_deg = {}", n(degrees)),
      fmt::format("the bed has no friction, so that the flow changes its speed on the {} m from the inlet to the obstacle, from {} to at "
                  "most {} m/s, and its depth with it; a real avalanche is held by its bed",
                  n(length), n(i.belt.velocity), n(arrives)),
      fmt::format("leave the slope out and take numerics.gravity_m_s2 = {} (g cos of it), which keeps the speed, or compare the inflow "
                  "at the obstacle",
                  n(i.c.numerics.gravity * std::cos(angle)))};
}

/// Those of the equations (impact/semi_empirical.hpp), and a box normal to the flow.
Finding range_of_equations(const Impact& i) {
  const auto friction = i.c.material.critical_state_ratio();
  std::vector<std::string> outside = outside_of_equations(i.froude(), i.width() / i.depth(), friction, i.c.material.hardening_xi());
  if (std::visit([](const auto& s) { return s.front(); }, i.mast.shape) != Front::plane)
    outside.emplace_back("the shape (fitted: a box with a face against the flow)");
  if (i.mast.base > 0.0) outside.emplace_back("an obstacle above the ground (fitted: on it)");
  if (outside.empty() || !friction) return {};
  return Advice{"range_of_equations", fmt::format("the paper's equations were not fitted to {}", fmt::join(outside, ", ")),
                "the run-up and the pressure height that they predict are extrapolations here",
                "take them as a rough comparison, not as a check of the run"};
}

/// The obstacle is lower than the flow, than the run-up by the paper's equation, or than Bernoulli's bound of a steady run-up (Eq. 1 of the
/// paper).
Finding mast_height(const Impact& i) {
  if (!i.mast.height || i.mast.base > 0.0) return {};
  const double height = *i.mast.height;
  if (height < i.depth()) {
    return Advice{"mast_height", fmt::format("obstacle.height_m = {} m is lower than the flow, {} m", n(height), n(i.depth())),
                  "the snow flows over the obstacle; run-up, pressure height and the equations for masts have no meaning",
                  "check the value; left out, the mast is taller than any jet"};
  }
  if (i.c.numerics.gravity <= 0.0) return {};
  const std::string remedy = "leave out obstacle.height_m for the run-up of a tall mast";
  const auto friction = i.c.material.critical_state_ratio();
  const double runup = friction ? predicted_runup(*friction, i.belt.velocity, i.depth(), i.gravity()) : 0.0;
  if (height < runup) {
    return Advice{"mast_height",
                  fmt::format("obstacle.height_m = {} m is lower than the run-up by the paper's equation, {} m", n(height), n(runup)),
                  "snow passes over the top, and the run-up is that of a mast that ends there", remedy};
  }
  const double bound = i.bound();
  if (height >= bound) return {};
  return Advice{
      "mast_height", fmt::format("obstacle.height_m = {} m is lower than Bernoulli's bound H + v^2/2g = {} m", n(height), n(bound)),
      "the first splash, and snow with little friction, may pass over the top; the run-up is then that of a mast that ends there", remedy};
}

/// Particles that leave the domain are gone.
Finding height_of_the_domain(const Impact& i) {
  if (i.c.numerics.gravity <= 0.0 || i.c.terrain) return {};
  const double bound = std::min(i.mast.solid().top, i.bound()), top = i.c.domain.max.z();
  if (top >= bound) return {};
  return Advice{"height_of_the_domain",
                fmt::format("domain.max_m ends at z = {} m, below Bernoulli's bound H + v^2/2g = {} m", n(top), n(bound)),
                "what climbs higher is removed, so that the run-up is cut off",
                fmt::format("give at least {} m, or leave out domain.max_m", at_least(bound))};
}

/// What begins above the ground: the columns of nodes on its underside share nodes with those on its top where it is thinner than three
/// cells, and with those on the ground where there are less below it (core/folded_wall.hpp); a steady flow reaches no higher than
/// Bernoulli's bound. @param table  that gives its base_m and height_m
Finding above_the_ground(const Impact& i, const std::string& table, double base, double top) {
  if (base <= 0.0) return {};  // it stands on the ground
  constexpr double least = 3.0;
  const double thickness = top - base, narrower = std::min(thickness, base), bound = i.bound();
  if (narrower / i.dx() < least - 1e-6) {
    const bool gap = base < thickness;
    const std::string cells = n(narrower / i.dx()),
                      remedy = fmt::format("take numerics.cell_size_m = {} (three cells)", at_most(narrower / least));
    if (gap)
      return Advice{
          table + "_base", fmt::format("{} cells between the ground and {}.base_m", cells, table),
          "contact on the ground and on the underside acts on the same nodes, so that neither holds the snow between them exactly",
          remedy + ", or let it stand on the ground: 0"};
    return Advice{table + "_base", fmt::format("{0} cells between {1}.base_m and {1}.height_m", cells, table),
                  "contact on the top and on the underside acts on the same nodes, so that snow on one side feels that on the other",
                  remedy};
  }
  if (base < bound) return {};
  return Advice{table + "_base", fmt::format("{}.base_m = {} m is above Bernoulli's bound H + v^2/2g = {} m", table, n(base), n(bound)),
                "a steady flow passes below it; only the first splash may reach it", "check the value"};
}
Finding obstacle_base(const Impact& i) { return above_the_ground(i, "obstacle", i.mast.base, i.mast.solid().top); }
Finding arm_base(const Impact& i) { return i.c.arm ? above_the_ground(i, "arm", i.c.arm->base, i.c.arm->height) : Finding{}; }

/// validation/cases/avalanche_convergence: a window of 4 w + 2 w and a belt of 6 w against 5 w + 3 w and 12 w changes run-up and force by
/// at most 3 % (w = H).
Finding size_of_the_window(const Impact& i) {
  const double w = i.width(), behind = outline_of(i.mast.shape).bounds().max().x() + w;  // 2 w behind the front of a square mast
  std::vector<std::string> small;
  if (i.window() && i.belt.upstream_length < 4.0 * w - 1e-6)
    small.push_back(fmt::format("conveyor.upstream_length_m = {} (4 w = {})", n(i.belt.upstream_length), n(4.0 * w)));
  if (i.window() && i.belt.downstream_length < behind - 1e-6)
    small.push_back(fmt::format("conveyor.downstream_length_m = {} (its depth + w = {})", n(i.belt.downstream_length), n(behind)));
  if (i.belt.width < 6.0 * w - 1e-6) small.push_back(fmt::format("conveyor.width_m = {} (6 w = {})", n(i.belt.width), n(6.0 * w)));
  if (small.empty()) return {};
  return Advice{"size_of_the_window", fmt::format("{}", fmt::join(small, ", ")),
                "inlet, outlet or side walls are nearer to the obstacle than in any case that was checked against a larger window "
                "(validation/cases/avalanche_convergence)",
                "take at least the values in brackets, or compare with a larger window"};
}

/// validation/study/limits.md: below Fr 5 snow of M' = 2.3 jams between the inlet and a mast 4.8 widths away, and presses with more than
/// twice the force that it has with 9.6 or 19 widths. Up to M' = 1.76 twice the distance changes heights by at most 3 %.
Finding jam_at_the_inlet(const Impact& i) {
  constexpr double checked = 9.6;
  const auto friction = i.c.material.critical_state_ratio();
  const double far = checked * i.width();
  if (!i.window() || !friction || *friction <= jamming_ratio) return {};
  if (i.froude() >= fastest_jam || i.belt.upstream_length >= far - 1e-6) return {};
  return Advice{"jam_at_the_inlet", fmt::format("M' = {} with conveyor.upstream_length_m = {}", n(*friction), n(i.belt.upstream_length)),
                "such stiff snow may jam between the inlet and the obstacle; force and heights then depend on the window",
                fmt::format("take at least 9.6 w = {} m, and downstream_length_m = {}", n(far), n(0.5 * far))};
}

// ---- Ground -----------------------------------------------------------------------------------------------------------------------------

/// Where the slope of the ground differs most from its mean over two cells, and by how much.
struct ShortSlope {
  double difference = 0.0;  ///< of dh/dx or dh/dy
  Vec2 place = Vec2::Zero();
};

/// Looks half way between neighbouring points of the raster, where heights that alternate are steepest. Any place may be that of a node.
ShortSlope shortest_slope(const HeightField& ground, double dx, const Vec2& low, const Vec2& high) {
  const HeightField::Points& raster = ground.points();
  ShortSlope most;
  for (std::size_t k = 0; k < raster.height.size(); ++k) {
    const std::size_t column = k % raster.columns, row = k / raster.columns;
    const Vec2 point = raster.first + raster.spacing * Vec2(static_cast<double>(column), static_cast<double>(row));
    for (const int axis : {0, 1}) {
      const Vec2 place = point + 0.5 * raster.spacing * Vec2::Unit(axis), cell = dx * Vec2::Unit(axis);
      if ((place.array() < low.array()).any() || (place.array() > high.array()).any()) continue;
      const double mean = (ground.at(place + cell).height - ground.at(place - cell).height) / (2.0 * dx);
      const double difference = std::abs(ground.at(place).slope[axis] - mean);
      if (difference > most.difference) most = {difference, place};
    }
  }
  return most;
}

/// Obstacles, measurements and the inlet of a conveyor have the ground at z = 0 (docs/cases.md).
Finding ground_at_the_obstacle(const Case& c, const std::shared_ptr<const HeightField>& ground) {
  if (!c.obstacle) return {};
  const double height = ground->at(outline_of(c.obstacle->shape).centre()).height;
  if (std::abs(height) <= 0.5 * c.numerics.cell_size) return {};
  return Advice{"ground_at_the_obstacle", fmt::format("the ground of [terrain] is at z = {} m where the obstacle stands", n(height)),
                "height of the obstacle, run-up and pressure height count from z = 0",
                fmt::format("subtract {} m from all heights of the raster", n(height))};
}

/// Each column of nodes takes the height and the slope of the ground at its own place (core/folded_terrain.hpp), and nothing from between.
/// The limit: a slab of snow, five cells high, slid 3.6 m (14 cells) at 6 m/s over frictionless waves of 1 to 12 cells with slopes of 0.08
/// to 0.5, which brake it. Against grids two and four times finer its speed was right within 4 % where slopes differ by less than 0.06 from
/// their mean. Above, it was wrong by 5 to 35 % for waves of up to four cells (1 % for six), and by nearly as much by where the nodes lie.
/// Waves of 8 cells stay below the limit at the steepest slope of a case, 30 degrees.
Finding short_waves_of_the_ground(const Case& c, const std::shared_ptr<const HeightField>& ground) {
  constexpr double most = 0.06;
  const Eigen::AlignedBox3d domain = case_domain(c, ground);
  const double dx = c.numerics.cell_size, spacing = ground->points().spacing;
  const ShortSlope found = shortest_slope(*ground, dx, domain.min().head<2>(), domain.max().head<2>());
  if (found.difference <= most) return {};
  return Advice{"short_waves_of_the_ground",
                fmt::format("the slope of [terrain] differs by up to {} from its mean over two cells, most at x = {}, y = {}",
                            n(found.difference), n(found.place.x()), n(found.place.y())),
                "the grid takes height and slope of the ground at its nodes only; waves of a few cells brake or push the flow by chance, "
                "by 5 % of its speed and more over some metres",
                fmt::format("smooth the raster, such as by means over {} m, or take numerics.cell_size_m = {}", n(4.0 * dx),
                            n(std::min(0.25 * spacing, 0.5 * dx)))};
}

// ---- Output -----------------------------------------------------------------------------------------------------------------------------

/// A frame is stored with a row.
Finding frames_between_rows(const Case& c) {
  const double rows = c.output.series_per_second, asked = c.output.frames_per_second, stored = Sampling(c).frames_per_second();
  if (std::abs(stored - asked) <= 1e-6 * asked) return {};
  return Advice{"frames_between_rows",
                fmt::format("output.frames_per_second = {} is no whole part of output.series_per_second = {}", n(asked), n(rows)),
                fmt::format("{} frames a second are stored, each with a row of series.csv", n(stored)),
                "take a whole part of series_per_second"};
}

Finding end_between_rows(const Case& c) {
  const double asked = c.output.duration, end = Sampling(c).end();
  if (std::abs(end - asked) <= 1e-9 * asked) return {};
  return Advice{"end_between_rows", fmt::format("output.duration_s = {:.9g} is between two rows of series.csv", asked),
                fmt::format("the run ends with the next row, at {:.9g} s", end),
                fmt::format("take a whole multiple of 1/series_per_second = {:.9g} s", 1.0 / c.output.series_per_second)};
}

Finding inflow_after_the_end(const Case& c) {
  if (!c.conveyor) return {};
  const auto& rows = c.conveyor->inflow;
  const auto after = std::ranges::count_if(rows, [&](const InflowPoint& row) { return row.time >= c.output.duration; });
  if (after == 0 || rows.size() < 2) return {};
  return Advice{"inflow_after_the_end",
                fmt::format("{} of {} rows of [[conveyor.inflow]] are at or after the end of the run, output.duration_s = {:.9g}", after,
                            rows.size(), c.output.duration),
                static_cast<std::size_t>(after) == rows.size() ? "only the first is used, so that the inflow is steady"
                                                               : "what they say enters late or not at all",
                fmt::format("take output.duration_s = {:.9g} or more, or let the times of the rows begin at 0", rows.back().time)};
}

// ---- Plausibility -----------------------------------------------------------------------------------------------------------------------

/// Limits beyond which a value is more likely an error of the unit than an avalanche. Assumed, except where a source is given.
std::vector<Advice> plausible_values(const Impact& i) {
  struct Limit {
    const char* key;
    double value, low, high;
    const char* unit;
    const char* reason;
  };
  const Limit limits[] = {
      {"conveyor.velocity_m_s", i.belt.velocity, 0.1, 80.0, "m/s",
       "dense avalanches flow at up to some 60 m/s, the paper's at 0.4 to 29 m/s"},
      {"Froude number", i.c.numerics.gravity > 0.0 ? i.froude() : 0.0, 0.0, 10.0, "",
       "the paper's avalanches have 0.1 to 7; 50 km/h are 14 m/s"},
      {"conveyor.flow_height_m", i.depth(), 0.1, 20.0, "m", "assumed: dense avalanches are some tenths of a metre to some metres deep"},
      {"material.density_kg_m3", i.c.material.density(), 50.0, 700.0, "kg/m^3",
       "assumed: flowing snow has 100 to 500 kg/m^3, and 300 is a common estimate (Sect. 2.2 of the paper)"},
      {"obstacle.width_m", i.width(), 0.1, 100.0, "m", "assumed: masts and towers are some tenths of a metre to some metres wide"},
      {"obstacle.friction", i.mast.friction, 0.0, 1.0, "", "assumed: snow on steel or concrete has less; more friction lowers the run-up"},
      {"output.duration_s", i.c.output.duration, 0.0, 600.0, "s", "assumed: the paper's longest run takes 120 s"},
  };
  std::vector<Advice> found;
  for (const Limit& limit : limits) {
    if (limit.value >= limit.low && limit.value <= limit.high) continue;
    found.push_back({"plausible_values", fmt::format("{} = {} {}", limit.key, n(limit.value), limit.unit),
                     fmt::format("outside {} to {}: {}", n(limit.low), n(limit.high), limit.reason), "check the value and its unit"});
  }
  return found;
}

}  // namespace

std::vector<Advice> advise(const Case& c) {
  std::vector<Advice> all;
  const auto add = [&](Finding found) {
    if (found) all.push_back(std::move(*found));
  };
  if (c.terrain) {
    const auto ground = height_field(*c.terrain);
    add(ground_at_the_obstacle(c, ground));
    add(short_waves_of_the_ground(c, ground));
  }
  for (const auto& rule : {thin_obstacle, end_between_rows, frames_between_rows, inflow_after_the_end}) add(rule(c));
  if (!c.conveyor || !c.obstacle) return all;
  const Impact impact{c, *c.conveyor, *c.obstacle, std::max(c.conveyor->velocity, Inflow(*c.conveyor).fastest())};
  constexpr Finding (*rules[])(const Impact&) = {
      cells_across, nodal_width,          aligned_lattice, splash_and_duration,  inflow_varies,
      flow_passage, rows_in_force_window, mach_number,     wave_speed,           compaction_shock,
      slope,        range_of_equations,   mast_height,     height_of_the_domain, obstacle_base,
      arm_base,     size_of_the_window,   jam_at_the_inlet};
  for (const auto& rule : rules) add(rule(impact));
  for (Advice& found : plausible_values(impact)) all.push_back(std::move(found));
  return all;
}

}  // namespace mpm
