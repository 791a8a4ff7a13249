#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/run.hpp"
#include "libmpm/observe/pressure_profile.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/flow.hpp"
#include "validation/harness/grid_convergence.hpp"

namespace mpm::validation {
namespace {

/// The figures of one run, in the order of `studied`.
enum FigureIndex : std::size_t { force_x, runup, pressure_height, pressure_height_in_cells, impact_pressure };
/// Order 2 in the interior, 1 at walls: what lies between 0.5 and 2 counts as credible (the window of Eca & Hoekstra, too).
constexpr double formal_order = 1.5;
const std::vector<FollowedQuantity> studied{{"force on the mast", "N", formal_order},
                                            {"run-up", "m", formal_order},
                                            {"pressure height", "m", formal_order},
                                            {"pressure height, the paper's windows in cells", "m", formal_order},
                                            {"pressure before the face", "Pa", formal_order}};
const std::vector<FigureIndex> asserted{force_x, runup, pressure_height};

/// Two standard errors of a difference.
double noise(const Metric& a, const Metric& b) { return 2.0 * std::hypot(a.standard_error, b.standard_error); }

/// The pressure height in the paper's windows, which follow the cells, beside that in windows of fixed size.
class HeightInCells : public Observer {
 public:
  explicit HeightInCells(const ImpactGeometry& in_cells) : profile_(in_cells) {}
  [[nodiscard]] std::string name() const override { return "height_in_cells"; }
  [[nodiscard]] std::vector<Column> columns() const override {
    return {{.quantity = "height_in_cells", .unit = "m", .meaning = "pressure height in the paper's windows", .mean = true}};
  }
  [[nodiscard]] bool visits(const Vec3& low, const Vec3& high) const override { return profile_.visits(low, high); }
  void visit(const ParticleBatch& batch) override { profile_.visit(batch); }
  void sample(const Instant&, std::span<double> row) override { row[0] = profile_.finish().pressure_height.value_or(MeanEstimate::none); }

 private:
  PressureProfile profile_;
};

/// Draws the last state of a run.
class EndPicture : public Observer {
 public:
  EndPicture(const CaseContext& context, CaseResult& result, std::string run, double end, double slice)
      : context_(context), result_(result), run_(std::move(run)), end_(end), slice_(slice) {}
  [[nodiscard]] std::string name() const override { return "end_picture"; }
  [[nodiscard]] Source source() const override { return Source::run; }
  std::vector<std::string> check(const Instant& now) override {
    if (now.time < end_) return {};
    result_.flows.push_back(flow_picture(context_.directory(), now.live->state, now.live->scene,
                                         {.id = "end",
                                          .field = FlowField::stress_xx,
                                          .title = fmt::format("The jet at the mast, {}, t = {:g} s", run_, now.time),
                                          .caption = "Particles near the mast's axis at the end of one of the runs.",
                                          .slice_half_width = slice_}));
    return {};
  }

 private:
  const CaseContext& context_;
  CaseResult& result_;
  std::string run_;
  double end_, slice_;  // s, m
};

/// Runs the case of this folder and its variants, each once.
class Runs {
 public:
  Runs(const CaseContext& context, CaseResult& result) : context_(context), result_(result), base_(context.read_case()) {
    base_.output.duration = context.choose(4.8, base_.output.duration, 8.0);
    base_.output.frames_per_second = 0.0;
  }

  [[nodiscard]] double width() const { return base_.obstacle->width(); }
  [[nodiscard]] std::uint64_t particle_steps() const { return particle_steps_; }
  [[nodiscard]] const std::vector<std::string>& unsteady() const { return unsteady_; }

  /// At w/n.
  [[nodiscard]] Case at(int cells_per_width) const {
    Case c = base_;
    c.numerics.cell_size = width() / cells_per_width;
    return c;
  }

  /// @param picture whether the end of this run is shown
  std::vector<Metric> operator()(const std::string& name, const Case& c, bool picture = false) {
    if (const auto done = done_.find(case_hash(c)); done != done_.end()) return done->second;
    const auto in_cells = std::make_shared<HeightInCells>(
        paper_geometry(c.conveyor->flow_height, c.obstacle->width(), c.numerics.cell_size, c.material.density(), c.conveyor->mirror_y));
    RunOptions options;
    options.out = context_.directory() / name;
    options.observers.push_back(in_cells);
    if (picture) {
      options.observers.push_back(std::make_shared<EndPicture>(context_, result_, name, c.output.duration, 0.5 * c.numerics.cell_size));
    }
    const RunResult run = run_case(c, options);
    if (!run.results.has("steady")) throw UnstableError("the run left no results of the impact");
    const bool steady = run.results.number("steady") != 0.0;
    particle_steps_ += run.particle_steps;
    context_.log(fmt::format("{}: {} particles, {} steps, {:.1f} million particle-steps, {:.0f} s; {}", name, run.particles, run.steps,
                             1e-6 * static_cast<double>(run.particle_steps), run.wall_time_s,
                             steady ? fmt::format("run-up {:.3f} m, force {:.1f} kN", run.results.number("runup_mean_m"),
                                                  1e-3 * run.results.number("force_mean_n"))
                                    : "no steady span"));
    if (!steady) unsteady_.push_back(name);
    const auto mean = [&](const char* quantity, const char* unit) {
      return Metric{run.results.number(fmt::format("{}_mean_{}", quantity, unit)),
                    run.results.number(fmt::format("{}_standard_error_{}", quantity, unit))};
    };
    return done_[case_hash(c)] = {mean("force", "n"), mean("runup", "m"), mean("pressure_height", "m"), mean("height_in_cells", "m"),
                                  mean("impact_pressure", "pa")};
  }

