#pragma once
/// A made-up history of an impact, loaded into the observers like a checkpoint, so that their results are known.

#include <algorithm>
#include <cmath>
#include <vector>

#include "libmpm/observe/contact_force.hpp"
#include "libmpm/observe/force_by_height.hpp"
#include "libmpm/observe/observer_list.hpp"
#include "libmpm/observe/prediction.hpp"
#include "libmpm/observe/pressure_profile.hpp"
#include "libmpm/observe/runup.hpp"
#include "libmpm/observe/steady_interval.hpp"

namespace mpm::testing {

/// One sample.
struct ImpactSample {
  double time = 0.0, runup = 0.0, runup_p99 = 0.0, pressure_height = std::nan(""), impact_pressure = 0.0, compaction = 0.0;
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  std::vector<double> pressure;         ///< one a bin
  std::vector<double> force_by_height;  ///< one a bin and one above; empty: zeros
  double first_moment = 0.0;
};

/// The observers of an impact.
inline ObserverList impact_observers(const ImpactGeometry& geometry, const ImpactFlow& flow) {
  return ObserverList({std::make_shared<SteadyInterval>(flow, "runup_p99_m"), std::make_shared<Runup>(geometry),
                       std::make_shared<PressureProfile>(geometry), std::make_shared<ContactForce>(0U),
                       std::make_shared<ForceByHeight>(geometry, 0U), std::make_shared<TransientForce>(flow, geometry.force_window),
                       std::make_shared<Prediction>(flow, geometry.flow_height)});
}

/// Their saved state after these samples.
inline Arrays arrays_of(const std::vector<ImpactSample>& samples, const ImpactGeometry& geometry) {
  Arrays a = impact_observers(geometry, {}).save();
  for (const ImpactSample& s : samples) {
    const auto put = [&](const char* name, double value) { a[name].push_back(value); };
    put("series.time_s", s.time);
    put("series.runup_m", s.runup);
    put("series.runup_p99_m", s.runup_p99);
    put("series.pressure_height_m", s.pressure_height);
    put("series.impact_pressure_pa", s.impact_pressure);
    put("series.compaction", s.compaction);
    for (int i = 0; i < 3; ++i) {
      put((std::string("series.force_") + "xyz"[i] + "_n").c_str(), s.force[i]);
      put((std::string("series.moment_") + "xyz"[i] + "_n_m").c_str(), s.moment[i]);
    }
    auto& pressure = a["pressure_profile.pressure_pa"];
    pressure.insert(pressure.end(), s.pressure.begin(), s.pressure.end());
    auto& bins = a["force_by_height.force_n"];
    if (s.force_by_height.empty()) bins.resize(bins.size() + geometry.profile_bins() + 1, 0.0);
    bins.insert(bins.end(), s.force_by_height.begin(), s.force_by_height.end());
    put("force_by_height.first_moment_n_m", s.first_moment);
  }
  return a;
}

/// Observers after these samples, and their results.
struct MeasuredImpact {
  MeasuredImpact(const std::vector<ImpactSample>& samples, const ImpactGeometry& geometry, const ImpactFlow& flow)
      : observers(impact_observers(geometry, flow)), state(0.25) {
    observers.load(arrays_of(samples, geometry), samples.size());
    const Summary end = observers.summary(&state, &progress);
    results = observers.results(end);
    profiles = end.profiles;
  }
  [[nodiscard]] double number(const char* name, std::size_t component = 0) const { return results.number(name, component); }
  [[nodiscard]] bool steady() const { return number("steady") != 0.0; }
  /// A column of profile.csv.
  [[nodiscard]] const std::vector<double>& profile(const char* name) const {
    return std::ranges::find(profiles, name, [](const HeightProfile& p) { return p.column.name(); })->mean;
  }

  ObserverList observers;
  State state;
  RunProgress progress;
  Results results;
  std::vector<HeightProfile> profiles;
};

}  // namespace mpm::testing
