#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmpm/driver/scene.hpp"
#include "validation/cases/cavity_expansion/similarity.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/norms.hpp"

namespace mpm::validation::cavity_expansion {
namespace {

constexpr double inner = 1.0;     ///< m: radius of the cavity
constexpr double pressure = 8e3;  ///< in situ, Pa

/// How far the cavity is widened, and how that is computed.
struct Variant {
  std::string name;
  double expansion = 0.005;  ///< of the radius
  std::vector<int> grids;    ///< cells in the radius
  int per_axis = 2;          ///< particles per cell and axis
  Transfer transfer = Transfer::aflip;
  double outer = 2.5;  ///< m: radius from which the rim is moved; the plastic zone ends within it
  /// s: four times that of the fastest wave through the ring
  [[nodiscard]] double duration(double speed) const { return 4.0 * outer / speed; }
};

CamClay model_of(const mpm::CamClay::Parameters& p) {
  return CamClay::from_young(p.young_modulus, p.poisson_ratio, p.critical_state_slope, p.cohesion_beta, p.hardening_xi,
                             p.preconsolidation_pressure);
}

/// Checks of the reference by what it was not made from.
void check_reference(CaseResult& result, const CamClay& model, const AnyMaterial& law) {
  const CavityExpansion long_path(model, pressure, 2.0);
  const SimilarState& last = long_path.states().back();
  result.check_relative(Label::verification, "reference: q/p at a hoop strain of 2 over the critical state's", last.q / last.p,
                        exact::critical_ratio(model), "", 0.01,
                        "next to an endlessly grown cavity snow is in the critical state; it comes close as the strain goes on");
  const CavityExpansion elastic(model, pressure, 1e-3, false);
  const SimilarState& small = elastic.states().back();
  result.check_relative(Label::verification, "reference, elastic: change of the radial stress at a hoop strain of 0.001, over 2 G s",
                        -(small.radial + pressure) / (2.0 * model.shear_modulus * small.strain), 1.0, "", 0.005,
                        "Lamé: τ_r = −p0 − 2 G s; finite strain adds terms of the order s");
  // equilibrium by differences along the radius at one time, from stresses and stretches alone
  const CavityExpansion path(model, pressure, 0.3);
  double worst = 0.0;
  const double far = path.place_of(1e-4), near = path.place_of(0.29), h = 5e-3;
  const double kink = path.place_of(path.onset());
  for (int i = 0; i < 200; ++i) {
    const double place = near + (far - near) * (i + 0.5) / 200;
    if (std::abs(place - kink) < 2.0 * h) continue;
    const auto piola = [&](double l) {
      const SimilarState s = path.at(l);
      return s.radial / std::exp(s.radial_strain);
    };
    const SimilarState here = path.at(place);
    const double residual =
        (piola(place + h) - piola(place - h)) / (2.0 * h) + here.radial / std::exp(here.radial_strain) - here.hoop / std::exp(here.strain);
    worst = larger(worst, std::abs(residual));
    const double stretch = (std::exp(place + h + path.at(place + h).strain) - std::exp(place - h + path.at(place - h).strain)) / (2.0 * h);
    worst = larger(worst, pressure * std::abs(stretch / std::exp(place) / std::exp(here.radial_strain) - 1.0));
  }
  result.check_at_most(Label::verification,
                       "reference: residual of the equilibrium and of dr/dR, by differences, over the in-situ pressure", worst / pressure,
                       0.0, "", 1e-4,
                       "differences over half a per cent of a radius: their third derivatives, and a table with linear interpolation");
  // the library's law along the path of a particle
  constexpr int steps = 20000;
  const SimilarState first = path.states().front();
  MaterialState<double> state{{-pressure, -pressure, -pressure, 0.0, 0.0, 0.0}, model.initial_internal()};
  double before_s = 0.0, before_r = 0.0, largest = 0.0, scale = 0.0;
  for (int i = 1; i <= steps; ++i) {
    const double place = first.place + (path.states().back().place - first.place) * i / steps;
    const SimilarState now = path.at(place);
    Matrix3<double> dl{};
    dl.m[0][0] = now.radial_strain - before_r;
    dl.m[1][1] = now.strain - before_s;
    before_r = now.radial_strain, before_s = now.strain;
    std::visit([&](const auto& l) { l.update_stress(state, dl, 1e-3); }, law);
    largest = std::max(
        {largest, std::abs(state.stress.xx - now.radial), std::abs(state.stress.yy - now.hoop), std::abs(state.stress.zz - now.axial)});
    scale = larger(scale, std::abs(now.radial));
  }
  result.check_at_most(Label::verification, "reference: stresses against the library's law along the path of a particle, over the largest",
                       largest / scale, 0.0, "", 1e-3, "20000 steps of backward Euler, which is of first order, on a strain of 0.3");
}

/// The exact solutions of all variants.
struct Exact {
  CamClay model;
  CavityExpansion family;
  double speed;  ///< of the fastest wave, m/s
  [[nodiscard]] RadialMotion motion_of(const Variant& v) const { return family.motion(inner, std::log1p(v.expansion), v.duration(speed)); }
  /// The widened cavity.
  [[nodiscard]] RadialState end_of(const Variant& v) const { return motion_of(v)(v.duration(speed)); }
};

/// The second and the third differ in nothing but the number of particles.
std::vector<Variant> variants_of(const CaseContext& context) {
  const auto grids = context.choose<std::vector<int>>({8, 12, 16}, {8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48});
  const auto fewer = context.choose<std::vector<int>>({12}, {8, 12, 16}, {8, 12, 16, 24, 32});
  std::vector<Variant> variants = {{"0.5 %", 0.005, grids}, {"2 %", 0.02, fewer}, {"2 %, 9 particles", 0.02, fewer, 3}};
  if (context.level() != Level::quick) {
    variants.push_back({"0.5 %, APIC", 0.005, grids, 2, Transfer::apic});
    variants.push_back({.name = "10 %", .expansion = 0.1, .grids = fewer, .outer = 4.0});
    variants.push_back({.name = "10 %, 9 particles", .expansion = 0.1, .grids = fewer, .per_axis = 3, .outer = 4.0});
  }
  return variants;
}

/// Runs all variants, several at a time. @returns their errors by variant and grid
std::vector<std::vector<RadialErrors>> run_variants(const Case& base, const Exact& exact, const std::vector<Variant>& variants) {
  struct Task {
    std::size_t variant;
    int cells;
  };
  std::vector<Task> tasks;
  std::vector<std::vector<RadialErrors>> all(variants.size());
  for (std::size_t k = 0; k < variants.size(); ++k) {
    for (const int cells : variants[k].grids) tasks.push_back({k, cells});
    all[k].resize(variants[k].grids.size());
  }
  std::ranges::sort(tasks, [](const Task& a, const Task& b) { return a.cells > b.cells; });  // the longest first
  in_parallel(tasks.size(), [&](std::size_t i) {
    const Variant& v = variants[tasks[i].variant];
    const auto place = static_cast<std::size_t>(std::ranges::find(v.grids, tasks[i].cells) - v.grids.begin());
    const RadialSetting setting{.inner = inner,
                                .outer = v.outer,
                                .cells = tasks[i].cells,
                                .per_axis = v.per_axis,
                                .initial_volume_ratio = exact.family.initial_volume_ratio(),
                                .duration = v.duration(exact.speed),
                                .transfer = v.transfer};
    all[tasks[i].variant][place] = run_radial(base, setting, exact.motion_of(v));
  });
  return all;
}

/// Checks a variant and adds it to the plot of errors.
void check_variant(CaseResult& result, Plot& errors, const Exact& exact, const Variant& v, const std::vector<RadialErrors>& runs) {
  const RadialPoint wall = exact.end_of(v)(inner);
  const double change = -(wall.radial + pressure), moved = wall.r - inner, hardened = wall.internal - exact.model.initial_internal();
  std::vector<double> cell, displacement, radial, hoop, internal;
  double work = 0.0;
  for (const RadialErrors& e : runs) {
    cell.push_back(e.cell);
    displacement.push_back(e.displacement / moved);
    radial.push_back(e.radial / change), hoop.push_back(e.hoop / change), internal.push_back(e.internal / hardened);
    work += e.particle_steps;
  }
  if (v.expansion < 0.01) {
    const auto order = [&](const std::string& what, const std::vector<double>& error) {
      const double p = fitted_order(cell, error);
      result
          .check_order(Label::verification, v.name + ": order of the " + what, p, 0.8, 3.0,
                       "a particle's gradient is that of its cell but for an error of first order, which changes sign within the cell; the "
                       "return map is of first order, too")
          .observed_order = p;
    };
    order("radial stress", radial);
    order("hoop stress", hoop);
    order("plastic volume strain", internal);
  }
  result.check_at_most(Label::verification,
                       fmt::format("{}, {} cells: error of the displacement over that of the wall", v.name, v.grids.back()),
                       displacement.back(), 0.0, "", 0.005,
                       "the sum over particles off their lattice errs by 5 % of the strain: times the in-situ stress, over what the "
                       "expansion changes, 0.2 %; doubled, and the grid's own error");
  const RadialErrors& finest = runs.back();
  result
      .check_relative(Label::verification, v.name + ": radial stress at the cavity, finest grid", -1e-3 * finest.wall_stress,
                      -1e-3 * finest.wall_exact, "kPa", 0.02, "2 %: first order at 12 cells in the radius and more")
      .in_summary(Quantity::pressure);
  if (v.per_axis == 2) {
    errors.series.push_back({v.name + ": displacement", cell, displacement, Series::Style::points});
    errors.series.push_back({v.name + ": radial stress", cell, radial, Series::Style::points});
  }
  result.notes.push_back(
      fmt::format("{}: displacement {:.1e} to {:.1e} of the wall's, radial stress {:.1e} to {:.1e}, hoop stress {:.1e} to {:.1e} of the "
                  "change at the wall, plastic volume strain {:.1e} to {:.1e} of the wall's; {:.1f} million particle-steps.",
                  v.name, displacement.front(), displacement.back(), radial.front(), radial.back(), hoop.front(), hoop.back(),
                  internal.front(), internal.back(), 1e-6 * work));
}

/// Fields of a run against the exact ones.
void draw_fields(CaseResult& result, const Exact& exact, const Variant& shown, const RadialErrors& ours) {
  const RadialState end = exact.end_of(shown);
  const auto line = [&](const std::string& name, double RadialPoint::*what, double scale) {
    return reference_curve(name, 1.0, shown.outer / inner, 150, [&](double x) { return scale * (end(x * inner).*what); });
  };
  const auto points = [&](const std::string& name, const std::vector<double>& values, double scale) {
    Series s{name, ours.place, {}, Series::Style::points};
    for (const double value : values) s.y.push_back(scale * value);
    return s;
  };
  const std::string grid = fmt::format("{} cells in a", shown.grids.front());
  result.plots.push_back({"stress",
                          "Stresses, widened by 2 %",
                          "R / a [-]",
                          "-τ [kPa]",
                          {line("radial, exact", &RadialPoint::radial, -1e-3), line("hoop, exact", &RadialPoint::hoop, -1e-3),
                           points("radial, " + grid, ours.radial_values, -1e-3), points("hoop, " + grid, ours.hoop_values, -1e-3)}});
  result.plots.push_back({"internal",
                          "Plastic volume strain, widened by 2 %",
                          "R / a [-]",
                          "X [-]",
                          {line("exact", &RadialPoint::internal, 1.0), points(grid, ours.internal_values, 1.0)}});
}

/// What the exact solution says of the plastic zone.
void note_plastic_zone(CaseResult& result, const CavityExpansion& family) {
  for (const double expansion : {0.005, 0.02, 0.1}) {
    const double s = std::log1p(expansion), from = family.place_of(s);
    result.notes.push_back(
        fmt::format("Exact, widened by {:g} %: the plastic zone reaches R = {:.2f} a; radial stress at the cavity {:.2f} "
                    "kPa, in situ {:.2f} kPa.",
                    100.0 * expansion, std::exp(family.place_of(family.onset()) - from), -1e-3 * family.at(from).radial, 1e-3 * pressure));
  }
}

void run(const CaseContext& context, CaseResult& result) {
  const Case base = context.read_case();
  const CaseScene scene = make_scene(base);
  const CamClay model = model_of(base.material.as<mpm::CamClay>());
  check_reference(result, model, scene.material);

  const Exact exact{model, CavityExpansion(model, pressure, 0.6), wave_speed_of(scene.material)};
  const std::vector<Variant> variants = variants_of(context);
  const std::vector<std::vector<RadialErrors>> all = run_variants(base, exact, variants);
  Plot errors{"errors", "Errors over what the expansion changes at the cavity", "dx / a [-]", "root mean square error [-]", {}, "", true,
              true};
  for (std::size_t k = 0; k < variants.size(); ++k) check_variant(result, errors, exact, variants[k], all[k]);
  errors.series.push_back(slope_line("order 1", errors.series[1].x, errors.series[1].y.back(), 1.0));
  result.plots.push_back(std::move(errors));
  result.check_at_most(Label::verification,
                       fmt::format("2 %, {} cells: error of the displacement with 9 over that with 4 particles in the plane of a cell",
                                   variants[1].grids.back()),
                       all[2].back().displacement / all[1].back().displacement, 2.0 / 3.0, "", 0.0,
                       "midpoint quadrature: at least first order in the number of particles, 2/3");
  draw_fields(result, exact, variants[1], all[1].front());
  note_plastic_zone(result, exact.family);
}

const Registration registered{{.title = "Expansion of a cylindrical cavity in snow", .run = run}};

}  // namespace
}  // namespace mpm::validation::cavity_expansion
