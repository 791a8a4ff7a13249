#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/point_comparison.hpp"
#include "validation/harness/random_trials.hpp"

namespace mpm::validation::stress_paths {
namespace {

using Segment = ReferenceSegment;

// -- materials ------------------------------------------------------------------------------------------------------------------

struct Plasticity {
  double slope, beta, xi;
  [[nodiscard]] std::string name() const { return fmt::format("M {}, β {}, ξ {}", slope, beta, xi); }
};

/// Table 1 of the paper, and dry loose (M 0.5) and dense snow (M 0.9) of Sect. 4.3, whose compressibilities chi(25 kPa) of 107.5 and
/// 102.4 % are xi = 0.5 and 1.5 in Table 1.
std::vector<Plasticity> paper_materials() {
  std::vector<Plasticity> all;
  for (const double slope : {0.0, 0.4, 0.8, 1.2})
    for (const double beta : {0.0, 0.15, 0.3, 0.45})
      for (const double xi : {0.05, 0.15, 0.5, 1.5, 5.0, 15.0}) all.push_back({slope, beta, xi});
  all.push_back({0.5, 0.15, 0.5});
  all.push_back({0.9, 0.3, 1.5});
  return all;
}

/// A quarter of the grid in which every M meets every beta and every xi several times, and the two of Sect. 4.3.
std::vector<Plasticity> representative_materials() {
  const std::vector<Plasticity> all = paper_materials();
  std::vector<Plasticity> some;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t slope = i / 24, beta = i / 6 % 4, xi = i % 6;
    if (i >= 96 || (slope + beta + xi) % 4 == 0) some.push_back(all[i]);
  }
  return some;
}

// -- paths ----------------------------------------------------------------------------------------------------------------------

enum class Family { isotropic, triaxial, shear, turning };

struct Path {
  std::string name;
  Family family;
  std::function<std::vector<Segment>(const CamClay&)> segments;
  [[nodiscard]] bool general() const { return family == Family::turning; }
  [[nodiscard]] bool exact() const { return family == Family::isotropic; }
};

Segment shear(int i, int j, double gamma) {
  Mat3 l = Mat3::Zero();
  l(i, j) = gamma;
  return Segment::general(l);
}

/// @param reloading  the segments of case.toml
std::vector<Path> all_paths(const std::vector<Segment>& reloading) {
  const auto strain = [](double v, double q) { return Segment::strain_increment(v, q); };
  const auto fixed = [](std::vector<Segment> s) { return [s = std::move(s)](const CamClay&) { return s; }; };
  constexpr double compaction = 0.04;  // beyond the onset of yield at p_c0/K = 0.024
  const Segment compact = strain(-compaction, 0.0);
  const auto drained = [compact](double axial) {
    return [=](const CamClay& m) {
      return std::vector{compact, Segment::drained(m.preconsolidation(exact::isotropic_compression(m, compaction)), axial)};
    };
  };
  Mat3 spin;
  spin << -0.05, 0.2, 0.0, -0.1, 0.0, 0.05, 0.0, 0.1, -0.02;
  return {
      {"isotropic compression", Family::isotropic, fixed({strain(-0.1, 0.0)})},
      {"hydrostatic tension", Family::isotropic, fixed({strain(0.03, 0.0)})},
      {"compression, tension, compression", Family::isotropic, fixed({strain(-0.05, 0.0), strain(0.06, 0.0), strain(-0.1, 0.0)})},
      {"oedometric compression", Family::triaxial, fixed({strain(-0.1, 0.2 / 3.0)})},
      {"drained triaxial compression", Family::triaxial, drained(-0.15)},
      {"drained triaxial extension", Family::triaxial, drained(0.05)},
      {"undrained triaxial compression", Family::triaxial, fixed({compact, strain(0.0, 0.12)})},
      {"undrained triaxial extension", Family::triaxial, fixed({compact, strain(0.0, -0.12)})},
      {"isochoric shear", Family::shear, fixed({strain(0.0, 0.1)})},
      {"shear after compaction", Family::shear, fixed({strain(-0.08, 0.16 / 3.0), strain(0.0, -0.1)})},
      {"load, unload, reload", Family::shear, fixed(reloading)},
      {"dilation to softening", Family::shear, fixed({strain(-0.01, 0.0), strain(0.004, 0.04)})},
      {"tension with shear", Family::shear, fixed({strain(0.03, 0.01)})},
      {"simple shear", Family::turning, fixed({compact, shear(0, 2, 0.3)})},
      {"shear with spin", Family::turning, fixed({compact, Segment::general(spin)})},
      {"rotating shear", Family::turning, fixed({compact, shear(0, 2, 0.1), shear(1, 2, 0.1), shear(0, 2, -0.1), shear(1, 2, -0.1)})},
  };
}

// -- comparison -----------------------------------------------------------------------------------------------------------------

/// One path of one material with M > 0.
struct Outcome {
  const Path* path = nullptr;
  Plasticity material{};
  PathComparison comparison;  ///< without its points, except of the material that is drawn
  double closed_form = 0.0;   ///< error against it; exact paths
  FormDifference ida;
  [[nodiscard]] double finest_error() const { return comparison.error.back(); }
  [[nodiscard]] std::string name() const { return fmt::format("{} with {}", path->name, material.name()); }
};

/// Least D/(K y_p^2 + 3 G y_q^2) at which IDA is asked: closer to a fold its iteration stalls on the round-off of y.
constexpr double well_conditioned = 0.1;

constexpr Plasticity drawn{0.8, 0.3, 5.0};

Outcome follow(const Path& path, const Plasticity& material, const mpm::CamClay::Parameters& base) {
  Outcome o{&path, material, {}, 0.0, {}};
  const mpm::CamClay::Parameters spec = with_plasticity(base, material.slope, material.beta, material.xi);
  const CamClay model = reference_model(spec);
  const std::vector<Segment> segments = path.segments(model);
  ComparisonOptions options;
  options.general = path.general();
  if (path.exact()) options.finest = 2560;
  o.comparison = compare_path(spec, segments, options);
  if (path.exact()) o.closed_form = isotropic_error(spec, segments, {1, 7, 160, 2560});
  if (!path.general() && !o.comparison.jumps && o.comparison.reference.margin >= well_conditioned)
    o.ida = compare_forms(model, segments, o.comparison.reference);
  const bool is_drawn = material.slope == drawn.slope && material.beta == drawn.beta && material.xi == drawn.xi;
  if (!is_drawn) {
    o.comparison.reference.points = std::vector<ReferencePoint>{};  // gives the memory back
    o.comparison.finest = std::vector<PathRow>{};
  }
  return o;
}

// -- checks ---------------------------------------------------------------------------------------------------------------------

constexpr double order_low = 0.9, order_high = 1.2;

void check_paths(CaseResult& result, const std::vector<Path>& paths, const std::vector<Outcome>& outcomes) {
  Extreme behind_jump;
  int jumps = 0, lost = 0;
  for (const Path& path : paths) {
    Extreme lowest, highest, error, closed_form;
    int steps = 0;
    for (const Outcome& o : outcomes) {
      if (o.path != &path) continue;
      const PathComparison& c = o.comparison;
      error.add(*std::max_element(c.error.begin(), c.error.end()), o.material.name());
      closed_form.add(o.closed_form, o.material.name());
      if (path.exact()) continue;
      if (c.jumps) {
        ++jumps;
        if (c.exact())
          ++lost;  // stress-free from the jump on, on both sides
        else
          behind_jump.add(c.error.back() / c.error[c.error.size() - 3], o.name());
        continue;
      }
      lowest.add(-c.tail_order(), o.material.name());
      highest.add(c.tail_order(), o.material.name());
      steps = std::max(steps, c.steps.back());
    }
    if (path.exact()) {
      result.check_at_most(Label::verification,
                           fmt::format("{}: largest error against CVODE, {} materials, 160 to 2560 steps", path.name, error.count),
                           error.value, 0.0, "", 1e-12,
                           fmt::format("the map has no step error where q = 0: round-off of 2560 steps; largest at {}", error.name));
      result.check_at_most(Label::verification, fmt::format("{}: largest error against the closed form, 1 to 2560 steps", path.name),
                           closed_form.value, 0.0, "", 1e-12,
                           fmt::format("exact for any step, also across snap-back; largest at {}", closed_form.name));
      continue;
    }
    result.check_order(Label::verification, fmt::format("{}: lowest order in the tail, {} materials", path.name, lowest.count),
                       -lowest.value, order_low, order_high, fmt::format("backward Euler is of first order; lowest at {}", lowest.name));
    result.check_order(Label::verification, fmt::format("{}: highest order in the tail", path.name), highest.value, order_low, order_high,
                       fmt::format("backward Euler is of first order; highest at {}", highest.name));
    Extreme finest;
    for (const Outcome& o : outcomes)
      if (o.path == &path && !o.comparison.jumps) finest.add(o.finest_error(), o.material.name());
    result.notes.push_back(fmt::format("{}: error at the finest step at most {:.1e} of the largest p_c ({}); up to {} steps a segment.",
                                       path.name, finest.value, finest.name, steps));
  }
  result.check_at_most(
      Label::verification,
      fmt::format("{} pairs that snap back with q > 0: largest error at the finest step over that at four times the step",
                  behind_jump.count),
      behind_jump.value, 0.5, "", 0.0,
      fmt::format(
          "the instant of the jump moves by whole steps and the approach to a fold is a square root: at least order 1/2; slowest: {}",
          behind_jump.name));
  result.notes.push_back(
      fmt::format("{} pairs of path and material snap back with shear stress; {} of them lose all stress at the onset of yield, where map "
                  "and reference agree to round-off.",
                  jumps, lost));

  Extreme drift, ida;
  int points = 0;
  for (const Outcome& o : outcomes) {
    drift.add(o.comparison.reference.drift, o.name());
    ida.add(o.ida.largest, o.name());
    points += o.ida.points;
  }
  result.check_at_most(Label::verification, fmt::format("drift |y|/max(p_c, 1e-3 p_c0)² of the reference, {} paths", drift.count),
                       drift.value, 0.0, "", 1e-9, fmt::format("consistency integrated at 1e-13; largest: {}", drift.name));
  result.check_at_most(Label::verification,
                       fmt::format("CVODE rate form against IDA index-1 form, {} points, over the largest p_c", points), ida.value, 0.0, "",
                       1e-8, fmt::format("two formulations, integrators and tolerances, 1e-13 and 1e-12; largest: {}", ida.name));
}

/// M = 0: q = 0 and the pressure of the closed form on every path, whatever the shear.
void check_without_friction(CaseResult& result, const std::vector<Path>& paths, const mpm::CamClay::Parameters& base) {
  Extreme strain, drained;
  for (const Path& path : paths)
    for (const Plasticity& material : paper_materials()) {
      if (material.slope != 0.0) continue;
      const mpm::CamClay::Parameters spec = with_plasticity(base, 0.0, material.beta, material.xi);
      const std::vector<Segment> segments = path.segments(reference_model(spec));
      const bool stress_controlled = segments.back().control == Segment::Control::drained_triaxial;
      (stress_controlled ? drained : strain)
          .add(isotropic_error(spec, segments, {1, 7, 160}), fmt::format("{} with {}", path.name, material.name()));
    }
  result.check_at_most(Label::verification,
                       fmt::format("M = 0: p, q and p_c against the closed form, {} strain-controlled paths", strain.count), strain.value,
                       0.0, "", 1e-12, fmt::format("q = 0 and isotropic hardening, exact for any step; largest: {}", strain.name));
  result.check_at_most(Label::verification, fmt::format("M = 0: the same, {} stress-controlled paths", drained.count), drained.value, 0.0,
                       "", 1e-10, fmt::format("160 steps, each holding the radial stress to 1e-13; largest: {}", drained.name));
}

/// beta = 0: no tension anywhere, and none of the shear strength at p = 0.
void check_without_cohesion(CaseResult& result, const std::vector<Path>& paths, const mpm::CamClay::Parameters& base) {
  Extreme tension, pulled;
  for (const Plasticity& material : paper_materials()) {
    if (material.beta != 0.0 || material.slope == 0.0) continue;
    const mpm::CamClay::Parameters spec = with_plasticity(base, material.slope, 0.0, material.xi);
    const CamClay model = reference_model(spec);
    for (const Path& path : paths) {
      if (path.exact()) continue;
      for (const PathRow& row : follow_path(library_path(spec, path.segments(model), 160)))
        tension.add(-row.p / spec.preconsolidation_pressure, fmt::format("{} with {}", path.name, material.name()));
    }
    for (const PathRow& row : follow_path(library_path(spec, {Segment::strain_increment(0.03, 0.01)}, 160))) {
      // tension from rest: all strain is plastic, nothing is carried
      const double off = std::abs(row.eps_v_plastic - (row.eps_v - model.initial_internal()));
      const bool carries = row.p > 0.0;  // the shear dilates: see 'isochoric shear'
      if (!carries) pulled.add(std::max({std::abs(row.p), row.q}) / spec.preconsolidation_pressure + off, material.name());
    }
  }
  result.check_at_most(Label::verification, "β = 0: largest tension on any path, over p_c0", tension.value, 0.0, "", 1e-12,
                       fmt::format("the apex is at p = 0; round-off; largest: {}", tension.name));
  result.check_at_most(Label::verification,
                       fmt::format("β = 0, pulled from rest: |p| + q over p_c0 and |X - e - X_0|, {} states", pulled.count), pulled.value,
                       0.0, "", 1e-12, "no stress, all strain plastic");
}

/// Where a trial state beyond a tension apex lands, with shear: the map against a scan of backward Euler's residual.
void check_landing(CaseResult& result, const mpm::CamClay::Parameters& base, int per_axis) {
  Extreme difference;
  int snapped = 0, total = 0;
  for (const Plasticity& material : paper_materials()) {
    if (material.slope == 0.0 || material.beta == 0.0) continue;
    const mpm::CamClay::Parameters spec = with_plasticity(base, material.slope, material.beta, material.xi);
    const CamClay model = reference_model(spec);
    const mpm::CamClay law(spec);
    for (const double growth : {0.5, 1.0, 3.0})  // p_c over p_c0
      for (int i = 0; i < per_axis; ++i)
        for (int j = 0; j < per_axis; ++j) {
          const double pc = growth * spec.preconsolidation_pressure, internal = std::asinh(pc / model.bulk_modulus) / material.xi;
          const double p = -material.beta * pc * (0.1 + 1.3 * (i + 0.5) / per_axis), q = pc * (j + 0.5) / per_axis;
          if (!(model.yield(p, q, internal) > 0.0)) continue;
          const Landing to = nearest_landing(model, p, q, internal);
          MaterialState<double> s{{-p, -p, -p, q / std::sqrt(3.0), 0.0, 0.0}, internal};
          law.update_stress(s, Matrix3<double>{}, 1.0);
          const double p_map = -trace(s.stress) / 3.0, q_map = std::sqrt(1.5 * norm2(deviator(s.stress)));
          ++total;
          if (to.internal <= 0.0 && internal + p / model.bulk_modulus < 0.0) ++snapped;
          difference.add(
              std::max({std::abs(s.internal - to.internal) / internal, std::abs(p_map - to.p) / pc, std::abs(q_map - to.q) / pc}),
              fmt::format("{}, p_c {} Pa, p {:.6g}, q {:.6g}: X {:.9g} against {:.9g}", material.name(), pc, p, q, s.internal,
                          to.internal));
        }
  }
  result.check_at_most(
      Label::verification,
      fmt::format("landing of {} trial states in tension with shear, of which {} lose all stress: X, p, q against a scan", total, snapped),
      difference.value, 0.0, "", 1e-10,
      fmt::format("the nearest root below X_n, both to round-off of the residual; largest: {}", difference.name));
}

void check_random_trials(CaseResult& result, std::int64_t states) {
  const TrialReport r = try_random_states(states);
  const auto most = [&](const std::string& quantity, const WorstOf& w, const std::string& reason) {
    result.check_at_most(Label::verification, fmt::format("{} random trial states: {}", r.states, quantity), w.value, 1.0, "", 0.0,
                         reason + (w.where.empty() ? "" : "; largest at " + w.where));
  };
  result.check_at_most(Label::verification,
                       fmt::format("{} random trial states, double, 8 and 16 lanes: results that are not finite", r.states),
                       static_cast<double>(r.not_finite), 0.0, "", 0.0, "the map must return for every trial state");
  most("y beyond the surface, over round-off", r.outside, "trial stress to 3e-14 K times the slope of y");
  most("|y| of yielded states, over round-off", r.off_surface, "the same bound");
  most("negative plastic work, over round-off", r.negative_work,
       "p dX + q dε_q^P >= 0 for an associative law whose surface holds the origin");
  most("lanes against double, over 1e-11", r.lanes_difference,
       "1e-11 of max(|X|, 1e-3) and max(p_c, 1e-3 K): the same root, each converged to 1e-14");
  result.notes.push_back(
      fmt::format("Random trial states: {} compact, {} dilate, {} end expanded and stress-free, the rest stays elastic. M 0 and 1e-3 to 3, "
                  "β 0 and 1e-3 to 0.9, ξ 0.02 to 50, p_c0 1 Pa to 1 MPa, E 0.1 to 100 MPa, ν 0 to 0.45, increments 1e-9 to 0.5.",
                  r.compacting, r.dilating, r.stress_free));
}

// -- plots and table ------------------------------------------------------------------------------------------------------------

std::string family_name(Family f) {
  switch (f) {
    case Family::isotropic: return "isotropic";
    case Family::triaxial: return "compression and extension";
    case Family::shear: return "shear, cycle and tension";
    case Family::turning: return "turning principal axes";
  }
  return "";
}

/// p-q and p_c of the drawn material, reference and return map.
void draw_paths(CaseResult& result, const std::vector<Outcome>& outcomes) {
  const std::string caption = fmt::format("{}. Black: CVODE; markers: return map at the finest step, every tenth sample.", drawn.name());
  for (const Family family : {Family::isotropic, Family::triaxial, Family::shear, Family::turning}) {
    Plot stress{
        fmt::format("stress-{}", static_cast<int>(family)), "Stress paths: " + family_name(family), "p [kPa]", "q [kPa]", {}, caption};
    Plot strength{fmt::format("strength-{}", static_cast<int>(family)),
                  "Pre-consolidation pressure: " + family_name(family),
                  "segments passed [-]",
                  "p_c [kPa]",
                  {},
                  caption};
    for (const Outcome& o : outcomes) {
      if (o.path->family != family || o.comparison.finest.empty()) continue;
      const auto& points = o.comparison.reference.points;
      Series line{"", {}, {}, Series::Style::reference}, marks{o.path->name, {}, {}, Series::Style::points};
      Series pc_line = line, pc_marks = marks;
      for (std::size_t i = 0; i < points.size(); i += 4) {
        line.x.push_back(points[i].p * 1e-3), line.y.push_back(points[i].q * 1e-3);
        pc_line.x.push_back(points[i].time), pc_line.y.push_back(points[i].preconsolidation * 1e-3);
      }
      for (std::size_t i = 0; i < points.size(); i += 32) {
        const PathRow& row = o.comparison.finest[i];
        marks.x.push_back(row.p * 1e-3), marks.y.push_back(row.q * 1e-3);
        pc_marks.x.push_back(points[i].time), pc_marks.y.push_back(row.preconsolidation_pressure * 1e-3);
      }
      if (!o.path->exact()) {
        stress.series.push_back(std::move(line));
        stress.series.push_back(std::move(marks));
      }
      strength.series.push_back(std::move(pc_line));
      strength.series.push_back(std::move(pc_marks));
    }
    for (Plot* plot : {&stress, &strength}) {
      if (plot->series.empty()) continue;
      plot->series.front().name = "CVODE";
      result.plots.push_back(std::move(*plot));
    }
  }
}

/// Error over step of the drawn material; error and order of every pair over the number of the material.
void draw_errors(CaseResult& result, const std::vector<Outcome>& outcomes, const std::vector<Plasticity>& materials) {
  const std::string numbered = "Materials are numbered as in the table: M, then β, then ξ rising, last the two of Sect. 4.3.";
  for (const Family family : {Family::triaxial, Family::shear, Family::turning}) {
    const auto id = [&](const char* what) { return fmt::format("{}-{}", what, static_cast<int>(family)); };
    Plot convergence{id("convergence"),
                     "Error of the return map: " + family_name(family),
                     "step, 1/steps per segment [-]",
                     "error over the largest p_c [-]",
                     {},
                     drawn.name() + ". Maximum norm along the path.",
                     true,
                     true};
    Plot order{id("order"), "Order in the tail: " + family_name(family), "number of the material [-]", "order [-]"};
    order.caption = numbered + " Pairs that snap back are left out.";
    Plot error{id("error"),
               "Error at the finest step: " + family_name(family),
               "number of the material [-]",
               "error over the largest p_c [-]",
               {},
               numbered,
               false,
               true};
    const auto last = static_cast<double>(materials.size());
    order.series.push_back(
        {"band", {1.0, last, last, 1.0, 1.0}, {order_low, order_low, order_high, order_high, order_low}, Series::Style::bound});
    double at = 0.0;
    for (const Outcome& o : outcomes) {
      if (o.path->family != family) continue;
      const PathComparison& c = o.comparison;
      if (order.series.back().name != o.path->name) {
        order.series.push_back({o.path->name, {}, {}, Series::Style::points});
        error.series.push_back({o.path->name, {}, {}, Series::Style::points});
        at = 0.0;
      }
      at += 1.0;
      if (!c.jumps) order.series.back().x.push_back(at), order.series.back().y.push_back(c.tail_order());
      if (!c.exact()) error.series.back().x.push_back(at), error.series.back().y.push_back(c.error.back());
      if (c.finest.empty() || c.exact()) continue;
      Series s{o.path->name + (c.jumps ? " (snaps back)" : ""), {}, c.error, Series::Style::points};
      for (const int n : c.steps) s.x.push_back(1.0 / n);
      convergence.series.push_back(std::move(s));
    }
    if (!convergence.series.empty()) {
      const Series& first = convergence.series.front();
      Series slope{"order 1", {first.x.front(), first.x.back()}, {}, Series::Style::bound};
      for (const double h : slope.x) slope.y.push_back(2.0 * first.y.back() * h / first.x.back());
      convergence.series.insert(convergence.series.begin(), slope);
      result.plots.push_back(std::move(convergence));
    }
    result.plots.push_back(std::move(order));
    result.plots.push_back(std::move(error));
  }
}

/// Every pair in one file.
void write_table_of_orders(const std::filesystem::path& file, const std::vector<Outcome>& outcomes) {
  std::string csv = "path,M,beta,xi,kind,steps_finest,error_finest,order,mean_order,margin,drift,ida_difference,closed_form_error,events\n";
  for (const Outcome& o : outcomes) {
    const PathComparison& c = o.comparison;
    std::vector<std::string> events;
    for (const EventRecord& e : c.reference.events) events.push_back(to_string(e.event));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    csv += fmt::format("\"{}\",{},{},{},{},{},{:.3e},{:.3f},{:.3f},{:.3g},{:.1e},{:.1e},{:.1e},\"{}\"\n", o.path->name, o.material.slope,
                       o.material.beta, o.material.xi,
                       o.path->exact() ? "exact"
                       : c.jumps       ? "jump"
                                       : "tail",
                       c.steps.back(), c.error.back(), c.tail_order(), c.mean_order(), c.reference.margin, c.reference.drift,
                       o.ida.points > 0 ? o.ida.largest : nan, o.path->exact() ? o.closed_form : nan, fmt::join(events, "; "));
  }
  write_file(file, csv);
}

void run(const CaseContext& context, CaseResult& result) {
  const PathSpec file = read_path(context.case_directory() / "case.toml");
  const std::vector<Path> paths = all_paths(reference_segments(file));
  std::vector<Plasticity> materials = context.choose(representative_materials(), paper_materials(), paper_materials());
  std::erase_if(materials, [](const Plasticity& m) { return m.slope == 0.0; });  // no rate form: check_without_friction
  context.log(fmt::format("{} paths of {} materials", paths.size(), materials.size()));
  std::vector<Outcome> outcomes(paths.size() * materials.size());
  in_parallel(outcomes.size(), [&](std::size_t i) {
    const Path& path = paths[i / materials.size()];
    const Plasticity& material = materials[i % materials.size()];
    try {
      outcomes[i] = follow(path, material, file.material.as<mpm::CamClay>());
    } catch (const Error& e) {
      throw UnstableError(fmt::format("{} with {}: {}", path.name, material.name(), e.what()));
    }
  });

  check_paths(result, paths, outcomes);
  check_without_friction(result, paths, file.material.as<mpm::CamClay>());
  check_without_cohesion(result, paths, file.material.as<mpm::CamClay>());
  check_landing(result, file.material.as<mpm::CamClay>(), context.choose(6, 16, 40));
  context.log("random trial states");
  check_random_trials(result, context.choose(400'000, 5'000'000, 50'000'000));

  draw_errors(result, outcomes, materials);
  draw_paths(result, outcomes);
  write_table_of_orders(context.directory() / "orders.csv", outcomes);
  result.notes.push_back(fmt::format("Every error and order: cases/{}/orders.csv beside this report.", result.name));
}

const Registration registered{{.title = "Stress paths against SUNDIALS", .run = run}};

}  // namespace
}  // namespace mpm::validation::stress_paths
