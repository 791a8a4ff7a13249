#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"

namespace mpm::validation::fluid_at_rest {
namespace {

/// Fluid at rest.
class Hydrostatic {
 public:
  explicit Hydrostatic(const Case& c)
      : bulk_(c.material.as<WeaklyCompressibleFluid>().bulk_modulus),
        exponent_(c.material.as<WeaklyCompressibleFluid>().tait_exponent),
        weight_(c.material.density() * c.numerics.gravity) {}
  /// Pressure at a depth below the surface, Pa: dp/dd = rho(p) g with rho = rho_0 (1 + n p/K)^(1/n).
  [[nodiscard]] double pressure(double depth) const {
    const double n = exponent_;
    return depth > 0.0 ? bulk_ / n * (std::pow(1.0 + (n - 1.0) * weight_ * depth / bulk_, n / (n - 1.0)) - 1.0) : 0.0;
  }
  [[nodiscard]] double volume_ratio(double depth) const { return std::pow(1.0 + exponent_ * pressure(depth) / bulk_, -1.0 / exponent_); }
  /// rho_0 g, N/m^3
  [[nodiscard]] double weight() const { return weight_; }

 private:
  double bulk_, exponent_, weight_;
};

/// Mean of f over an interval: midpoint rule.
double mean_of(double from, double to, const std::function<double(double)>& f) {
  constexpr int parts = 400;
  double sum = 0.0;
  for (int i = 0; i < parts; ++i) sum += f(from + (to - from) * (i + 0.5) / parts);
  return sum / parts;
}

/// The particles of a case, at rest with the pressure below a horizontal surface.
State state_at_rest(const Case& c, const CaseScene& scene, double surface) {
  const Hydrostatic fluid(c);
  const State lattice = make_state(c, scene);
  State state(c.numerics.cell_size, c.numerics.precision);
  state.next_id = lattice.next_id;
  lattice.grid.for_each_particle([&](Particle p) {
    const double depth = surface - p.position[2] + scene.offset.z(), ratio = fluid.volume_ratio(depth);
    for (int i = 0; i < 3; ++i) p.stress[i] = -ratio * fluid.pressure(depth);
    p.internal = ratio - 1.0;
    p.volume /= ratio;
    state.grid.insert(p);
  });
  state.grid.refresh();
  return state;
}

// ---- a tank ---------------------------------------------------------------------------------------------------------------------------

struct Tank {
  std::vector<double> time, error;       ///< s; rms of the particles' pressures less the exact ones, over rho_0 g H
  std::vector<double> height, pressure;  ///< of the particles at the end, over H and rho_0 g H
};

Tank rest_in_tank(const CaseContext& context, Lattice lattice) {
  Case c = context.read_case("tank.toml");
  const double depth = c.bodies[0].max.z();
  c.bodies[0].lattice = lattice;
  const Hydrostatic fluid(c);
  const CaseScene scene = make_scene(c);
  State state = state_at_rest(c, scene, depth);
  const double scale = fluid.weight() * depth;
  Tank tank;
  const auto measure = [&] {
    double sum = 0.0, count = 0.0;
    tank.height.clear(), tank.pressure.clear();
    state.grid.for_each_particle([&](const Particle& p) {
      const double z = p.position[2] - scene.offset.z();
      const double pressure = -(p.stress[0] + p.stress[1] + p.stress[2]) / (3.0 * (1.0 + p.internal));
      sum += std::pow((pressure - fluid.pressure(depth - z)) / scale, 2), count += 1.0;
      tank.height.push_back(z / depth), tank.pressure.push_back(pressure / scale);
    });
    tank.time.push_back(state.time), tank.error.push_back(std::sqrt(sum / count));
  };
  constexpr int samples = 70;
  for (int i = 0; i <= samples; ++i) {
    advance(state, scene, c.output.duration * i / samples);
    measure();
  }
  return tank;
}

void tank(const CaseContext& context, CaseResult& result) {
  const std::array lattices = {std::pair{Lattice::aligned, "aligned"}, std::pair{Lattice::staggered, "staggered"}};
  std::array<Tank, lattices.size()> all;
  in_parallel(all.size(), [&](std::size_t i) { all[i] = rest_in_tank(context, lattices[i].first); });
  Plot history{"tank-error", "Tank: error of the pressure of single particles", "time [s]", "rms error over ρ0 g H [-]"};
  Plot profile{"tank-pressure", "Tank: pressure of the particles at the end", "p / ρ0 g H [-]", "z / H [-]"};
  const Case c = context.read_case("tank.toml");
  const double depth = c.bodies[0].max.z();
  const Hydrostatic fluid(c);
  Series exact =
      reference_curve("exact", 0.0, 1.0, 20, [&](double z) { return fluid.pressure(depth * (1.0 - z)) / (fluid.weight() * depth); });
  std::swap(exact.x, exact.y);
  for (std::size_t i = all.size(); i-- > 0;) {
    const std::string name = fmt::format("{} lattice", lattices[i].second);
    Check& check = result.check_absolute(
        Label::verification,
        fmt::format("tank, {}: pressure of single particles after {:g} s, rms error over ρ0 g H", name, c.output.duration),
        all[i].error.back(), 0.0, "", 0.02,
        "a third of the pressure between two rows of particles, 1/16 here: rows keep their order in pressure");
    if (lattices[i].first == Lattice::staggered)
      check.known_miss(0.75,
                       "the grid does not feel differences of pressure within a cell, and shifted layers excite them: see the README");
    history.series.push_back({name, all[i].time, all[i].error, Series::Style::simulation});
    profile.series.push_back({name, all[i].pressure, all[i].height, Series::Style::points});
  }
  profile.series.push_back(exact);
  result.plots.push_back(std::move(history));
  result.plots.push_back(std::move(profile));
}

// ---- a covered box --------------------------------------------------------------------------------------------------------------------

/// Mean forces on the obstacle of a half model, N: along x and z of the whole, along y of the computed side. From a time on.
Vec3 mean_force(const CaseScene& scene, State& state, double from, double until) {
  advance(state, scene, from);
  Vec3 impulse = Vec3::Zero();
  advance(state, scene, until, [&](const StepReport& step) { impulse += step.impulses[*scene.obstacle].linear; });
  return impulse.cwiseProduct(Vec3(2.0, 1.0, 2.0)) / (until - from);
}

constexpr const char* both_ends = "front and back together";

/// Forces that miss the aim, over the exact ones: at least this at 4 and at 8 cells across the box.
const std::map<std::string, std::array<double, 2>> known_shares = {{"top", {0.90, 0.97}}, {both_ends, {0.60, 0.80}}};

struct Force {
  std::string name;
  double value, exact;  ///< N
};

/// A box that reaches through the tank's end: each of its wet faces points along an axis of its own.
std::vector<Force> jetty(const CaseContext& context, double cell_size) {
  Case c = context.read_case();
  c.numerics.cell_size = cell_size;
  c.numerics.slope = 0.0;
  const double height = *c.obstacle->height, end = 1.0, surface = c.bodies[0].max.z();
  auto& box = c.obstacle->as<BoxShape>();
  box.depth = 2.0;
  const double width = box.width, wet = end;
  c.bodies.pop_back();  // the fluid behind the box
  c.walls[2].point.x() = end;
  const CaseScene scene = make_scene(c);
  State state = state_at_rest(c, scene, surface);
  const Vec3 force = mean_force(scene, state, 2.0, 3.0);
  const Hydrostatic fluid(c);
  const double on_side = height * mean_of(0.0, height, [&](double z) { return fluid.pressure(surface - z); });
  return {{"front", force.x(), width * on_side},
          {"side", -force.y(), wet * on_side},
          {"top", -force.z(), width * wet * fluid.pressure(surface - height)}};
}

/// The case file's box on its slope.
std::vector<Force> on_slope(const CaseContext& context, CaseResult& result, double cell_size, bool picture) {
  Case c = context.read_case();
  c.numerics.cell_size = cell_size;
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const Vec3 force = mean_force(scene, state, 4.0, c.output.duration);
  if (picture)
    result.flows.push_back(flow_picture(context.directory(), state, scene,
                                        {.id = "box",
                                         .field = FlowField::pressure,
                                         .title = "Covered box on a slope of 5°",
                                         .caption = "At the end, in the plane of symmetry.",
                                         .slice_half_width = 0.5 * cell_size}));
  // the surface is where the fluid has its mass: depth of a point below it, for a level at the middle of the box
  const Hydrostatic fluid(c);
  const double tilt = c.numerics.slope, height = *c.obstacle->height, width = c.obstacle->as<BoxShape>().width,
               length = c.obstacle->as<BoxShape>().depth, x0 = c.walls[1].point.x(), x1 = c.walls[2].point.x(), side = c.walls[3].point.y(),
               top = c.bodies[0].max.z();
  const auto depth = [&](double x, double z, double level) { return (level - z) * std::cos(tilt) + (x - 0.5 * length) * std::sin(tilt); };
  const auto volume = [&](double level) {  // of the fluid without pressure, half model
    return mean_of(x0, x1,
                   [&](double x) {
                     return mean_of(0.0, 1.5 * top, [&](double z) {
                       const bool beside = z < height && x > 0.0 && x < length;
                       const double d = depth(x, z, level);
                       return d > 0.0 ? (side - (beside ? 0.5 * width : 0.0)) / fluid.volume_ratio(d) : 0.0;
                     });
                   }) *
           (x1 - x0) * 1.5 * top;
  };
  double filled = 0.0;
  for (const BodySpec& body : c.bodies) filled += volume_of(body);
  double low = 0.5 * top, high = top;
  for (int i = 0; i < 30; ++i) (volume(0.5 * (low + high)) < filled ? low : high) = 0.5 * (low + high);
  const auto face = [&](double x) { return height * mean_of(0.0, height, [&](double z) { return fluid.pressure(depth(x, z, low)); }); };
  return {{both_ends, -force.x(), width * (face(length) - face(0.0))},
          {"top", -force.z(), width * length * mean_of(0.0, length, [&](double x) { return fluid.pressure(depth(x, height, low)); })}};
}

void covered_box(const CaseContext& context, CaseResult& result) {
  const auto cells = context.choose<std::vector<int>>({4}, {4, 8}, {4, 8, 12});
  struct Scene {
    std::string name;
    int cells;
    std::vector<Force> forces = {};
  };
  std::vector<Scene> scenes;
  for (const int n : cells) scenes.push_back({"box at the end of a tank", n}), scenes.push_back({"box on a slope of 5°", n});
  for (std::size_t i = scenes.size(); i-- > 0;) {
    Scene& s = scenes[i];
    s.forces = i % 2 == 0 ? jetty(context, 1.0 / s.cells) : on_slope(context, result, 1.0 / s.cells, s.cells == cells.back());
  }
  Plot plot{"forces", "Forces on a covered box", "dx over the width of the box [-]", "force over the exact one [-]"};
  for (std::size_t kind = 0; kind < 2; ++kind) {
    std::vector<Series> lines;
    for (std::size_t i = kind; i < scenes.size(); i += 2) {
      const Scene& s = scenes[i];
      lines.resize(s.forces.size());
      for (std::size_t f = 0; f < s.forces.size(); ++f) {
        const Force& force = s.forces[f];
        Check& check =
            result.check_relative(Label::verification, fmt::format("{}, {} cells across: force on its {}", s.name, s.cells, force.name),
                                  force.value, force.exact, "N", s.cells < 8 ? 0.02 : 0.01, "the aim: 2 % at 4 cells, 1 % at 8");
        if (force.name != both_ends) check.in_summary(Quantity::force);  // that is a difference of two forces
        if (const auto known = known_shares.find(force.name); known != known_shares.end())
          check.known_miss(known->second[s.cells < 8 ? 0 : 1] * force.exact,
                           force.name == both_ends ? "a difference of two forces, small beside each of them: see the README"
                                                   : "the corners of the top carry too little: see the README");
        lines[f].name = s.name + ", " + force.name;
        lines[f].style = Series::Style::points;
        lines[f].x.push_back(1.0 / s.cells), lines[f].y.push_back(force.value / force.exact);
      }
    }
    std::ranges::move(lines, std::back_inserter(plot.series));
  }
  result.plots.push_back(std::move(plot));
}

void run(const CaseContext& context, CaseResult& result) {
  tank(context, result);
  covered_box(context, result);
}

const Registration registered{{.title = "Fluid at rest", .run = run}};

}  // namespace
}  // namespace mpm::validation::fluid_at_rest
