#include "validation/harness/random_trials.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace mpm::validation {
namespace {

using Law = mpm::CamClay;

TEST(RandomTrials, TheLibrarysMapPasses) {
  const TrialReport r = try_random_states(10000);
  EXPECT_EQ(r.states, 10048);  // whole groups of 64
  EXPECT_EQ(r.not_finite, 0);
  for (const WorstOf* w : {&r.outside, &r.off_surface, &r.negative_work, &r.lanes_difference}) EXPECT_LE(w->value, 1.0) << w->where;
  // every kind of answer is met often
  EXPECT_GT(r.compacting, 1000);
  EXPECT_GT(r.dilating, 1000);
  EXPECT_GT(r.stress_free, 1000);
  EXPECT_GT(r.states - r.plastic, 1000);
}

TEST(RandomTrials, DrawsTheSameStatesAgain) {
  const TrialGroup a = draw_trials(17), b = draw_trials(17), c = draw_trials(18);
  EXPECT_EQ(a.spec.hardening_xi, b.spec.hardening_xi);
  EXPECT_NE(a.spec.hardening_xi, c.spec.hardening_xi);
  for (std::size_t i = 0; i < a.trials.size(); ++i) {
    EXPECT_EQ(a.trials[i].state.stress.xy, b.trials[i].state.stress.xy);
    EXPECT_EQ(a.trials[i].dl.m[1][2], b.trials[i].dl.m[1][2]);
  }
}

TEST(RandomTrials, StartsFromAdmissibleStates) {
  for (std::uint64_t g = 0; g < 50; ++g) {
    const TrialGroup group = draw_trials(g);
    const Law law(group.spec);
    for (const Trial& t : group.trials) {
      const double p_c = law.preconsolidation_pressure(t.state.internal);
      EXPECT_LE(law.yield_function(t.state), 1e-12 * p_c * p_c * (1.0 + group.spec.critical_state_slope * group.spec.critical_state_slope));
    }
  }
}

/// Runs 100 groups through a map and merges.
template <class Map>
TrialReport try_groups(const Map& map) {
  TrialReport r;
  for (std::uint64_t g = 0; g < 100; ++g) r.merge(try_group(draw_trials(g), map));
  return r;
}

struct StopsShort {  // five parts in a billion of the stress too much
  template <LaneNumber T>
  void operator()(const Law& law, MaterialState<T>& s, const Matrix3<T>& dl) const {
    law.update_stress(s, dl, 1.0);
    s.stress = broadcast<T>(1.0 + 5e-9) * s.stress;
  }
};
TEST(RandomTrials, SeesAStateBeyondTheSurface) {
  const TrialReport r = try_groups(StopsShort{});
  EXPECT_GT(r.outside.value, 1.0);
  EXPECT_FALSE(r.outside.where.empty());
}

struct FallsInside {
  template <LaneNumber T>
  void operator()(const Law& law, MaterialState<T>& s, const Matrix3<T>& dl) const {
    law.update_stress(s, dl, 1.0);
    s.stress = broadcast<T>(1.0 - 5e-9) * s.stress;
  }
};
TEST(RandomTrials, SeesAYieldedStateInsideTheSurface) {
  const TrialReport r = try_groups(FallsInside{});
  EXPECT_LE(r.outside.value, 1.0);
  EXPECT_GT(r.off_surface.value, 1.0);
}

struct DriftsInLanes {
  template <LaneNumber T>
  void operator()(const Law& law, MaterialState<T>& s, const Matrix3<T>& dl) const {
    law.update_stress(s, dl, 1.0);
    if (lanes_of < T >> 1) s.internal *= broadcast<T>(1.0 + 1e-10);
  }
};
TEST(RandomTrials, SeesLanesThatDifferFromDouble) { EXPECT_GT(try_groups(DriftsInLanes{}).lanes_difference.value, 1.0); }

struct CompactsInTension {
  template <LaneNumber T>
  void operator()(const Law& law, MaterialState<T>& s, const Matrix3<T>& dl) const {
    const T before = s.internal;
    law.update_stress(s, dl, 1.0);
    s.internal = before - (s.internal - before);
  }
};
TEST(RandomTrials, SeesNegativeWork) { EXPECT_GT(try_groups(CompactsInTension{}).negative_work.value, 1.0); }

struct GivesUp {
  template <LaneNumber T>
  void operator()(const Law& law, MaterialState<T>& s, const Matrix3<T>& dl) const {
    law.update_stress(s, dl, 1.0);
    if (lanes_of<T> == 8) s.internal = broadcast<T>(std::numeric_limits<double>::quiet_NaN());
  }
};
TEST(RandomTrials, CountsWhatIsNotFiniteInAnyNumberType) { EXPECT_EQ(try_groups(GivesUp{}).not_finite, 6400); }

}  // namespace
}  // namespace mpm::validation
