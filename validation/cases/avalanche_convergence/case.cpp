#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mpm/error.hpp"
#include "mpm/io/config.hpp"
#include "mpm/post.hpp"
#include "mpm/run.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/flow.hpp"
#include "validation/harness/grid_convergence.hpp"

namespace mpm::validation {
namespace {

/// The figures of one run, in the order of `studied`.
enum FigureIndex : std::size_t { force_x, runup, pressure_height, pressure_height_in_cells, impact_pressure };
/// Order 2 in the interior, 1 at walls: what lies between 0.5 and 2 counts as credible (the window of Eca & Hoekstra, too).
constexpr double formal_order = 1.5;
const std::vector<StudiedFigure> studied{{"force on the mast", "N", formal_order},
                                         {"run-up", "m", formal_order},
                                         {"pressure height", "m", formal_order},
                                         {"pressure height, the paper's windows in cells", "m", formal_order},
                                         {"pressure before the face", "Pa", formal_order}};
const std::vector<FigureIndex> asserted{force_x, runup, pressure_height};

Figure figure(const MeanEstimate& e) { return {e.mean, e.standard_error}; }

/// Two standard errors of a difference.
double noise(const Figure& a, const Figure& b) { return 2.0 * std::hypot(a.standard_error, b.standard_error); }

/// Runs the case of this folder and its variants, each once.
class Runs {
 public:
  Runs(const CaseContext& context, CaseResult& result)
      : context_(context), result_(result), base_(read_case(context.case_directory() / "case.toml")) {
    base_.output.duration = context.choose(5.0, base_.output.duration, 8.0);
    base_.output.frames_per_second = 0.0;
  }

  [[nodiscard]] double width() const { return base_.obstacle->width; }
  [[nodiscard]] std::uint64_t particle_steps() const { return particle_steps_; }
  [[nodiscard]] const std::vector<std::string>& unsteady() const { return unsteady_; }

  /// At w/n.
  [[nodiscard]] Case at(int cells_per_width) const {
    Case c = base_;
    c.numerics.cell_size = width() / cells_per_width;
    return c;
  }

  /// @param picture whether the end of this run is shown
  std::vector<Figure> operator()(const std::string& name, const Case& c, bool picture = false) {
    if (const auto done = done_.find(case_hash(c)); done != done_.end()) return done->second;
    const ImpactGeometry in_cells =
        paper_geometry(c.conveyor->flow_height, c.obstacle->width, c.numerics.cell_size, c.material.density, c.conveyor->mirror_y);
    std::vector<double> heights;  // h_p in the paper's windows, sample by sample
    RunOptions options;
    options.out = context_.directory() / name;
    options.on_sample = [&](const State& state, const Scene& scene, const Vec3&, const Vec3&) {
      heights.push_back(measure_impact(state, scene, in_cells).pressure_height.value_or(Figure::none));
      if (!picture || state.time < c.output.duration) return;
      result_.flows.push_back(flow_picture(context_.directory(), state, scene,
                                           {.id = "end",
                                            .field = FlowField::stress_xx,
                                            .title = fmt::format("The jet at the mast, {}, t = {:g} s", name, state.time),
                                            .caption = "Particles near the mast's axis at the end of one of the runs.",
                                            .slice_half_width = 0.5 * c.numerics.cell_size}));
    };
    const RunResult run = run_case(c, options);
    if (!run.impact) throw UnstableError("the run left no summary of the impact");
    const ImpactSummary& s = *run.impact;
    particle_steps_ += run.particle_steps;
    context_.log(fmt::format(
        "{}: {} particles, {} steps, {:.1f} million particle-steps, {:.0f} s; {}", name, run.particles, run.steps,
        1e-6 * static_cast<double>(run.particle_steps), run.wall_time_s,
        s.span.steady ? fmt::format("run-up {:.3f} m, force {:.1f} kN", s.runup.mean, 1e-3 * s.force[0].mean) : "no steady span"));
    if (!s.span.steady) unsteady_.push_back(name);
    const Figure height_in_cells =
        s.span.steady ? figure(estimate_mean(std::span(heights).subspan(s.span.first, s.span.last - s.span.first))) : Figure{};
    return done_[case_hash(c)] = {figure(s.force[0]), figure(s.runup), figure(s.pressure_height), height_in_cells,
                                  figure(s.impact_pressure)};
  }

