#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "validation/harness/case.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/point_comparison.hpp"

namespace mpm::validation {
namespace {

using Segment = ReferenceSegment;

constexpr double compression = 0.1;

void isotropic(CaseResult& result) {
  double worst_p = 0.0, worst_pc = 0.0;
  Plot curves{"isotropic", "Isotropic compression, p over volumetric strain",    "-ε_v [-]", "p [kPa]",
              {},          "Lines: closed form. Markers: return map, 40 steps.", false,      false};
  for (const double xi : {0.05, 0.5, 5.0, 15.0}) {
    const MaterialSpec spec = cam_clay_spec(0.8, 0.3, xi);
    const CamClay model = reference_model(spec);
    const double yield_at = spec.preconsolidation_pressure / model.bulk_modulus;
    const auto exact_internal = [&](double e) { return e <= yield_at ? model.initial_internal() : exact::isotropic_compression(model, e); };
    const auto exact_p = [&](double e) { return e <= yield_at ? model.bulk_modulus * e : model.preconsolidation(exact_internal(e)); };
    for (const int steps : {1, 7, 40, 160}) {
      const auto rows = follow_path(library_path(spec, {Segment::strain_increment(-compression, 0.0)}, steps));
      Series marks{fmt::format("ξ = {}", xi), {}, {}, Series::Style::points};
      for (const PathRow& r : rows) {
        const double e = -r.eps_v;
        if (r.step > 0) {
          worst_p = std::max(worst_p, relative_error(r.p, exact_p(e)));
          worst_pc = std::max(worst_pc, relative_error(r.preconsolidation_pressure, model.preconsolidation(exact_internal(e))));
        }
        marks.x.push_back(e);
        marks.y.push_back(r.p * 1e-3);
      }
      if (steps != 40) continue;
      Series line{fmt::format("closed form, ξ = {}", xi), {}, {}, Series::Style::reference};
      for (int i = 0; i <= 200; ++i) {
        line.x.push_back(compression * i / 200.0);
        line.y.push_back(exact_p(line.x.back()) * 1e-3);
      }
      curves.series.push_back(std::move(line));
      curves.series.push_back(std::move(marks));
    }
  }
  for (const auto& [name, value] : {std::pair{"p", worst_p}, std::pair{"p_c", worst_pc}})
    result.check_absolute(Label::verification, fmt::format("isotropic {}: largest relative error, 4 ξ, 1 to 160 steps", name), value, 0.0,
                          "", 1e-12, "no step error on this path; round-off of sinh and of up to 160 increments");
  curves.log_y = true;
  for (Series& s : curves.series) {  // the stress-free start has no place on a logarithmic axis
    s.x.erase(s.x.begin());
    s.y.erase(s.y.begin());
  }
  result.plots.push_back(std::move(curves));
}

void against_cvode(CaseResult& result, const std::string& name, const std::string& id, const MaterialSpec& spec,
                   const std::vector<Segment>& segments, Plot& order) {
  const PathComparison c = compare_path(spec, segments, {20, 40, 80, 160});
  result.check_order(Label::verification, name + ": order in the maximum norm, 80 to 160 steps", c.tail_order(), 0.9, 1.2,
                     "backward Euler is of first order");
  result.check_at_most(Label::verification, name + ": drift |y|/p_c² of the reference", c.reference.drift, 0.0, "", 1e-9,
                       "y' = 0 integrated at 1e-13");
  order.series.push_back({name, c.size, c.error, Series::Style::points});
  Plot stress{id, "Stress path, " + name, "p [kPa]", "q [kPa]", {}, "", false, false};
  Plot hardening{id + "-pc", "Pre-consolidation pressure, " + name, "path, segments passed [-]", "p_c [kPa]", {}, "", false, false};
  Series line{"CVODE", {}, {}, Series::Style::reference}, marks{"return map, 160 steps a segment", {}, {}, Series::Style::points};
  Series pc_line = line, pc_marks = marks;
  for (const ReferencePoint& r : c.reference.points) {
    line.x.push_back(r.p * 1e-3);
    line.y.push_back(r.q * 1e-3);
    pc_line.x.push_back(r.time);
    pc_line.y.push_back(r.preconsolidation * 1e-3);
  }
  for (std::size_t i = 0; i < c.finest.size(); i += 8) {
    marks.x.push_back(c.finest[i].p * 1e-3);
    marks.y.push_back(c.finest[i].q * 1e-3);
    pc_marks.x.push_back(c.reference.points[i].time);
    pc_marks.y.push_back(c.finest[i].preconsolidation_pressure * 1e-3);
  }
  const double p_end = *std::max_element(line.x.begin(), line.x.end());
  const double ratio = exact::critical_ratio(reference_model(spec));
  stress.series = {{"critical state, q = M' p", {0.0, p_end}, {0.0, ratio * p_end}, Series::Style::bound}, line, marks};
  hardening.series = {pc_line, pc_marks};
  result.plots.push_back(std::move(stress));
  result.plots.push_back(std::move(hardening));
}

void run(const CaseContext&, CaseResult& result) {
  isotropic(result);
  const MaterialSpec spec = cam_clay_spec(0.8, 0.3, 5.0);
  const CamClay model = reference_model(spec);
  const Segment compress = Segment::strain_increment(-0.04, 0.0);  // beyond the onset of yield at 0.024
  const double confining = model.preconsolidation(exact::isotropic_compression(model, 0.04));
  Plot order{"order",
             "Return map against CVODE, maximum norm along the path",
             "step, 1/steps per segment [-]",
             "error over largest p_c [-]",
             {},
             "",
             true,
             true};
  against_cvode(result, "drained triaxial compression", "triaxial", spec, {compress, Segment::drained(confining, -0.15)}, order);
  const std::vector<Segment> shear{compress, Segment::strain_increment(0.0, 0.12)};
  against_cvode(result, "isochoric shear", "shear", spec, shear, order);
  Series slope{"order 1", {1.0 / 20, 1.0 / 160}, {}, Series::Style::bound};
  for (const double h : slope.x) slope.y.push_back(order.series[0].y.back() * h * 160);
  order.series.insert(order.series.begin(), slope);
  result.plots.push_back(std::move(order));

  const auto rows = follow_path(library_path(spec, {compress, Segment::strain_increment(0.0, 1.5)}, 160));
  const double x = exact::isochoric_critical_state(model, 0.04), pc = model.preconsolidation(x);
  result.check_relative(Label::verification, "isochoric shear: p at the critical state", rows.back().p,
                        0.5 * (1.0 - spec.cohesion_beta) * pc, "Pa", 1e-6, "approached exponentially; independent of the steps");
  result.check_relative(Label::verification, "isochoric shear: q/p at the critical state (M')", rows.back().q / rows.back().p,
                        exact::critical_ratio(model), "", 1e-6, "approached exponentially; independent of the steps");
}

const Registration registered{{MPM_CASE_NAME, "Isotropic compression, and two paths against CVODE", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
