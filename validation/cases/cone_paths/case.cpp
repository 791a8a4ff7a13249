#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/cone_reference.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/point_comparison.hpp"

namespace mpm::validation::cone_paths {
namespace {

using Segment = ReferenceSegment;

struct Material {
  std::string name;
  DruckerPrager::Parameters parameters;
  [[nodiscard]] bool by_rate() const { return parameters.limit_friction_angle.has_value(); }
};

std::vector<Material> all_materials(const DruckerPrager::Parameters& base) {
  constexpr double degree = std::numbers::pi / 180.0;
  std::vector<Material> all;
  const auto add = [&](const std::string& name, ConeMatching matching, double phi, double psi, double cohesion) {
    DruckerPrager::Parameters p = base;
    p.cone_matching = matching;
    p.friction_angle = phi * degree;
    p.dilatancy_angle = psi * degree;
    p.cohesion = cohesion;
    all.push_back({name, p});
  };
  add("φ 30°", ConeMatching::triaxial_compression, 30.0, 0.0, 0.0);
  add("φ 40°, ψ 10°", ConeMatching::triaxial_compression, 40.0, 10.0, 0.0);
  add("φ = ψ = 25°, c 1 kPa", ConeMatching::triaxial_compression, 25.0, 25.0, 1e3);
  add("φ 20°, c 2 kPa, simple shear", ConeMatching::simple_shear, 20.0, 0.0, 2e3);
  for (const double grain : {0.1, 1.0}) {  // m; with one second a segment the inertial number is about 0.02 and 0.2
    add(fmt::format("μ(I), d = {} m", grain), ConeMatching::simple_shear, 20.9, 0.0, 0.0);
    DruckerPrager::Parameters& p = all.back().parameters;
    p.limit_friction_angle = 32.76 * degree;
    p.reference_inertial_number = 0.279;
    p.grain_diameter = grain;
    p.grain_density = 2500.0;
  }
  return all;
}

struct Path {
  std::string name;
  bool turning;  ///< principal axes turn
  bool loose;    ///< reaches the apex and closes again: materials without cohesion and rate dependence
  bool at_once;  ///< yields where it has no stress: materials without rate dependence
  std::vector<Segment> segments;
};

Segment stretch(double v, double q) {
  Mat3 l = Vec3(0.5, 0.5, -1.0).asDiagonal();
  return Segment::general(q * l + v / 3.0 * Mat3::Identity());
}
Segment shear(int i, int j, double gamma) {
  Mat3 l = Mat3::Zero();
  l(i, j) = gamma;
  return Segment::general(l);
}

/// Velocity gradients throughout: they last one second, and so have a rate.
std::vector<Path> all_paths(const PathSpec& file) {
  std::vector<Segment> reloading;
  for (const Segment& s : reference_segments(file)) reloading.push_back(stretch(s.d_eps_v, s.d_eps_q));
  const Segment compact = stretch(-0.02, 0.0);
  Mat3 spin;
  spin << -0.01, 0.2, 0.0, -0.1, 0.0, 0.05, 0.0, 0.1, -0.005;
  return {
      {"isochoric compression after compaction", false, false, false, {compact, stretch(0.0, 0.05)}},
      {"isochoric extension after compaction", false, false, false, {compact, stretch(0.0, -0.05)}},
      {"oedometric compression", false, false, true, {stretch(-0.03, 0.02)}},
      {"load, unload, reload", false, false, false, reloading},
      {"torn, sheared loose, closed, loaded",
       false,
       true,
       true,
       {compact, stretch(0.03, 0.01), stretch(-0.005, 0.03), stretch(-0.025, 0.0), stretch(-0.01, 0.04)}},
      {"simple shear", true, false, false, {compact, shear(0, 2, 0.3)}},
      {"shear with spin", true, false, false, {compact, Segment::general(spin)}},
      {"rotating shear", true, false, false, {compact, shear(0, 2, 0.1), shear(1, 2, 0.1), shear(0, 2, -0.1), shear(1, 2, -0.1)}},
  };
}

struct Outcome {
  const Path* path = nullptr;
  const Material* material = nullptr;
  PathComparison comparison;
  [[nodiscard]] bool exact() const { return !path->turning && !material->by_rate(); }
  [[nodiscard]] std::string name() const { return fmt::format("{} with {}", path->name, material->name); }
};

constexpr double order_low = 0.9, order_high = 1.2;

void draw(CaseResult& result, const std::vector<Outcome>& outcomes) {
  for (const bool by_rate : {false, true}) {
    Plot stress{by_rate ? "stress-rate" : "stress",
                by_rate ? "Stress paths of μ(I), d = 1 m" : "Stress paths of the cone φ 40°, ψ 10°",
                "p [kPa]",
                "q [kPa]",
                {},
                "Black: CVODE; markers: return map, every tenth sample."};
    Plot error{by_rate ? "error-rate" : "error",
               by_rate ? "Error of the return map, μ(I), d = 1 m" : "Error of the return map, φ 40°, ψ 10°",
               "step, 1/steps per segment [-]",
               "error over the largest stress [-]",
               {},
               "Maximum norm along the path; exact paths are at round-off.",
               true,
               true};
    for (const Outcome& o : outcomes) {
      if (o.material->by_rate() != by_rate || o.material->name != (by_rate ? "μ(I), d = 1 m" : "φ 40°, ψ 10°")) continue;
      const auto& points = o.comparison.reference.points;
      Series line{"", {}, {}, Series::Style::reference}, marks{o.path->name, {}, {}, Series::Style::points};
      for (std::size_t i = 0; i < points.size(); i += 4) line.x.push_back(1e-3 * points[i].p), line.y.push_back(1e-3 * points[i].q);
      for (std::size_t i = 0; i < points.size(); i += 32)
        marks.x.push_back(1e-3 * o.comparison.finest[i].p), marks.y.push_back(1e-3 * o.comparison.finest[i].q);
      stress.series.push_back(std::move(line));
      stress.series.push_back(std::move(marks));
      Series e{o.path->name, {}, o.comparison.error, Series::Style::points};
      for (const int n : o.comparison.steps) e.x.push_back(1.0 / n);
      error.series.push_back(std::move(e));
    }
    if (stress.series.empty()) continue;
    stress.series.front().name = "CVODE";
    result.plots.push_back(std::move(stress));
    result.plots.push_back(std::move(error));
  }
}

void run(const CaseContext& context, CaseResult& result) {
  const PathSpec file = read_path(context.case_directory() / "case.toml");
  const std::vector<Material> materials = all_materials(file.material.as<DruckerPrager>());
  const std::vector<Path> paths = all_paths(file);
  std::vector<Outcome> outcomes;
  for (const Path& path : paths)
    for (const Material& material : materials)
      if (!(path.loose && material.parameters.cohesion > 0.0) && !(path.at_once && material.by_rate()))
        outcomes.push_back({&path, &material, {}});
  in_parallel(outcomes.size(), [&](std::size_t i) {
    Outcome& o = outcomes[i];
    ComparisonOptions options;
    options.general = true;
    options.samples = 320;
    options.coarsest = 160;
    options.finest = o.exact() ? 1280 : context.choose(20480, 20480, 81920);
    ReferenceOptions reference;
    reference.samples_per_segment = static_cast<std::size_t>(options.samples);
    try {
      o.comparison = compare_path(o.material->parameters, o.path->segments,
                                  cone_reference(Cone::of(o.material->parameters), o.path->segments, reference), options);
    } catch (const Error& e) {
      throw UnstableError(fmt::format("{}: {}", o.name(), e.what()));
    }
  });

  for (const Path& path : paths) {
    Extreme exact, lowest, highest, drift, finest;
    for (const Outcome& o : outcomes) {
      if (o.path != &path) continue;
      const PathComparison& c = o.comparison;
      drift.add(c.reference.drift, o.material->name);
      if (o.exact()) {
        exact.add(*std::max_element(c.error.begin(), c.error.end()), o.material->name);
        continue;
      }
      lowest.add(-c.tail_order(), o.material->name);
      highest.add(c.tail_order(), o.material->name);
      finest.add(c.error.back(), o.material->name);
    }
    if (exact.count > 0)
      result.check_at_most(
          Label::verification, fmt::format("{}: largest error against CVODE, {} cones, 160 to 1280 steps", path.name, exact.count),
          exact.value, 0.0, "", 1e-10,
          fmt::format("with fixed principal axes the map is exact, because p and q are linear along the path; CVODE's 1e-13 over "
                      "some thousand steps; largest at {}",
                      exact.name));
    if (lowest.count > 0) {
      result.check_order(Label::verification, fmt::format("{}: lowest order in the tail, {} materials", path.name, lowest.count),
                         -lowest.value, order_low, order_high, fmt::format("backward Euler is of first order; lowest at {}", lowest.name));
      result.check_order(Label::verification, fmt::format("{}: highest order in the tail", path.name), highest.value, order_low, order_high,
                         fmt::format("backward Euler is of first order; highest at {}", highest.name));
      result.notes.push_back(
          fmt::format("{}: error at the finest step at most {:.1e} of the largest stress ({}).", path.name, finest.value, finest.name));
    }
    result.check_at_most(Label::verification, path.name + ": drift |f| of the reference over the largest stress", drift.value, 0.0, "",
                         1e-9, fmt::format("consistency integrated at 1e-13; largest: {}", drift.name));
  }
  draw(result, outcomes);
}

const Registration registered{{.title = "Stress paths of Drucker-Prager and mu(I) against SUNDIALS", .run = run}};

}  // namespace
}  // namespace mpm::validation::cone_paths