 private:
  const CaseContext& context_;
  CaseResult& result_;
  Case base_;
  std::map<std::uint64_t, std::vector<Figure>> done_;
  std::uint64_t particle_steps_ = 0;
  std::vector<std::string> unsteady_;
};

std::string list(const std::vector<int>& cells) {
  std::string text;
  for (const int n : cells) text += fmt::format("{}w/{}", text.empty() ? "" : ", ", n);
  return text;
}

/// Studies of all figures on the grids w/n.
std::vector<FigureStudy> grid_family(CaseResult& result, Runs& runs, const std::string& id, const std::vector<int>& cells, int pictured) {
  std::vector<double> sizes;
  for (const int n : cells) sizes.push_back(runs.width() / n);
  std::vector<StudiedFigure> figures = studied;
  for (StudiedFigure& f : figures) f.quantity += ", " + id;
  auto studies = record_grid_study(result, id, SweepKind::cell_size, sizes, figures, [&](double dx) {
    const int n = static_cast<int>(std::lround(runs.width() / dx));
    return runs(fmt::format("w{}", n), runs.at(n), n == pictured);
  });
  if (!studies[force_x].study) throw UnstableError(fmt::format("{}: fewer than three grids have a steady span", id));
  return studies;
}

/// Order at which a study extrapolates: that of its least-squares fit, else that of its three finest grids if it is credible, else 1.
double order_of(const FigureStudy& s) {
  if (std::isfinite(s.study->least_squares_order)) return s.study->least_squares_order;
  return s.study->safety_factor < 3.0 ? s.study->order : 1.0;
}

/// The uncertainty that a study states on a coarser grid of its own: its error falls with its order.
double uncertainty_at(const FigureStudy& s, double cell_size) {
  return s.uncertainty * std::pow(cell_size / s.parameter.back(), order_of(s));
}

/// What all grids but the finest state about themselves has to cover what the finest then gives.
void check_prediction(CaseResult& result, const FigureStudy& s, const std::string& unit) {
  const FigureStudy before =
      study_figure(s.name, s.kind, {s.parameter.begin(), s.parameter.end() - 1}, {s.figure.begin(), s.figure.end() - 1}, {}, formal_order);
  const Figure &last = s.figure.back(), &next = before.figure.back();
  result.check_at_most(
      Label::verification, fmt::format("{}: change from dx = {:.3f} to {:.3f} m", s.name, before.parameter.back(), s.parameter.back()),
      std::abs(last.value - next.value), before.uncertainty, unit, noise(last, next),
      "numerical uncertainty that the coarser grids state for themselves (GCI); the slack is twice the statistical error of the "
      "difference");
}

/// A change of something that no result should depend on has to stay within the uncertainty of the grid.
void check_covered(CaseResult& result, const std::string& quantity, const Figure& base, const Figure& changed, double uncertainty,
                   const std::string& unit) {
  result.check_at_most(
      Label::verification, quantity, std::abs(changed.value - base.value), uncertainty, unit, noise(base, changed),
      "numerical uncertainty of this grid, from the grid study and carried to this cell size with the study's order (1 where it has none); "
      "the slack is twice the statistical error of the difference");
}

/// Rows of nodes along the flow that stop it at the mast's face, for a mast n cells wide and a scene shifted by parts of a cell. A node
/// inside the mast belongs to its nearest face (RigidBox), the front face first: in the first row behind that face, those nodes stop the
/// flow that are at least as deep below the nearest side; the others slip along it.
int blocking_rows(int n, double along, double across) {
  const double depth = std::ceil(along) - along;  // of the first row below the face, in cells
  int rows = 0;
  for (int k = -n; k <= n; ++k) {
    const double below_side = 0.5 * n - std::abs(k - across);
    if (below_side >= depth) ++rows;
  }
  return rows;
}

void run(const CaseContext& context, CaseResult& result) {
  Runs runs(context, result);
  // Whole numbers of cells. Even: a row of nodes on each side of the mast, which blocks a cell more than it is wide; odd: none.
  using Family = std::vector<int>;
  const bool quick = context.level() == Level::quick;
  const Family even_grids = context.choose(Family{}, Family{4, 6, 8, 12}, Family{4, 6, 8, 12, 16});
  const Family odd_grids = context.choose(Family{3, 5, 7}, Family{3, 5, 7}, Family{3, 5, 7, 9, 11});
  const int pictured = context.choose(7, 12, 16), n = context.choose(5, 6, 6);
  const std::vector<FigureStudy> odd = grid_family(result, runs, "odd w/dx", odd_grids, pictured);
  const std::vector<FigureStudy> even = quick ? odd : grid_family(result, runs, "even w/dx", even_grids, pictured);
  for (const auto* family : quick ? std::vector{&odd} : std::vector{&odd, &even}) {
    const FigureStudy& force = (*family)[force_x];
    result.check_order(Label::verification, force.name + ": observed order, three finest", force.study->order, 0.5, 2.0,
                       "1 at walls, 2 in the interior; 0.5 to 2 is what Eca & Hoekstra take as credible");
    for (const FigureIndex i : asserted) {
      if ((*family)[i].study->size.size() > 3) check_prediction(result, (*family)[i], studied[i].unit);
    }
  }
  for (const FigureIndex i : asserted) {
    if (quick) break;
    const Figure &a = even[i].figure.back(), &b = odd[i].figure.back();
    result.check_at_most(Label::verification, studied[i].quantity + ": finest even against finest odd grid", std::abs(a.value - b.value),
                         even[i].uncertainty + odd[i].uncertainty, studied[i].unit, noise(a, b),
                         "both families go to the same limit, so their intervals of numerical uncertainty overlap; the slack is twice the "
                         "statistical error of the difference");
  }
  result.check_absolute(Label::verification, "grids without a steady span", static_cast<double>(runs.unsteady().size()), 0.0, "", 0.0,
                        "a mean needs a steady span, and the runs are long enough for one");

  // One grid, everything else varied.
  const Case base = runs.at(n);
  const double dx = base.numerics.cell_size;
  const std::vector<Figure> at_base = runs(fmt::format("w{}", n), base);
  const auto variant = [&](const std::string& name, const auto& change) {
    Case c = base;
    change(c);
    return runs(fmt::format("w{}_{}", n, name), c);
  };
  const auto shifted = [&](const std::string& name, const Vec3& offset) {
    return variant(name, [&](Case& c) {
      c.numerics.grid_offset = offset;
      if (offset.y() != 0.0) c.conveyor->mirror_y = false;  // the plane y = 0 is then off the grid
    });
  };
  const std::vector<Figure> across = shifted("y_half", {0.0, 0.5, 0.0});
  const std::vector<Figure> along_x = quick ? std::vector<Figure>{} : shifted("x_half", {0.5, 0.0, 0.0});
  const std::vector<Figure> upwards = quick ? std::vector<Figure>{} : shifted("z_half", {0.0, 0.0, 0.5});
  const auto rows = [&](const std::string& where, const Figure& force, double along, double sideways) {
    const int before = blocking_rows(n, 0.0, 0.0), after = blocking_rows(n, along, sideways);
    result.check_relative(
        Label::verification, fmt::format("force with {}, over that without a shift (dx = w/{})", where, n),
        force.value / at_base[force_x].value, static_cast<double>(after) / before, "", 1.0 / before,
        "the force is proportional to the number of node rows that stop the flow; the half cells beside the outermost rows "
        "are open, one cell in all");
  };
  rows("the grid shifted by half a cell across", across[force_x], 0.0, 0.5);
  if (!quick) rows("the grid shifted by half a cell along", along_x[force_x], 0.5, 0.0);

  std::vector<std::pair<double, std::vector<Figure>>> cfl, particles;
  for (const double value : context.choose(std::vector<double>{}, {0.8, 0.2}, {0.8, 0.2, 0.1}))
    cfl.emplace_back(value, variant(fmt::format("cfl{:g}", value), [&](Case& c) { c.numerics.cfl = value; }));
  for (const int value : context.choose(std::vector<int>{}, {1}, {1, 27, 64}))
    particles.emplace_back(value, variant(fmt::format("ppc{}", value), [&](Case& c) { c.numerics.particles_per_cell = value; }));

  // What was varied, by name. One particle a cell leaves holes: shown, not asserted.
  std::vector<std::pair<std::string, const std::vector<Figure>*>> varied{{"shift by half a cell across", &across}};
  if (!quick) varied.insert(varied.end(), {{"shift by half a cell along the flow", &along_x}, {"shift by half a cell upwards", &upwards}});
  for (const auto& [value, figures] : cfl) varied.emplace_back(fmt::format("CFL {:g} in place of 0.4", value), &figures);
  for (const auto& [value, figures] : particles) varied.emplace_back(fmt::format("{:g} particles a cell in place of 8", value), &figures);
  const std::vector<FigureStudy>& study = quick ? odd : even;
  for (const FigureIndex i : asserted) {
    for (const auto& [name, figures] : varied) {
      if (name.starts_with("1 particles")) continue;
      check_covered(result, fmt::format("{}: {}, dx = w/{}", studied[i].quantity, name, n), at_base[i], (*figures)[i],
                    uncertainty_at(study[i], dx), studied[i].unit);
    }
  }

  // The figures over what was varied, relative to the base.
  const auto relative = [&](FigureIndex i, const std::vector<Figure>& figures) { return figures[i].value / at_base[i].value; };
  for (const auto& [id, title, label, points] :
       {std::tuple{"cfl", "Time step", "CFL number", &cfl}, std::tuple{"ppc", "Particles per cell", "particles per cell", &particles}}) {
    if (points->empty()) continue;
    Plot plot{id, fmt::format("{} at dx = w/{}", title, n), label, "figure over the one at the default", {}, "", true, false};
    for (const FigureIndex i : asserted) {
      std::vector<std::pair<double, double>> points_of{{std::string(id) == "cfl" ? 0.4 : 8.0, 1.0}};
      for (const auto& [value, figures] : *points) points_of.emplace_back(value, relative(i, figures));
      std::ranges::sort(points_of);
      Series series{studied[i].quantity, {}, {}, Series::Style::points};
      for (const auto& [x, y] : points_of) {
        series.x.push_back(x);
        series.y.push_back(y);
      }
      plot.series.push_back(series);
    }
    result.plots.push_back(plot);
  }

  const auto told = [&](FigureIndex i, const std::vector<Figure>& figures) {
    return std::isfinite(figures[i].value) ? fmt::format("{:.3f}", relative(i, figures)) : std::string("no steady span");
  };
  std::string text = fmt::format("Everything else varied at dx = w/{}, force, run-up, pressure height over those of the base:", n);
  for (const auto& [name, figures] : varied)
    text += fmt::format(" {} {}, {}, {};", name, told(force_x, *figures), told(runup, *figures), told(pressure_height, *figures));
  text.back() = '.';
  result.notes.push_back(text);
  if (!runs.unsteady().empty()) result.notes.push_back(fmt::format("Runs without a steady span: {}.", fmt::join(runs.unsteady(), ", ")));
  result.notes.push_back(fmt::format("Grids {}{}{}; {:.0f} million particle-steps in all.", list(odd_grids), quick ? "" : " and ",
                                     list(even_grids), 1e-6 * static_cast<double>(runs.particle_steps())));
}

const Registration registered{{MPM_CASE_NAME, "Grid convergence of an avalanche on a mast", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
