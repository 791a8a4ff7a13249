#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "validation/harness/case.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/point_comparison.hpp"

namespace mpm::validation {
namespace {

using Segment = ReferenceSegment;

struct Path {
  std::string name;
  bool general, exact;
  std::function<std::vector<Segment>(const CamClay&)> segments;
};

std::vector<Path> all_paths() {
  const Segment compress = Segment::strain_increment(-0.04, 0.0);
  const auto fixed = [](std::vector<Segment> s) { return [s](const CamClay&) { return s; }; };
  const auto drained = [compress](double axial) {
    return [=](const CamClay& m) {
      return std::vector{compress, Segment::drained(m.preconsolidation(exact::isotropic_compression(m, 0.04)), axial)};
    };
  };
  Mat3 shear = Mat3::Zero(), turning;
  shear(0, 2) = 0.3;
  turning << -0.05, 0.2, 0.0, -0.1, 0.0, 0.05, 0.0, 0.1, -0.02;
  return {
      {"isotropic compression", false, true, fixed({Segment::strain_increment(-0.1, 0.0)})},
      {"hydrostatic tension", false, true, fixed({Segment::strain_increment(0.03, 0.0)})},
      {"oedometric compression", false, false, fixed({Segment::strain_increment(-0.1, 0.2 / 3.0)})},
      {"drained triaxial compression", false, false, drained(-0.15)},
      {"drained triaxial extension", false, false, drained(0.05)},
      {"undrained triaxial compression", false, false, fixed({compress, Segment::strain_increment(0.0, 0.12)})},
      {"undrained triaxial extension", false, false, fixed({compress, Segment::strain_increment(0.0, -0.12)})},
      {"load, unload, reload", false, false,
       fixed({Segment::strain_increment(-0.05, 0.05), Segment::strain_increment(0.004, -0.004), Segment::strain_increment(-0.05, 0.05)})},
      {"dilation to softening", false, false, fixed({Segment::strain_increment(-0.01, 0.0), Segment::strain_increment(0.004, 0.04)})},
      {"simple shear", true, false, fixed({compress, Segment::general(shear)})},
      {"turning shear", true, false, fixed({compress, Segment::general(turning)})}};
}

struct Outcome {
  PathComparison comparison;
  double order = 0.0;
  bool jumps = false;  ///< snap-back
  bool nearly =
      false;  ///< plastic strain amplified more than five times over (ReferencePath::margin): first order needs more than 20480 steps
};

/// Doubles the steps until the order is that of the tail.
Outcome converge(const MaterialSpec& spec, const Path& path) {
  Outcome o;
  const auto segments = path.segments(reference_model(spec));
  for (int n = 160; n <= 20480; n *= 2) {
    o.comparison = compare_path(spec, segments, {n / 8, n / 4, n / 2, n}, path.general);
    o.order = o.comparison.tail_order();
    for (const EventRecord& e : o.comparison.reference.events) o.jumps = o.jumps || e.event == PathEvent::snap_back;
    o.nearly = o.comparison.reference.margin < 0.2;
    if (path.exact || o.jumps || (o.order >= 0.9 && o.order <= 1.2)) break;
  }
  return o;
}

/// Stress path and p_c of one material, reference and return map.
void draw(CaseResult& result, const std::string& id, const Path& path, const PathComparison& c) {
  Series line{"CVODE", {}, {}, Series::Style::reference}, marks{"return map", {}, {}, Series::Style::points};
  Series pc_line = line, pc_marks = marks;
  const std::size_t stride = std::max<std::size_t>(1, c.finest.size() / 60), fine = std::max<std::size_t>(1, c.finest.size() / 600);
  for (std::size_t i = 0; i < c.finest.size(); i += fine) {
    const ReferencePoint& r = c.reference.points[i];
    line.x.push_back(r.p * 1e-3);
    line.y.push_back(r.q * 1e-3);
    pc_line.x.push_back(r.time);
    pc_line.y.push_back(r.preconsolidation * 1e-3);
  }
  for (std::size_t i = 0; i < c.finest.size(); i += stride) {
    marks.x.push_back(c.finest[i].p * 1e-3);
    marks.y.push_back(c.finest[i].q * 1e-3);
    pc_marks.x.push_back(c.reference.points[i].time);
    pc_marks.y.push_back(c.finest[i].preconsolidation_pressure * 1e-3);
  }
  if (!path.exact)
    result.plots.push_back(
        {id, "Stress path: " + path.name, "p [kPa]", "q [kPa]", {line, marks}, "M = 0.8, β = 0.3, ξ = 5.", false, false});
  result.plots.push_back({id + "-pc",
                          "Pre-consolidation pressure: " + path.name,
                          "segments passed [-]",
                          "p_c [kPa]",
                          {pc_line, pc_marks},
                          "M = 0.8, β = 0.3, ξ = 5.",
                          false,
                          false});
}

void run(const CaseContext& context, CaseResult& result) {
  const auto slopes = std::vector{0.4, 0.8, 1.2}, betas = std::vector{0.0, 0.15, 0.3, 0.45};
  const auto xis = std::vector{0.05, 0.15, 0.5, 1.5, 5.0, 15.0};
  double drift = 0.0;
  int jumps = 0, nearly = 0, total = 0;
  double nearly_lowest = std::numeric_limits<double>::infinity();
  Plot order{"order",
             "Error of the return map, M = 0.8, β = 0.3, ξ = 5",
             "step, 1/steps per segment [-]",
             "error over largest p_c [-]",
             {},
             "",
             true,
             true};
  for (const Path& path : all_paths()) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest, worst_error = 0.0;
    int most_steps = 0;
    std::string lowest_at;
    for (const double m : slopes)
      for (const double beta : betas)
        for (const double xi : xis) {
          const MaterialSpec spec = cam_clay_spec(m, beta, xi);
          const Outcome o = converge(spec, path);
          ++total;
          jumps += o.jumps ? 1 : 0;
          drift = std::max(drift, o.comparison.reference.drift);
          const bool shown = m == 0.8 && beta == 0.3 && xi == 5.0;
          if (shown) draw(result, fmt::format("path{}", result.plots.size()), path, o.comparison);
          if (path.exact) {
            worst_error = std::max(worst_error, *std::max_element(o.comparison.error.begin(), o.comparison.error.end()));
            continue;
          }
          if (o.jumps) continue;
          if (o.nearly) {
            ++nearly;
            nearly_lowest = std::min(nearly_lowest, o.order);
            continue;
          }
          if (shown) order.series.push_back({path.name, o.comparison.size, o.comparison.error, Series::Style::points});
          worst_error = std::max(worst_error, o.comparison.error.back());
          most_steps = std::max(most_steps, static_cast<int>(std::lround(1.0 / o.comparison.size.back())));
          if (!(o.order >= lowest)) {
            lowest = o.order;
            lowest_at = fmt::format("M = {}, β = {}, ξ = {}", m, beta, xi);
          }
          highest = std::max(highest, o.order);
        }
    if (path.exact) {
      result.check_absolute(Label::verification, path.name + ": largest error over largest p_c, all materials", worst_error, 0.0, "", 1e-9,
                            "the map is exact on this path; the reference near p_c = 0 is good to 1e-10");
    } else {
      result.check_order(Label::verification, path.name + ": lowest order of all materials", lowest, 0.9, 1.2,
                         "backward Euler is of first order");
      result.check_order(Label::verification, path.name + ": highest order of all materials", highest, 0.9, 1.2,
                         "backward Euler is of first order");
      result.notes.push_back(
          fmt::format("{}: largest error at the finest step {:.1e} of the largest p_c, at most {} steps a segment, lowest order at {}.",
                      path.name, worst_error, most_steps, lowest_at));
    }
    context.log(path.name);
  }
  result.check_at_most(Label::verification, "drift |y|/max(p_c, 1e-3 p_c0)² of the reference, largest of all", drift, 0.0, "", 1e-9,
                       "y' = 0 integrated at 1e-13");
  result.notes.push_back(
      fmt::format("{} of {} combinations of path and material snap back and have no order; {} come close to it (plastic strain amplified "
                  "more than five times).",
                  jumps, total, nearly));
  result.check_order(Label::verification, "paths close to a snap-back: lowest order at 20480 steps", nearly_lowest, 0.0, 1.2,
                     "they must converge; first order needs still smaller steps");

