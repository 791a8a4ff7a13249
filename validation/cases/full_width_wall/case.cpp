#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/convergence.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/shallow_flow.hpp"

namespace mpm::validation::full_width_wall {
namespace {

Case strip_case(const CaseContext& context, double froude, int cells, double length, double duration) {
  Case c = context.read_case();
  const double depth = c.bodies[0].max.z(), dx = depth / cells, speed = froude * std::sqrt(c.numerics.gravity * depth);
  c.numerics.cell_size = dx;
  c.bodies[0].min.y() = c.walls[2].point.y() = dx;
  c.bodies[0].max.y() = c.walls[3].point.y() = 2.0 * dx;
  c.bodies[0].max.x() = c.walls[4].point.x() = length;
  c.bodies[0].velocity.x() = c.walls[4].velocity.x() = -speed;
  c.domain.max.x() = length + 1.0;
  c.output.duration = duration;
  return c;
}

/// Mass behind the bore, thrust on the wall and speed of the bore, over those of the theory.
struct Outcome {
  std::vector<double> time, front;  ///< s; length of the bore, m
  BatchMean mass{}, thrust{};
  double speed = 0.0;
  double motion = 0.0;  ///< what is left of the motion: int rho u^2 dz behind the bore over the thrust
  DepthProfile last;    ///< kg/m^2
  double end = 0.0;     ///< s
  double particle_steps = 0.0;
};

constexpr std::size_t samples = 200;

Setup strip_setup(const Case& c, const std::string& id, const std::string& name, int cells) {
  return {.id = fmt::format("{}-dx{}", id, cells),
          .title = fmt::format("{}, dx = H/{}", name, cells),
          .spec = c,
          .start = [](const Case& spec, const Scene& scene) { return hydrostatic_state(spec, scene, 2, 0); },
          .times = even_times(0.0, c.output.duration, samples),
          .forces = true};
}

Outcome run_strip(const CaseContext& context, const Setup& setup, const HydrostaticColumn& column, const Bore& bore,
                  const FlowPicture* picture, CaseResult& result) {
  const Case& c = setup.spec;
  const double depth = c.bodies[0].max.z(), width = c.numerics.cell_size, rho = column.density();
  const double speed = -c.bodies[0].velocity.x(), spacing = 0.5 * depth;
  Outcome o;
  std::vector<double> mass, thrust;
  double flux = 0.0;
  const RunCost cost = play(context, setup, [&](const Instant& now) {
    // twice the distance of the excess mass from the wall: the length of a bore of even depth
    const double undisturbed = 1.2 * bore.speed * now.time + 2.0 * depth;  // well beyond the bore, and short of the piston
    double moment = -0.5 * rho * depth * undisturbed * undisturbed;
    for (const ParticleRecord& q : now.particles)
      if (q.position.x() < undisturbed) moment += q.mass / width * q.position.x();
    o.time.push_back(now.time);
    o.front.push_back(2.0 * moment / (rho * depth * speed * now.time));
    if (now.index >= samples / 2) {
      // behind the bore: the half next to the wall of the stretch that it has run over according to the theory
      const double half = 0.5 * bore.speed * now.time;
      double behind = 0.0, momentum_flux = 0.0;
      for (const ParticleRecord& q : now.particles) {
        if (q.position.x() >= half) continue;
        behind += q.mass;
        momentum_flux += q.mass * q.velocity.x() * q.velocity.x();
      }
      mass.push_back(behind / (half * width * bore.mass));
      thrust.push_back(-now.forces[0].x() / (width * bore.thrust));
      flux += momentum_flux / (half * width * bore.thrust);
    }
    if (now.index + 1 < samples) return true;
    o.last = depth_profile(now.particles, 0.0, spacing * std::floor(c.bodies[0].max.x() / spacing), spacing, width);
    o.end = now.time;
    if (picture != nullptr && now.state != nullptr)
      result.flows.push_back(flow_picture(context.directory(), *now.state, *now.scene, *picture));
    return true;
  });
  o.particle_steps = cost.particle_steps;
  o.mass = batch_mean(mass, 5);
  o.thrust = batch_mean(thrust, 5);
  o.motion = flux / static_cast<double>(mass.size());
  constexpr std::ptrdiff_t half = samples / 2;
  o.speed = fitted_line({o.time.begin() + half, o.time.end()}, {o.front.begin() + half, o.front.end()}).slope / bore.speed;
  return o;
}

/// One Froude number on several grids.
struct Study {
  std::string name, id;   ///< for words and for files
  double froude, travel;  ///< travel: how far the bore runs, in its own heights h2
  std::vector<int> cells;
  double unsteadiness;  ///< allowed beside the error of the floor, see the README
  const char* reason;
  bool with_snow;
  bool misses_speed = false;  ///< known (README.md)
  bool steady = true;         ///< false: no steady bore forms, and only the thrust is compared
};

/// The two materials and their columns at rest.
struct Fluids {
  mpm::CamClay::Parameters snow;
  HydrostaticColumn fluid, snow_column;
};

Fluids fluids_of(const Case& base) {
  const double g = base.numerics.gravity, rho = base.material.density();
  const WeaklyCompressibleFluid::Parameters& water = base.material.as<WeaklyCompressibleFluid>();
  mpm::CamClay::Parameters snow;
  snow.density = rho;
  snow.critical_state_slope = 0.0;
  const double k = snow.young_modulus / (3.0 * (1.0 - 2.0 * snow.poisson_ratio));
  return {snow, HydrostaticColumn(rho, g, tait_curve(water.bulk_modulus, water.tait_exponent)),
          HydrostaticColumn(rho, g, snow_curve(k, snow.hardening_xi, snow.preconsolidation_pressure))};
}

const char* const undular = "0.5 % for the waves that travel behind the front of an undular bore";
const char* const rolling =
    "2.5 % for what is left of the motion behind the bore, whose ∫ρu²dz of up to 5 % of the thrust takes half that from the depth";

std::vector<Study> studies(const CaseContext& context) {
  Study low{"Fr 0.3", "fr03", 0.3, 12.0, {4, 6, 8, 12}, 0.005, undular, false};
  Study middle{"Fr 1", "fr1", 1.0, 8.0, {4, 6, 8, 12}, 0.025, rolling, false};
  Study snow{"Fr 1, snow with M = 0", "fr1-snow", 1.0, 8.0, {6}, 0.025, rolling, true};
  Study high{"Fr 3", "fr3", 3.0, context.choose(6.0, 6.0, 12.0), {4}, 0.025, rolling, false};
  high.steady = false;
  if (context.level() == Level::quick) {
    low.cells = snow.cells = {4};
    snow.misses_speed = true;
    return {low, snow};
  }
  if (context.level() == Level::full) {
    for (Study* s : {&low, &middle}) s->cells.push_back(16);
    snow.cells = {4, 6, 8};
    high.cells = {4, 6, 8};
  }
  return {low, middle, snow, high};
}

/// Predictions of the theory for a study, and the required length of its strip.
struct Plan {
  Bore bore;
  double duration, length;
};

Plan plan_of(const Study& s, const Fluids& fluids, const Case& base) {
  const double depth = base.bodies[0].max.z(), v = s.froude * std::sqrt(base.numerics.gravity * depth);
  const Bore bore = reflected_bore(s.with_snow ? fluids.snow_column : fluids.fluid, base.material.density() * depth, v);
  const double duration = s.travel * bore.height / bore.speed;
  return {bore, duration, (std::floor((v + 1.3 * bore.speed) * duration / depth) + 3.0) * depth};
}

Setup setup_of(const CaseContext& context, const Study& s, const Fluids& fluids, const Plan& plan, int cells) {
  Case c = strip_case(context, s.froude, cells, plan.length, plan.duration);
  if (s.with_snow) c.material = fluids.snow;
  return strip_setup(c, s.id, s.name, cells);
}

std::vector<Setup> setups(const CaseContext& context) {
  const Case base = context.read_case();
  const Fluids fluids = fluids_of(base);
  std::vector<Setup> all;
  for (const Study& s : studies(context))
    for (const int cells : s.cells) all.push_back(setup_of(context, s, fluids, plan_of(s, fluids, base), cells));
  return all;
}

/// h2/h1 of the reflected bore in the incompressible limit, from the table.
double incompressible_ratio(const Table& table, double froude) {
  const std::vector<double> froudes = table.numbers("Fr"), ratios = table.numbers("reflected_bore");
  for (std::size_t i = 0; i < froudes.size(); ++i)
    if (std::abs(froudes[i] - froude) < 1e-9) return ratios[i];
  throw ConfigError("full_width_wall: a Froude number that the table lacks");
}

/// The jump conditions that are solved here against the table.
void check_jump_conditions(CaseResult& result, const Case& base, const Table& table) {
  const double depth = base.bodies[0].max.z(), g = base.numerics.gravity, rho = base.material.density();
  const HydrostaticColumn stiff(rho, g, hencky_curve(1e13));
  double apart = 0.0;
  for (const double froude : {0.3, 1.0, 3.0}) {
    const double r = reflected_bore(stiff, rho * depth, froude * std::sqrt(g * depth)).height / depth;
    apart = larger(apart, std::abs(r / incompressible_ratio(table, froude) - 1.0));
  }
  result.check_absolute(Label::verification, "jump conditions in the incompressible limit against the table, largest relative difference",
                        apart, 0.0, "", 1e-8, "ten digits of the table; compression ρgh/K of the limit taken is 1e-9");
}

/// A study on its grids, coarse first.
struct Grids {
  std::vector<double> size, height;  ///< m; depth behind the bore over H
  Outcome finest;
  double particle_steps = 0.0;
};

/// What was measured on one grid. @param height  depth behind the bore over H  @param ratio  of the incompressible limit
void note_grid(const CaseContext& context, CaseResult& result, const Study& s, int cells, const Outcome& o, const Bore& bore, double depth,
               double height, double ratio) {
  context.log(fmt::format(
      "{}, H/dx = {}: depth {:.4f} of theory ({:.4f}), thrust {:.4f} ({:.4f}), speed {:.4f}, motion {:.4f}; {:.3g} "
      "particle-steps",
      s.name, cells, o.mass.mean, o.mass.standard_error, o.thrust.mean, o.thrust.standard_error, o.speed, o.motion, o.particle_steps));
  result.notes.push_back(fmt::format(
      "{}, dx = H/{}: h2/H {:.4f} (hydrostatic theory {:.4f}, incompressible {:.4f}), bore speed {:.3f} m/s ({:.3f}), thrust on the "
      "wall {:.2f} kN/m ({:.2f}); standard errors of mass and thrust {:.2f} and {:.2f} %; left of the motion: ∫ρu²dz behind the bore is "
      "{:.1f} % of the thrust.",
      s.name, cells, height, bore.height / depth, ratio, o.speed * bore.speed, bore.speed, 1e-3 * o.thrust.mean * bore.thrust,
      1e-3 * bore.thrust, 100.0 * o.mass.standard_error, 100.0 * o.thrust.standard_error, 100.0 * o.motion));
}

/// Runs all grids of a study and draws the length of the bore and the depth at the end.
/// @param ratio  h2/H of the incompressible limit
Grids run_grids(const CaseContext& context, CaseResult& result, const Case& base, const Fluids& fluids, const Study& s, const Plan& plan,
                double ratio) {
  const HydrostaticColumn& column = s.with_snow ? fluids.snow_column : fluids.fluid;
  const Bore& bore = plan.bore;
  const double depth = base.bodies[0].max.z(), unit = base.material.density() * depth;
  const double x_end = bore.speed * plan.duration, r = bore.mass / unit;
  Plot front{s.id + "-front", "Length of the bore, " + s.name, "time [s]", "twice the distance of the excess mass from the wall [m]"};
  Plot shape{s.id + "-depth", "Depth at the end, " + s.name, "distance from the wall [m]", "mass per area / (ρ0 H) [-]"};
  front.series.push_back({"theory", {0.0, plan.duration}, {0.0, x_end}, Series::Style::reference});
  shape.series.push_back({"theory", {0.0, x_end, x_end, 1.3 * x_end}, {r, r, 1.0, 1.0}, Series::Style::reference});
  const FlowPicture picture{.id = s.id,
                            .field = FlowField::speed,
                            .title = s.name + fmt::format(", t = {:.1f} s", plan.duration),
                            .caption = "The wall is on the left, the flow comes from the right.",
                            .window = std::array{-depth, 1.3 * x_end, -depth, 2.5 * bore.height}};
  Grids grids;
  for (const int cells : s.cells) {
    const Setup setup = setup_of(context, s, fluids, plan, cells);
    Outcome o = run_strip(context, setup, column, bore, cells == s.cells.back() ? &picture : nullptr, result);
    grids.particle_steps += o.particle_steps;
    grids.size.push_back(setup.spec.numerics.cell_size);
    grids.height.push_back(column.height(o.mass.mean * bore.mass) / depth);
    note_grid(context, result, s, cells, o, bore, depth, grids.height.back(), ratio);
    const std::string label = fmt::format("dx = H/{}", cells);
    front.series.push_back({label, o.time, o.front, Series::Style::simulation});
    Series profile{label, {}, {}, Series::Style::simulation};
    for (std::size_t i = 0; i < o.last.mass.size() && o.last.x(i) <= 1.3 * x_end; ++i) {
      profile.x.push_back(o.last.x(i));
      profile.y.push_back(o.last.mass[i] / unit);
    }
    shape.series.push_back(std::move(profile));
    grids.finest = std::move(o);
  }
  result.plots.push_back(std::move(front));
  result.plots.push_back(std::move(shape));
  return grids;
}

/// Depth, thrust and speed of the bore on the finest grid.
void check_study(CaseResult& result, const Case& base, const Study& s, const Bore& bore, const Grids& grids) {
  const Outcome& finest = grids.finest;
  const double depth = base.bodies[0].max.z(), dx = grids.size.back(), r = bore.mass / (base.material.density() * depth);
  const std::string reason = fmt::format("{}; and the floor's cell, which carries 1/8 too much stress: dx/(4 {{}})", s.reason);
  result
      .check_relative(Label::verification, s.name + ": mean thrust on the wall", 1e-3 * finest.thrust.mean * bore.thrust,
                      1e-3 * bore.thrust, "kN/m", dx / (4.0 * depth) + s.unsteadiness, fmt::format(fmt::runtime(reason), "H"))
      .in_summary(Quantity::force, 0.0, 1e3);
  if (!s.steady) return;
  Check& h = result
                 .check_relative(Label::verification, s.name + ": depth behind the bore, h2/H", grids.height.back(), bore.height / depth,
                                 "", dx / (4.0 * bore.height) + s.unsteadiness, fmt::format(fmt::runtime(reason), "h2"))
                 .in_summary(Quantity::depth, 0.0, depth);
  Check& speed = result
                     .check_relative(Label::verification, s.name + ": speed of the bore", finest.speed * bore.speed, bore.speed, "m/s",
                                     (dx / (4.0 * bore.height) + s.unsteadiness) * r / (r - 1.0),
                                     "what is allowed for the depth, times r/(r - 1): the speed is v/(r - 1)")
                     .in_summary(Quantity::speed);
  if (s.misses_speed)
    speed.known_miss(1.145 * bore.speed,
                     "the front of the bore broadens while it runs, so that the excess mass reaches further than a jump");
  if (grids.size.size() >= 3) {
    const Convergence c = judge_convergence(grids.size, grids.height, 1.0);
    h.observed_order = c.order;
    result.convergences.push_back({s.name + ": depth behind the bore", "H", c});
  }
}

/// Error of the depth behind the bore over the cell size. @param exact  h2/H
Plot order_plot(const Study& s, double exact, const Grids& grids) {
  Series errors{"simulation", grids.size, {}, Series::Style::points};
  for (const double h : grids.height) errors.y.push_back(std::abs(h / exact - 1.0));
  const double at_finest = errors.y.front() * grids.size.back() / grids.size.front();
  return {s.id + "-order",
          "Error of the depth behind the bore, " + s.name,
          "dx [m]",
          "|h2/h2,theory - 1| [-]",
          {slope_line("order 1", grids.size, at_finest, 1.0), errors},
          "",
          true,
          true};
}

void run(const CaseContext& context, CaseResult& result) {
  const Case base = context.read_case();
  const Fluids fluids = fluids_of(base);
  const Table table = Table::read(context.case_directory() / "../../../reference_data/shallow_water_limits/data.csv");
  check_jump_conditions(result, base, table);

  const std::vector<Study> all = studies(context);
  std::vector<Grids> grids;
  double particle_steps = 0.0;
  for (const Study& s : all) {
    const Plan plan = plan_of(s, fluids, base);
    grids.push_back(run_grids(context, result, base, fluids, s, plan, incompressible_ratio(table, s.froude)));
    check_study(result, base, s, plan.bore, grids.back());
    particle_steps += grids.back().particle_steps;
  }
  if (context.level() != Level::quick) {  // the first two are the fluid at Fr 0.3 and at Fr 1
    const auto [lowest, highest] = std::ranges::minmax_element(grids[0].height);
    result.check_at_most(Label::verification, "Fr 0.3: spread of the depth behind the bore over the grids, h2/H", *highest - *lowest, 0.0,
                         "", 0.005, "it does not depend on the grid: half a percent for the waves behind the front, which do");
    for (const std::size_t i : {0, 1})
      result.plots.push_back(order_plot(all[i], plan_of(all[i], fluids, base).bore.height / base.bodies[0].max.z(), grids[i]));
  }
  result.notes.push_back(fmt::format("{:.2g} particle-steps in all.", particle_steps));
}

const Registration registered{{.title = "Flow against a full-width wall: the reflected bore", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::full_width_wall
