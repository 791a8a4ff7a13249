#pragma once
/// Random trial states through the return map of cohesive Modified Cam-Clay, in all number types at once.
///
/// The 64 states of a group have one material, drawn from M = 0 or 1e-3 to 3, beta = 0 or up to 0.9, xi from 0.02 to 50, p_c0 from 1 Pa to
/// 1 MPa, E from 0.1 to 100 MPa, nu from 0 to 0.45. A state is admissible: expanded (X < 0), or inside, on the surface or on the
/// hydrostatic axis, with p_c over eight decades around p_c0 (elastic strains up to 1/2); its increment reaches from 1e-9 to 0.5, isotropic
/// or general. Numbers are those of a counter-based generator: the same on every machine and any number of threads.

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "libmpm/material/cam_clay.hpp"

namespace mpm::validation {

/// One state and what is done to it.
struct Trial {
  MaterialState<double> state;
  Matrix3<double> dl;
};

/// A material and its trial states.
struct TrialGroup {
  static constexpr int size = 64;
  mpm::CamClay::Parameters spec;
  std::vector<Trial> trials;
};
TrialGroup draw_trials(std::uint64_t group);

/// The largest of all states, and the state.
struct WorstOf {
  double value = 0.0;
  std::string where;
};

/// Each value is relative to the round-off that the step may have (the reasons are with Bound in random_trials.cpp): at most 1 is
/// right.
struct TrialReport {
  std::int64_t states = 0, plastic = 0, compacting = 0, dilating = 0, stress_free = 0;  ///< what was met, by double
  std::int64_t not_finite = 0;                                                          ///< results in any number type that are not finite
  WorstOf outside;                                                                      ///< y > 0 after the step
  WorstOf off_surface;                                                                  ///< |y| of yielded states that still carry stress
  WorstOf negative_work;                                                                ///< -(p dX + q d eps_q^P)
  WorstOf lanes_difference;  ///< X and stress of Lanes and LanePair against double
  void merge(const TrialReport& other);
};

/// Judges one result of `spec`'s law.
void judge(const mpm::CamClay& law, const mpm::CamClay::Parameters& spec, const Trial& trial, const MaterialState<double>& after,
           TrialReport& report);
/// Adds the difference between two number types.
void compare(const mpm::CamClay& law, const mpm::CamClay::Parameters& spec, const Trial& trial, const MaterialState<double>& scalar,
             const MaterialState<double>& vectorised, TrialReport& report);

/// The library's own map.
struct LibraryMap {
  template <LaneNumber T>
  void operator()(const mpm::CamClay& law, MaterialState<T>& state, const Matrix3<T>& dl) const {
    law.update_stress(state, dl, 1.0);
  }
};

/// Runs the trials lanes_of<T> at a time.
template <LaneNumber T, class Map>
std::vector<MaterialState<double>> map_trials(const mpm::CamClay& law, const std::vector<Trial>& trials, const Map& map) {
  constexpr int width = lanes_of<T>;
  static_assert(TrialGroup::size % width == 0);
  std::vector<MaterialState<double>> after(trials.size());
  for (std::size_t first = 0; first + width <= trials.size(); first += width) {
    MaterialState<T> state{};
    Matrix3<T> dl{};
    for (int i = 0; i < width; ++i) {
      const Trial& t = trials[first + static_cast<std::size_t>(i)];
      const Sym3<double>& s = t.state.stress;
      set_lane(state.stress.xx, i, s.xx), set_lane(state.stress.yy, i, s.yy), set_lane(state.stress.zz, i, s.zz);
      set_lane(state.stress.xy, i, s.xy), set_lane(state.stress.xz, i, s.xz), set_lane(state.stress.yz, i, s.yz);
      set_lane(state.internal, i, t.state.internal);
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) set_lane(dl.m[a][b], i, t.dl.m[a][b]);
    }
    map(law, state, dl);
    for (int i = 0; i < width; ++i) {
      const Sym3<T>& s = state.stress;
      after[first + static_cast<std::size_t>(i)] = {
          {lane(s.xx, i), lane(s.yy, i), lane(s.zz, i), lane(s.xy, i), lane(s.xz, i), lane(s.yz, i)}, lane(state.internal, i)};
    }
  }
  return after;
}

/// One group through double, Lanes and LanePair; every result is judged, the lanes are compared with double.
template <class Map>
TrialReport try_group(const TrialGroup& group, const Map& map) {
  TrialReport report;
  const mpm::CamClay law(group.spec);
  const auto scalar = map_trials<double>(law, group.trials, map);
  const auto eight = map_trials<Lanes>(law, group.trials, map);
  const auto sixteen = map_trials<LanePair>(law, group.trials, map);
  for (std::size_t i = 0; i < group.trials.size(); ++i) {
    const Trial& trial = group.trials[i];
    judge(law, group.spec, trial, scalar[i], report);
    TrialReport lanes;  // judged as well, counted once
    judge(law, group.spec, trial, eight[i], lanes);
    judge(law, group.spec, trial, sixteen[i], lanes);
    compare(law, group.spec, trial, scalar[i], eight[i], lanes);
    compare(law, group.spec, trial, scalar[i], sixteen[i], lanes);
    lanes.states = lanes.plastic = lanes.compacting = lanes.dilating = lanes.stress_free = 0;
    report.merge(lanes);
  }
  return report;
}

/// Sweeps groups 0 to ceil(states/64) - 1 on all OpenMP threads.
TrialReport try_random_states(std::int64_t states);

}  // namespace mpm::validation
