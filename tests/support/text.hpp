#pragma once
/// Texts that several tests use.

#include <string>

namespace mpm::testing {

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A case: an elastic block of 1 m that falls for 0.02 s, without a cell size. Its results have every quantity from the start.
inline constexpr const char* falling_block_case = R"([material]
model = "hencky_elastic"
[[body]]
min_m = [0.0, 0.0, 0.0]
max_m = [1.0, 1.0, 1.0]
[domain]
min_m = [-5.0, -5.0, -5.0]
max_m = [5.0, 5.0, 5.0]
[output]
duration_s = 0.02
series_per_second = 100
)";

/// The same as the base of a plan. Some hundred particles, some steps.
inline constexpr const char* falling_block_plan = R"([base.material]
model = "hencky_elastic"
[[base.body]]
min_m = [0.0, 0.0, 0.0]
max_m = [1.0, 1.0, 1.0]
[base.domain]
min_m = [-5.0, -5.0, -5.0]
max_m = [5.0, 5.0, 5.0]
[base.output]
duration_s = 0.02
series_per_second = 100
)";

/// A small avalanche on a mast as the base of a plan: some seconds of work, so that it can be killed half-way.
inline constexpr const char* avalanche_plan = R"([base.material]
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 5.0
[base.conveyor]
velocity_m_s = 4.0
flow_height_m = 1.0
width_m = 3.0
upstream_length_m = 2.0
downstream_length_m = 1.5
[base.obstacle]
width_m = 0.5
depth_m = 0.5
[base.output]
duration_s = 1.5
)";

}  // namespace mpm::testing