  double disagreement = 0.0;
  for (const double m : slopes)
    for (const double beta : betas)
      for (const double xi : xis) {
        const CamClay model = reference_model(cam_clay_spec(m, beta, xi));
        const ReferencePath cvode =
            coaxial_reference(model, {Segment::strain_increment(-0.04, 0.0), Segment::strain_increment(-0.02, 0.1)}, {1e-13, 100});
        const auto ida = dae_reference(model, cvode.points[100], -0.02, 0.1, 100);
        for (std::size_t i = 0; i < ida.size(); ++i) {
          const ReferencePoint& r = cvode.points[101 + i];
          disagreement =
              std::max({disagreement, std::abs(r.p - ida[i].p) / r.preconsolidation, std::abs(r.q - ida[i].q) / r.preconsolidation});
        }
      }
  result.check_absolute(Label::verification, "CVODE rate form against IDA index-1 form, 72 materials, over p_c", disagreement, 0.0, "",
                        1e-8, "two integrators at 1e-13 and 1e-12");

  double inviscid = 0.0;
  for (const double beta : betas)
    for (const double xi : xis) {
      const MaterialSpec spec = cam_clay_spec(0.0, beta, xi);
      const CamClay model = reference_model(spec);
      for (const int steps : {1, 40}) {
        const auto rows = follow_path(library_path(spec, {Segment::strain_increment(-0.1, 0.1)}, steps));
        inviscid = std::max(inviscid, relative_error(rows.back().p, model.preconsolidation(exact::isotropic_compression(model, 0.1))));
        inviscid = std::max(inviscid, rows.back().q / rows.back().p);
      }
    }
  result.check_absolute(Label::verification, "M = 0: compression with shear, relative error of p and q/p", inviscid, 0.0, "", 1e-12,
                        "q = 0 and p = K sinh(ξ X), exact for any step");

  Series slope{"order 1", {1.0 / 20, 1.0 / 160}, {}, Series::Style::bound};
  for (const double h : slope.x) slope.y.push_back(0.2 * h);
  order.series.insert(order.series.begin(), slope);
  result.plots.insert(result.plots.begin(), std::move(order));
}

const Registration registered{{MPM_CASE_NAME, "Stress paths against SUNDIALS", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
