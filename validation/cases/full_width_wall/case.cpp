#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/shallow_flow.hpp"

namespace mpm::validation {
namespace {

Case strip_case(const CaseContext& context, double froude, int cells, double length, double duration) {
  Case c = read_case(context.case_directory() / "case.toml");
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

constexpr int samples = 200;

Outcome run_strip(const CaseContext& context, const Case& c, const HydrostaticColumn& column, const Bore& bore, const FlowPicture* picture,
                  CaseResult& result) {
  const Scene scene = make_scene(c);
  State state = hydrostatic_state(c, scene, 2, 0);
  const double depth = c.bodies[0].max.z(), width = c.numerics.cell_size, rho = column.density();
  const double speed = -c.bodies[0].velocity.x(), spacing = 0.5 * depth;
  Outcome o;
  std::vector<double> mass, thrust;
  double flux = 0.0;
  for (int i = 1; i <= samples; ++i) {
    double impulse = 0.0;
    const double start = state.time;
    advance(state, scene, c.output.duration * i / samples, [&](const StepReport& r) {
      impulse -= r.impulses[0].linear.x();
      o.particle_steps += static_cast<double>(state.grid.particle_count());
    });
    // twice the distance of the excess mass from the wall: the length of a bore of even depth
    const double undisturbed = 1.2 * bore.speed * state.time + 2.0 * depth;  // well beyond the bore, and short of the piston
    double moment = -0.5 * rho * depth * undisturbed * undisturbed;
    state.grid.for_each_particle([&](const Particle& q) {
      if (q.position[0] < undisturbed) moment += rho * q.volume / width * q.position[0];
    });
    o.time.push_back(state.time);
    o.front.push_back(2.0 * moment / (rho * depth * speed * state.time));
    if (i > samples / 2) {
      // behind the bore: the half next to the wall of the stretch that it has run over according to the theory
      const double half = 0.5 * bore.speed * state.time;
      double behind = 0.0, momentum_flux = 0.0;
      state.grid.for_each_particle([&](const Particle& q) {
        if (q.position[0] >= half) return;
        behind += rho * q.volume;
        momentum_flux += rho * q.volume * q.velocity[0] * q.velocity[0];
      });
      mass.push_back(behind / (half * width * bore.mass));
      thrust.push_back(impulse / ((state.time - start) * width * bore.thrust));
      flux += momentum_flux / (half * width * bore.thrust);
    }
  }
  o.last = depth_profile(state, rho, 0.0, spacing * std::floor(c.bodies[0].max.x() / spacing), spacing, width);
  o.end = state.time;
  o.mass = batch_mean(mass, 5);
  o.thrust = batch_mean(thrust, 5);
  o.motion = flux / static_cast<double>(mass.size());
  o.speed = fitted_slope({o.time.begin() + samples / 2, o.time.end()}, {o.front.begin() + samples / 2, o.front.end()}) / bore.speed;
  if (picture != nullptr) result.flows.push_back(flow_picture(context.directory(), state, scene, *picture));
  return o;
}

struct Grid {
  int cells;  ///< H/dx
  Outcome outcome;
};

/// One Froude number on several grids.
struct Study {
  std::string name, id;   ///< for words and for files
  double froude, travel;  ///< travel: how far the bore runs, in its own heights h2
  std::vector<int> cells;
  double unsteadiness;  ///< allowed beside the error of the floor, see the README
  const char* reason;
};

void run(const CaseContext& context, CaseResult& result) {
  const Case base = read_case(context.case_directory() / "case.toml");
  const double depth = base.bodies[0].max.z(), g = base.numerics.gravity, rho = base.material.density();
  const WeaklyCompressibleFluid::Parameters& water = base.material.as<WeaklyCompressibleFluid>();
  const HydrostaticColumn fluid(rho, g, tait_curve(water.bulk_modulus, water.tait_exponent));
  mpm::CamClay::Parameters snow;
  snow.density = rho;
  snow.critical_state_slope = 0.0;
  const double k = snow.young_modulus / (3.0 * (1.0 - 2.0 * snow.poisson_ratio));
  const HydrostaticColumn snow_column(rho, g, snow_curve(k, snow.hardening_xi, snow.preconsolidation_pressure));

  const Table table = Table::read(context.case_directory() / "../../../reference_data/shallow_water_limits/data.csv");
  const std::vector<double> table_froude = table.numbers("Fr"), table_ratio = table.numbers("reflected_bore");
  const auto incompressible_ratio = [&](double froude) {
    for (std::size_t i = 0; i < table_froude.size(); ++i)
      if (std::abs(table_froude[i] - froude) < 1e-9) return table_ratio[i];
    throw ConfigError("full_width_wall: a Froude number that the table lacks");
  };

  const HydrostaticColumn stiff(rho, g, hencky_curve(1e13));
  double apart = 0.0;  // of the table from the jump conditions solved here
  for (const double froude : {0.3, 1.0, 3.0}) {
    const double r = reflected_bore(stiff, rho * depth, froude * std::sqrt(g * depth)).height / depth;
    apart = std::max(apart, std::abs(r / incompressible_ratio(froude) - 1.0));
  }
  result.check_absolute(Label::verification, "jump conditions in the incompressible limit against the table, largest relative difference",
                        apart, 0.0, "", 1e-8, "ten digits of the table; compression ρgh/K of the limit taken is 1e-9");

  double particle_steps = 0.0;
  const auto study = [&](const Study& s, bool with_snow) {
    const HydrostaticColumn& column = with_snow ? snow_column : fluid;
    const double v = s.froude * std::sqrt(g * depth), ratio = incompressible_ratio(s.froude);
    const Bore bore = reflected_bore(column, rho * depth, v);
    const double duration = s.travel * bore.height / bore.speed;
    const double length = (std::floor((v + 1.3 * bore.speed) * duration / depth) + 3.0) * depth;
    std::vector<double> size, height;
    std::vector<Grid> grids;
    Plot front{s.id + "-front",
               "Length of the bore, " + s.name,
               "time [s]",
               "twice the distance of the excess mass from the wall [m]",
               {},
               "",
               false,
               false};
    Plot shape{
        s.id + "-depth", "Depth at the end, " + s.name, "distance from the wall [m]", "mass per area / (ρ0 H) [-]", {}, "", false, false};
    front.series.push_back({"theory", {0.0, duration}, {0.0, bore.speed * duration}, Series::Style::reference});
    const double x_end = bore.speed * duration, r = bore.mass / (rho * depth);
    shape.series.push_back({"theory", {0.0, x_end, x_end, 1.3 * x_end}, {r, r, 1.0, 1.0}, Series::Style::reference});
    for (const int cells : s.cells) {
      Case c = strip_case(context, s.froude, cells, length, duration);
      if (with_snow) c.material = snow;
      const bool last = cells == s.cells.back();
      const FlowPicture picture{.id = s.id,
                                .field = FlowField::speed,
                                .title = s.name + fmt::format(", t = {:.1f} s", duration),
                                .caption = "The wall is on the left, the flow comes from the right.",
                                .window = std::array{-depth, 1.3 * x_end, -depth, 2.5 * bore.height}};
      Outcome o = run_strip(context, c, column, bore, last ? &picture : nullptr, result);
      particle_steps += o.particle_steps;
      size.push_back(c.numerics.cell_size);
      height.push_back(column.height(o.mass.mean * bore.mass) / depth);
      const std::string label = fmt::format("dx = H/{}", cells);
      front.series.push_back({label, o.time, o.front, Series::Style::simulation});
      Series profile{label, {}, {}, Series::Style::simulation};
      for (std::size_t i = 0; i < o.last.mass.size() && o.last.x(i) <= 1.3 * x_end; ++i) {
        profile.x.push_back(o.last.x(i));
        profile.y.push_back(o.last.mass[i] / (rho * depth));
      }
      shape.series.push_back(std::move(profile));
      context.log(fmt::format(
          "{}, H/dx = {}: depth {:.4f} of theory ({:.4f}), thrust {:.4f} ({:.4f}), speed {:.4f}, motion {:.4f}; {:.3g} "
          "particle-steps",
          s.name, cells, o.mass.mean, o.mass.standard_error, o.thrust.mean, o.thrust.standard_error, o.speed, o.motion, o.particle_steps));
      result.notes.push_back(fmt::format(
          "{}, dx = H/{}: h2/H {:.4f} (hydrostatic theory {:.4f}, incompressible {:.4f}), bore speed {:.3f} m/s ({:.3f}), thrust on the "
          "wall "
          "{:.2f} kN/m ({:.2f}); standard errors of mass and thrust {:.2f} and {:.2f} %; left of the motion: ∫ρu²dz behind the bore is "
          "{:.1f} % of the thrust.",
          s.name, cells, height.back(), bore.height / depth, ratio, o.speed * bore.speed, bore.speed, 1e-3 * o.thrust.mean * bore.thrust,
          1e-3 * bore.thrust, 100.0 * o.mass.standard_error, 100.0 * o.thrust.standard_error, 100.0 * o.motion));
      grids.push_back({cells, std::move(o)});
    }
    const Outcome& finest = grids.back().outcome;
    const double dx = size.back();
    const std::string reason = fmt::format("{}; and the floor's cell, which carries 1/8 too much stress: dx/(4 {{}})", s.reason);
    Check& h = result.check_relative(Label::verification, s.name + ": depth behind the bore, h2/H", height.back(), bore.height / depth, "",
                                     dx / (4.0 * bore.height) + s.unsteadiness, fmt::format(fmt::runtime(reason), "h2"));
    result.check_relative(Label::verification, s.name + ": mean thrust on the wall", 1e-3 * finest.thrust.mean * bore.thrust,
                          1e-3 * bore.thrust, "kN/m", dx / (4.0 * depth) + s.unsteadiness, fmt::format(fmt::runtime(reason), "H"));
    result.check_relative(Label::verification, s.name + ": speed of the bore", finest.speed * bore.speed, bore.speed, "m/s",
                          (dx / (4.0 * bore.height) + s.unsteadiness) * r / (r - 1.0),
                          "what is allowed for the depth, times r/(r - 1): the speed is v/(r - 1)");
    if (grids.size() >= 3) {
      const Convergence g3 = judge_convergence(size, height, 1.0);
      h.observed_order = g3.order;
      result.convergences.push_back({s.name + ": depth behind the bore", "H", g3});
    }
    result.plots.push_back(std::move(front));
    result.plots.push_back(std::move(shape));
    return std::pair{size, height};
  };

  const char* undular = "0.5 % for the waves that travel behind the front of an undular bore";
  const char* rolling =
      "2.5 % for what is left of the motion behind the bore, whose ∫ρu²dz of up to 5 % of the thrust takes half that from the depth";
  const auto low = study(
      {"Fr 0.3", "fr03", 0.3, 12.0, context.choose<std::vector<int>>({4, 6, 8}, {4, 6, 8, 12}, {4, 6, 8, 12, 16}), 0.005, undular}, false);
  const auto middle =
      study({"Fr 1", "fr1", 1.0, 8.0, context.choose<std::vector<int>>({4}, {4, 6, 8, 12}, {4, 6, 8, 12, 16}), 0.025, rolling}, false);
  study({"Fr 1, snow with M = 0", "fr1-snow", 1.0, 8.0, context.choose<std::vector<int>>({4}, {6}, {4, 6, 8}), 0.025, rolling}, true);
  study({"Fr 3", "fr3", 3.0, context.choose(6.0, 6.0, 12.0), context.choose<std::vector<int>>({4}, {4, 6}, {4, 6, 8}), 0.2,
         "20 % for the splash: it falls back from above the bore, and leaves ∫ρu²dz of 20 to 45 % of the thrust behind it"},
        false);

  const auto convergence = [&](const char* id, const char* name, double froude, const auto& data) {
    const double exact = reflected_bore(fluid, rho * depth, froude * std::sqrt(g * depth)).height / depth;
    Series errors{"simulation", data.first, {}, Series::Style::points};
    for (const double h : data.second) errors.y.push_back(std::abs(h / exact - 1.0));
    const double at_finest = errors.y.front() * data.first.back() / data.first.front();
    result.plots.push_back({id,
                            std::string("Error of the depth behind the bore, ") + name,
                            "dx [m]",
                            "|h2/h2,theory - 1| [-]",
                            {slope_line("order 1", data.first, at_finest, 1.0), errors},
                            "",
                            true,
                            true});
    return fitted_order(data.first, errors.y);
  };
  result.check_order(Label::verification, "Fr 0.3: order of the depth behind the bore", convergence("fr03-order", "Fr 0.3", 0.3, low), 0.5,
                     1.5, "first order at the floor; half an order for the waves, which change with the grid");
  if (middle.first.size() > 1) convergence("fr1-order", "Fr 1", 1.0, middle);
  result.notes.push_back(fmt::format("{:.2g} particle-steps in all.", particle_steps));
}

const Registration registered{{MPM_CASE_NAME, "Flow against a full-width wall: the reflected bore", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