 private:
  const CaseContext& context_;
  CaseResult& result_;
  Case base_;
  std::map<std::uint64_t, std::vector<Metric>> done_;
  std::uint64_t particle_steps_ = 0;
  std::vector<std::string> unsteady_;
};

std::string list(const std::vector<int>& cells) {
  std::string text;
  for (const int n : cells) text += fmt::format("{}w/{}", text.empty() ? "" : ", ", n);
  return text;
}

/// Studies of all figures on the grids w/n.
std::vector<MetricConvergence> grid_family(CaseResult& result, Runs& runs, const std::string& id, const std::vector<int>& cells,
                                           int pictured) {
  std::vector<double> sizes;
  for (const int n : cells) sizes.push_back(runs.width() / n);
  std::vector<FollowedQuantity> figures = studied;
  for (FollowedQuantity& f : figures) f.quantity += ", " + id;
  auto studies = record_convergence(result, id, SweepKind::cell_size, sizes, figures, [&](double dx) {
    const int n = static_cast<int>(std::lround(runs.width() / dx));
    return runs(fmt::format("w{}", n), runs.at(n), n == pictured);
  });
  if (!studies[force_x].convergence) throw UnstableError(fmt::format("{}: fewer than three grids have a steady interval", id));
  return studies;
}

/// What all grids but the finest state about themselves has to cover what the finest then gives.
void check_prediction(CaseResult& result, const MetricConvergence& s, const std::string& unit) {
  const MetricConvergence before =
      judge_metric(s.name, s.kind, {s.parameter.begin(), s.parameter.end() - 1}, {s.metric.begin(), s.metric.end() - 1}, {}, formal_order);
  const Metric &last = s.metric.back(), &next = before.metric.back();
  result.check_at_most(
      Label::verification, fmt::format("{}: change from dx = {:.3f} to {:.3f} m", s.name, before.parameter.back(), s.parameter.back()),
      std::abs(last.value - next.value), before.uncertainty, unit, noise(last, next),
      "numerical uncertainty that the coarser grids state for themselves (GCI); the slack is twice the statistical error of the "
      "difference");
}

/// What coarser grids of a family give, over what its finest grid gives.
void check_coarser_grids(CaseResult& result, const Runs& runs, const std::vector<MetricConvergence>& family, const std::string& id) {
  const auto cells = [&](double dx) { return static_cast<int>(std::lround(runs.width() / dx)); };
  const std::vector<double>& sizes = family[force_x].parameter;
  for (std::size_t k = 0; k + 1 < sizes.size(); ++k) {
    if (cells(sizes[k]) < 5) continue;
    const auto check = [&](FigureIndex i, double tolerance, const std::string& reason) {
      const Metric &metric = family[i].metric[k], &finest = family[i].metric.back();
      result.check_relative(Label::verification,
                            fmt::format("{}, {}: w/{} over w/{}", id, studied[i].quantity, cells(sizes[k]), cells(sizes.back())),
                            metric.value / finest.value, 1.0, "", tolerance + noise(metric, finest) / std::abs(finest.value), reason);
    };
    check(force_x, 0.03, "aim from w/5 on: 3 %; and twice the statistical error of the difference");
    if (cells(sizes[k]) >= 7) check(runup, 0.04, "aim from w/7 on: 4 %; and twice the statistical error of the difference");
  }
}

void run(const CaseContext& context, CaseResult& result) {
  Runs runs(context, result);
  // Whole numbers of cells. Even: a row of nodes on each side of the mast; odd: none.
  using Family = std::vector<int>;
  const bool quick = context.level() == Level::quick;
  const Family even_grids = context.choose(Family{}, Family{4, 6, 8, 12}, Family{4, 6, 8, 12, 16});
  const Family odd_grids = context.choose(Family{3, 4, 5}, Family{3, 5, 7, 9}, Family{3, 5, 7, 9, 11});
  const int pictured = context.choose(5, 12, 16), n = context.choose(5, 6, 6);
  const std::string odd_id = quick ? "three grids" : "odd w/dx";
  const std::vector<MetricConvergence> odd = grid_family(result, runs, odd_id, odd_grids, pictured);
  const std::vector<MetricConvergence> even = quick ? odd : grid_family(result, runs, "even w/dx", even_grids, pictured);
  for (const auto* family : quick ? std::vector{&odd} : std::vector{&odd, &even}) {
    check_coarser_grids(result, runs, *family, family == &odd ? odd_id : "even w/dx");
    for (const FigureIndex i : asserted) {
      if (quick) break;  // three coarse grids state a large uncertainty
      const MetricConvergence& study = (*family)[i];
      const double cap = i == force_x ? 0.03 : 0.04;
      result.check_at_most(Label::verification, study.name + ": numerical uncertainty of the finest grid, relative",
                           study.uncertainty / std::abs(study.metric.back().value), cap, "", 0.0,
                           "aim: 3 % for the force, 4 % for heights");
    }
    for (const FigureIndex i : asserted) {
      if ((*family)[i].convergence->size.size() > 3) check_prediction(result, (*family)[i], studied[i].unit);
    }
  }
  for (const FigureIndex i : asserted) {
    if (quick) break;
    const Metric &a = even[i].metric.back(), &b = odd[i].metric.back();
    result.check_at_most(Label::verification, studied[i].quantity + ": finest even against finest odd grid", std::abs(a.value - b.value),
                         even[i].uncertainty + odd[i].uncertainty, studied[i].unit, noise(a, b),
                         "both families go to the same limit, so their intervals of numerical uncertainty overlap; the slack is twice the "
                         "statistical error of the difference");
  }
  result.check_absolute(Label::verification, "grids without a steady interval", static_cast<double>(runs.unsteady().size()), 0.0, "", 0.0,
                        "a mean needs a steady interval, and the runs are long enough for one");

  // One grid, everything else varied.
  const Case base = runs.at(n);
  const std::vector<Metric> at_base = runs(fmt::format("w{}", n), base);
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
  const std::vector<Metric> across = quick ? std::vector<Metric>{} : shifted("y_half", {0.0, 0.5, 0.0});
  const std::vector<Metric> along_x = quick ? std::vector<Metric>{} : shifted("x_half", {0.5, 0.0, 0.0});
  const std::vector<Metric> upwards = quick ? std::vector<Metric>{} : shifted("z_half", {0.0, 0.0, 0.5});
  std::vector<std::pair<double, std::vector<Metric>>> cfl, particles;
  for (const double value : context.choose<std::vector<double>>({0.8}, {0.8, 0.2}, {0.8, 0.2, 0.1}))
    cfl.emplace_back(value, variant(fmt::format("cfl{:g}", value), [&](Case& c) { c.numerics.cfl = value; }));
  for (const int value : context.choose(std::vector<int>{}, {1}, {1, 27, 64}))
    particles.emplace_back(value, variant(fmt::format("ppc{}", value), [&](Case& c) { c.numerics.particles_per_cell = value; }));

  // What was varied, by name. One particle a cell leaves holes: shown, not asserted.
  std::vector<std::pair<std::string, const std::vector<Metric>*>> varied;
  if (!quick)
    varied = {{"shift by half a cell across", &across},
              {"shift by half a cell along the flow", &along_x},
              {"shift by half a cell upwards", &upwards}};
  for (const auto& [value, figures] : cfl) varied.emplace_back(fmt::format("CFL {:g} in place of 0.4", value), &figures);
  for (const auto& [value, figures] : particles) varied.emplace_back(fmt::format("{:g} particles a cell in place of 8", value), &figures);
  for (const FigureIndex i : asserted) {
    for (const auto& [name, figures] : varied) {
      if (name.starts_with("1 particles")) continue;
      const double aim = i == force_x ? 0.03 : 0.04;
      result.check_relative(Label::verification, fmt::format("{}: {}, dx = w/{}", studied[i].quantity, name, n),
                            (*figures)[i].value / at_base[i].value, 1.0, "",
                            aim + noise(at_base[i], (*figures)[i]) / std::abs(at_base[i].value),
                            "no result depends on this by more than 3 % (force) or 4 % (heights); and twice the statistical error");
    }
  }
  // The figures over what was varied, relative to the base.
  const auto relative = [&](FigureIndex i, const std::vector<Metric>& figures) { return figures[i].value / at_base[i].value; };
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

  const auto told = [&](FigureIndex i, const std::vector<Metric>& figures) {
    return std::isfinite(figures[i].value) ? fmt::format("{:.3f}", relative(i, figures)) : std::string("no steady interval");
  };
  std::string text = fmt::format("Everything else varied at dx = w/{}, force, run-up, pressure height over those of the base:", n);
  for (const auto& [name, figures] : varied)
    text += fmt::format(" {} {}, {}, {};", name, told(force_x, *figures), told(runup, *figures), told(pressure_height, *figures));
  text.back() = '.';
  result.notes.push_back(text);
  if (!runs.unsteady().empty())
    result.notes.push_back(fmt::format("Runs without a steady interval: {}.", fmt::join(runs.unsteady(), ", ")));
  result.notes.push_back(fmt::format("Grids {}{}{}; {:.0f} million particle-steps in all.", list(odd_grids), quick ? "" : " and ",
                                     list(even_grids), 1e-6 * static_cast<double>(runs.particle_steps())));
}

const Registration registered{{MPM_CASE_NAME, "Grid convergence of an avalanche on a mast", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
