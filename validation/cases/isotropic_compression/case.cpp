#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/material/cam_clay.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/point_comparison.hpp"
#include "validation/harness/root.hpp"

namespace mpm::validation::isotropic_compression {
namespace {

using Segment = ReferenceSegment;

/// A material of the paper's grid (Table 1) or of Sect. 4.3.
struct Material {
  mpm::CamClay::Parameters spec;
  CamClay model;
  std::string name;
};

std::vector<Material> paper_materials(const mpm::CamClay::Parameters& base) {
  std::vector<Material> all;
  const auto add = [&](double slope, double beta, double xi) {
    const mpm::CamClay::Parameters spec = with_plasticity(base, slope, beta, xi);
    all.push_back({spec, reference_model(spec), fmt::format("M {}, β {}, ξ {}", slope, beta, xi)});
  };
  for (const double slope : {0.0, 0.4, 0.8, 1.2})
    for (const double beta : {0.0, 0.15, 0.3, 0.45})
      for (const double xi : {0.05, 0.15, 0.5, 1.5, 5.0, 15.0}) add(slope, beta, xi);
  add(0.5, 0.15, 0.5);
  add(0.9, 0.3, 1.5);
  return all;
}

/// Largest error of return map and reference over the materials, and whose it is.
struct Pair {
  Extreme map, reference;
};

void check(CaseResult& result, const std::string& what, const Pair& pair, double map_tolerance, const std::string& map_reason,
           const std::string& reference_reason) {
  result.check_at_most(Label::verification, fmt::format("{}: return map, {} materials", what, pair.map.count), pair.map.value, 0.0, "",
                       map_tolerance, fmt::format("{}; largest at {}", map_reason, pair.map.name));
  result.check_at_most(Label::verification, fmt::format("{}: CVODE reference, {} materials", what, pair.reference.count),
                       pair.reference.value, 0.0, "", 1e-10, fmt::format("{}; largest at {}", reference_reason, pair.reference.name));
}

/// Runs task(material, pair) for the materials that have it, M > 0, on all threads.
Pair over_materials(const std::vector<Material>& materials, const std::function<void(const Material&, Pair&)>& task) {
  std::vector<Pair> parts(materials.size());
  in_parallel(materials.size(), [&](std::size_t i) {
    if (materials[i].spec.critical_state_slope > 0.0) task(materials[i], parts[i]);
  });
  Pair all;
  for (const Pair& p : parts) {
    const int map = all.map.count + p.map.count, reference = all.reference.count + p.reference.count;
    all.map.add(p.map.value, p.map.name);
    all.reference.add(p.reference.value, p.reference.name);
    all.map.count = map, all.reference.count = reference;
  }
  return all;
}

// -- isotropic compression ------------------------------------------------------------------------------------------------------

void isotropic_compression(CaseResult& result, const std::vector<Material>& materials, const PathSpec& file) {
  const std::vector<Segment> path = reference_segments(file);
  const double compression = -path[0].d_eps_v;
  Extreme map;
  for (const Material& m : materials) map.add(isotropic_error(m.spec, path, {1, 7, 40, 160}), m.name);
  result.check_at_most(
      Label::verification, fmt::format("isotropic compression: p, q, p_c over p_c, {} materials, 1 to 160 steps", map.count), map.value,
      0.0, "", 1e-12, fmt::format("no step error on this path: round-off of sinh and of 160 increments; largest at {}", map.name));
  // J, by which every Cauchy stress and density of a run is scaled, takes its plastic part from X.
  Extreme volume;
  for (const Material& m : materials) {
    const mpm::CamClay law(m.spec);
    for (const PathRow& r : follow_path(library_path(m.spec, path, 40)))
      volume.add(relative_error(law.volume_ratio(MaterialState<double>{r.stress, -r.eps_v_plastic}), std::exp(r.eps_v)), m.name);
  }
  result.check_at_most(Label::verification, fmt::format("isotropic compression: J against exp(ε_v), {} rows", volume.count), volume.value,
                       0.0, "", 1e-12, fmt::format("round-off of the strain's sum over 40 steps; largest at {}", volume.name));
  const Pair reference = over_materials(materials, [&](const Material& m, Pair& pair) {
    const ReferencePoint end = coaxial_reference(m.model, path).points.back();
    const double x = exact::isotropic_compression(m.model, compression), pc = m.model.preconsolidation(x);
    pair.reference.add(std::max({relative_error(end.internal, x), relative_error(end.p, pc), end.q / pc}), m.name);
  });
  result.check_at_most(Label::verification, fmt::format("isotropic compression: CVODE reference, {} materials", reference.reference.count),
                       reference.reference.value, 0.0, "", 1e-10,
                       fmt::format("integrated at 1e-13; largest at {}", reference.reference.name));

  Plot curves{"isotropic", "Isotropic compression",
              "-ε_v [-]",  "p [kPa]",
              {},          "Black: closed form. Markers: return map, 40 steps. M 0.8, β 0.3.",
              false,       true};
  for (const double xi : {0.05, 0.5, 5.0, 15.0}) {
    const mpm::CamClay::Parameters spec = with_plasticity(file.material.as<mpm::CamClay>(), 0.8, 0.3, xi);
    const CamClay model = reference_model(spec);
    curves.series.push_back(reference_curve(xi == 0.05 ? "closed form" : "", compression / 200.0, compression, 199, [&model](double e) {
      return 1e-3 * model.bulk_modulus * (e + model.initial_internal() - exact::isotropic(model, e, model.initial_internal()));
    }));
    Series marks{fmt::format("ξ = {}", xi), {}, {}, Series::Style::points};
    for (const PathRow& r : follow_path(library_path(spec, path, file.steps_per_segment))) {
      if (r.step == 0) continue;  // stress-free: no place on a logarithmic axis
      marks.x.push_back(-r.eps_v);
      marks.y.push_back(r.p * 1e-3);
    }
    curves.series.push_back(std::move(marks));
  }
  result.plots.push_back(std::move(curves));
}

// -- critical states ------------------------------------------------------------------------------------------------------------

/// (1 - beta)/2 sinh(xi X) + X = e + X_0, p = (1 - beta) p_c/2, q = M' p.
double critical_state_error(const CamClay& m, double compression, double internal, double p, double q) {
  const double x = exact::isochoric_critical_state(m, compression), pc = m.preconsolidation(x), p_end = 0.5 * (1.0 - m.cohesion_beta) * pc;
  return std::max({relative_error(internal, x), relative_error(p, p_end), relative_error(q / p, exact::critical_ratio(m))});
}

void isochoric_critical_state(CaseResult& result, const std::vector<Material>& materials) {
  constexpr double compression = 0.04;
  const std::vector<Segment> path{Segment::strain_increment(-compression, 0.0), Segment::strain_increment(0.0, 6.0)};
  const Pair pair = over_materials(materials, [&](const Material& m, Pair& out) {
    const PathRow map = follow_path(library_path(m.spec, path, 640), 640).back();
    out.map.add(critical_state_error(m.model, compression, -map.eps_v_plastic, map.p, map.q), m.name);
    const ReferencePoint end = coaxial_reference(m.model, path, {1e-13, 4}).points.back();
    out.reference.add(critical_state_error(m.model, compression, end.internal, end.p, end.q), m.name);
  });
  check(result, "critical state of isochoric shear, ε_q = 6: X, p, q/p", pair, 1e-10,
        "reached exponentially; a fixed point of the map, whatever the step", "reached exponentially, integrated at 1e-13");
}

/// Rate at which a drained test approaches its critical state, per unit of eps_q: there p = p_i + q/3 (extension p_i - q/3), dX/d eps_q =
/// y_p/y_q, and y = 0 ties q to X; linearised about y_p = 0 this is M (1 - beta) (1 -+ M'/3) xi sqrt(K^2 + p_c^2) / (sqrt(1 + 2 beta) (1 +
/// beta) p_c).
double approach(const CamClay& m, double critical_pressure, bool extension) {
  const double pc = 2.0 * critical_pressure / (1.0 - m.cohesion_beta), third = exact::critical_ratio(m) / 3.0;
  return m.critical_state_slope * (1.0 - m.cohesion_beta) * (extension ? 1.0 + third : 1.0 - third) * m.hardening_xi *
         std::hypot(m.bulk_modulus, pc) / (std::sqrt(1.0 + 2.0 * m.cohesion_beta) * (1.0 + m.cohesion_beta) * pc);
}

void drained_critical_state(CaseResult& result, const std::vector<Material>& materials, bool extension) {
  constexpr double compression = 0.04;
  const Pair pair = over_materials(materials, [&](const Material& m, Pair& out) {
    const double confining = m.model.preconsolidation(exact::isotropic_compression(m.model, compression));
    const double p_end = exact::drained_critical_pressure(m.model, confining, extension), ratio = exact::critical_ratio(m.model);
    const double axial = 2.0 + 30.0 / approach(m.model, p_end, extension);  // exp(-30) = 1e-13; up to 3000 where snow is soft (xi = 0.05)
    const std::vector<Segment> path{Segment::strain_increment(-compression, 0.0), Segment::drained(confining, extension ? axial : -axial)};
    const int steps = std::max(1000, static_cast<int>(std::ceil(axial / 0.1)));
    const PathRow map = follow_path(library_path(m.spec, path, steps), steps).back();
    out.map.add(std::max(relative_error(map.p, p_end), relative_error(map.q / map.p, ratio)), m.name);
    const ReferencePoint end = coaxial_reference(m.model, path, {1e-13, 4}).points.back();
    out.reference.add(std::max(relative_error(end.p, p_end), relative_error(end.q / end.p, ratio)), m.name);
  });
  check(result, fmt::format("critical state of drained triaxial {}: p, q/p", extension ? "extension" : "compression"), pair, 1e-10,
        "reached exponentially to 1e-13; the radial stress is held to 1e-13", "reached exponentially to 1e-13, integrated at 1e-13");
}

// -- yield at p = 0 -------------------------------------------------------------------------------------------------------------

void yield_without_pressure(CaseResult& result, const std::vector<Material>& materials) {
  const Pair pair = over_materials(materials, [&](const Material& m, Pair& out) {
    if (m.model.cohesion_beta == 0.0) return;  // q = 0: no elastic range to measure
    const double q = exact::yield_without_pressure(m.model, m.model.initial_internal()), strain = q / (3.0 * m.model.shear_modulus);
    // the largest q without a change of X
    const auto stays_elastic = [&](double trial) {
      const auto rows = follow_path(library_path(m.spec, {Segment::strain_increment(0.0, trial)}, 1));
      return rows.back().eps_v_plastic == rows.front().eps_v_plastic;
    };
    const double elastic = limit_of(stays_elastic, 0.5 * strain, 2.0 * strain).first;
    out.map.add(relative_error(3.0 * m.model.shear_modulus * elastic, q), m.name);
    const auto events = coaxial_reference(m.model, {Segment::strain_increment(0.0, 2.0 * strain)}, {1e-13, 4}).events;
    const double onset = events.empty() ? std::numeric_limits<double>::quiet_NaN() : events.front().time * 2.0 * strain;
    out.reference.add(relative_error(3.0 * m.model.shear_modulus * onset, q), m.name);
  });
  check(result, "yield at p = 0: q = M p_c √(β/(1+2β))", pair, 1e-10, "found by bisection; the law grants 1e-13 of p_c²",
        "root found by CVODE");
}

// -- Hencky simple shear --------------------------------------------------------------------------------------------------------

Mat3 to_mat3(const Sym3<double>& s) {
  Mat3 m;
  m << s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz;
  return m;
}

void hencky_simple_shear(const CaseContext& context, CaseResult& result, const mpm::CamClay::Parameters& base) {
  mpm::CamClay::Parameters strong = with_plasticity(base, 0.8, 0.3, 5.0);
  strong.preconsolidation_pressure = 1e9;  // so strong that it stays elastic
  const HenckyElastic::Parameters elastic{strong.moduli()};
  const CamClay model = reference_model(strong);
  const auto path = [](double gamma) {
    Mat3 l = Mat3::Zero();
    l(0, 1) = gamma;
    return std::vector{Segment::general(l)};
  };
  double map = 0.0, reference = 0.0;
  Plot curves{
      "simple-shear", "Hencky simple shear", "γ [-]", "stress [kPa]", {}, "Black: closed form. Markers: return map below yield, 40 steps."};
  for (const double gamma : {1e-3, 0.01, 0.1, 0.5, 1.0, 2.0, 4.0}) {
    const Mat3 tau = exact::hencky_simple_shear(model.shear_modulus, gamma);
    const double scale = tau.norm();
    for (const MaterialParameters& spec : {MaterialParameters(strong), MaterialParameters(elastic)})
      for (const int steps : {1, 7, 160})
        map = larger(map, (to_mat3(follow_path(library_path(spec, path(gamma), steps), steps).back().stress) - tau).norm() / scale);
    reference = larger(reference, (general_reference(model, path(gamma), {1e-13, 4}).points.back().stress - tau).norm() / scale);
  }
  result.check_at_most(Label::verification, "Hencky simple shear, γ = 0.001 to 4: all six components, 1 to 160 steps", map, 0.0, "", 1e-10,
                       "no step error (F is the product of the increments): round-off of b_e, largest where γ is small");
  result.check_at_most(Label::verification, "Hencky simple shear: CVODE reference in b_e", reference, 0.0, "", 1e-10,
                       "integrated at 1e-13");

  const Table table = Table::read(context.case_directory() / "../../../reference_data/hencky_simple_shear/data.csv");
  const auto gamma = table.numbers("gamma"), t12 = table.numbers("tau12"), t11 = table.numbers("tau11"), t22 = table.numbers("tau22");
  double printed = 0.0;
  for (std::size_t i = 0; i < gamma.size(); ++i) {
    const Mat3 tau = to_mat3(follow_path(library_path(elastic, path(gamma[i]), 1)).back().stress) * 1e-3;
    printed = std::max({printed, relative_error(tau(0, 1), t12[i]), relative_error(tau(0, 0), t11[i]), relative_error(tau(1, 1), t22[i])});
  }
  result.check_at_most(Label::verification, "Hencky simple shear against the printed table", printed, 0.0, "", 1e-10,
                       "twelve digits are printed");

  const auto exact_stress = [&](const char* name, int row, int column) {
    return reference_curve(name, 0.0, 4.0, 100,
                           [&](double g) { return 1e-3 * exact::hencky_simple_shear(model.shear_modulus, g)(row, column); });
  };
  Series t12_marks{"τ_12", {}, {}, Series::Style::points}, t11_marks{"τ_11 = -τ_22", {}, {}, Series::Style::points};
  for (const PathRow& row : follow_path(library_path(elastic, path(4.0), 40))) {
    t12_marks.x.push_back(0.1 * row.step), t11_marks.x.push_back(0.1 * row.step);
    t12_marks.y.push_back(row.stress.xy * 1e-3), t11_marks.y.push_back(row.stress.xx * 1e-3);
  }
  curves.series = {exact_stress("closed form", 0, 1), exact_stress("", 0, 0), t12_marks, t11_marks};
  result.plots.push_back(std::move(curves));
}

/// Eq. 2 and Eq. 3's points of the ellipse as printed, against the formulas that the checks above use.
void printed_ratios(const CaseContext& context, CaseResult& result, const mpm::CamClay::Parameters& base) {
  const Table table = Table::read(context.case_directory() / "../../../reference_data/paper_Mprime_grid/data.csv");
  const auto slope = table.numbers("M"), beta = table.numbers("beta"), ratio = table.numbers("Mprime"),
             q0 = table.numbers("qy_at_p0_over_pc");
  double worst = 0.0;
  for (std::size_t i = 0; i < slope.size(); ++i) {
    const CamClay m = reference_model(with_plasticity(base, slope[i], beta[i], 5.0));
    worst = std::max({worst, std::abs(exact::critical_ratio(m) - ratio[i]),
                      std::abs(exact::yield_without_pressure(m, m.initial_internal()) / m.preconsolidation_pressure - q0[i])});
  }
  result.check_at_most(Label::verification, "M' and q at p = 0 of the paper's grid against the printed table", worst, 0.0, "", 1e-9,
                       "ten digits are printed");
}

void run(const CaseContext& context, CaseResult& result) {
  const PathSpec file = read_path(context.case_directory() / "case.toml");
  const mpm::CamClay::Parameters& snow = file.material.as<mpm::CamClay>();
  const std::vector<Material> materials = paper_materials(snow);
  isotropic_compression(result, materials, file);
  isochoric_critical_state(result, materials);
  drained_critical_state(result, materials, false);
  drained_critical_state(result, materials, true);
  yield_without_pressure(result, materials);
  hencky_simple_shear(context, result, snow);
  printed_ratios(context, result, snow);
}

const Registration registered{{.title = "Isotropic compression and other closed forms of a material point", .run = run}};

}  // namespace
}  // namespace mpm::validation::isotropic_compression
