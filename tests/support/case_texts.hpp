#pragma once
/// Case files as text, and what the messages about them hold.

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "support/typical_materials.hpp"

namespace mpm::testing {

/// Valid cases of every kind of scene.
/// @{
inline const std::string window_case = R"(title = "all keys of a conveyor"
format_version = 1
[material]
model = "cohesive_cam_clay"
density_kg_m3 = 300.0
young_modulus_pa = 1.0e6
poisson_ratio = 0.1
critical_state_slope = 0.4
cohesion_beta = 0.15
hardening_xi = 5.0
preconsolidation_pressure_pa = 1.0e4
[conveyor]
froude_number = 3.0
flow_height_m = 1.75
width_m = 20.5
feed = "window"
upstream_length_m = 8.0
downstream_length_m = 4.0
sidewall_contact = "coulomb"
sidewall_friction = 0.25
mirror_y = false
[obstacle]
shape = "box"
width_m = 1.75
depth_m = 1.5
height_m = 10.0
friction = 0.1
[numerics]
cell_size_m = 0.25
particles_per_cell = 27
transfer = "flip"
flip_ratio = 0.9
cfl = 0.3
gravity_m_s2 = 9.81
slope_deg = 33.3
grid_offset_cells = [0.25, 0.5, -0.75]
[measurement]
bin_height_m = 0.125
filter_length_m = 1.625
box_upstream_m = 0.625
box_inside_m = 0.125
[output]
duration_s = 6.0
series_per_second = 50
frames_per_second = 5
checkpoint_minutes = 2.5
stop_when_steady = 0.02
)";

/// window_case, with an arm on the mast.
inline const std::string arm_case = window_case + R"([arm]
length_m = 4.0
depth_m = 1.0
base_m = 2.0
height_m = 3.0
)";

inline const std::string strip_case = R"([material]
critical_state_slope = 0.8
cohesion_beta = 0.3
hardening_xi = 0.5
[conveyor]
velocity_m_s = 12.3
feed = "strip"
[obstacle]
[output]
duration_s = 6.0
)";

inline const std::string sheared_case = R"([material]
critical_state_slope = 0.8
cohesion_beta = 0.3
hardening_xi = 0.5
[conveyor]
froude_number = 1.0
sidewall_contact = "slip"
lattice = "aligned"
mirror_y = false
inflow_slip_ratio = 0.5
inflow_shear_exponent = 2.0
[obstacle]
rotation_deg = 20.0
friction_ratio = 0.5
[measurement]
force_window_s = 0.2
[output]
duration_s = 6.0
)";

inline const std::string surge_case = R"([material]
critical_state_slope = 0.8
cohesion_beta = 0.3
hardening_xi = 0.5
[conveyor]
velocity_m_s = 12.3
[[conveyor.inflow]]
time_s = 0.5
velocity_m_s = 10.0
flow_height_m = 1.5
density_ratio = 1.1
[obstacle]
shape = "wedge"
[output]
duration_s = 6.0
)";

inline const std::string hand_case = R"([material]
model = "hencky_elastic"
[[body]]
shape = "cylinder"
min_m = [-1.0, -1.0, 0.0]
max_m = [1.0, 1.0, 4]
velocity_m_s = [0.0, 0.5, 0.0]
lattice = "aligned"
[[body]]
min_m = [2.0, 2.0, 0.0]
max_m = [3.0, 3.0, 1.0]
[[wall]]
point_m = [0.0, 0.0, 0.0]
normal = [0.0, 0.6, 2.0]
contact = "separable"
friction = 0.4
velocity_m_s = [0.0, 0.0, 0.1]
[domain]
min_m = [-5.0, -5.0, -1.0]
max_m = [5.0, 5.0, 6.0]
mirror = ["x"]
[numerics]
transfer = "aflip"
relaxation_cells = 1.5
contact = "nodal"
[output]
duration_s = 1.0
)";

inline const std::string ground_case = R"([material]
model = "hencky_elastic"
[[body]]
min_m = [-1.0, -1.0, 0.0]
max_m = [1.0, 1.0, 1.0]
[terrain]
raster = "ncols 3 nrows 2 xllcenter -5 yllcenter -5 cellsize 10 0.5 0 0 0 0 0.25"
contact = "slip"
friction = 0.2
surface_speed_m_s = 1.5
[domain]
min_m = [-5.0, -5.0, -1.0]
max_m = [5.0, 5.0, 6.0]
[output]
duration_s = 1.0
)";

inline const std::string small_scene = R"([[body]]
min_m = [0, 0, 0]
max_m = [1, 1, 1]
[domain]
min_m = [0, 0, 0]
max_m = [1, 1, 1]
[output]
duration_s = 1
)";

inline const std::string sand_case = R"([material]
model = "drucker_prager"
cone_matching = "simple_shear"
friction_angle_deg = 20.9
cohesion_pa = 10.0
dilatancy_angle_deg = 0.0
limit_friction_angle_deg = 32.76
reference_inertial_number = 0.279
grain_diameter_m = 0.53e-3
grain_density_kg_m3 = 2450.0
)" + small_scene;

inline const std::string water_case = R"([material]
model = "weakly_compressible_fluid"
bulk_modulus_pa = 2e5
tait_exponent = 3
viscosity_pa_s = 0.5
carries_tension = true
)" + small_scene;
/// @}

/// The message with which a case is refused; empty where it is accepted.
inline std::string message_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    (void)parse_case(text, "case.toml", overrides);
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  return "";
}

/// The lines of a text.
inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// A case for every law, with every parameter that the law has.
inline std::vector<std::string> law_cases() {
  std::vector<std::string> cases;
  for (const MaterialParameters& material : typical_materials()) {
    Case c = parse_case("[material]\nmodel = \"hencky_elastic\"\n" + small_scene, "small.toml");
    c.material = material;
    cases.push_back(write_case(c));
  }
  return cases;
}

/// One line of the message begins with `place` and holds all of `words`.
inline ::testing::AssertionResult reports(const std::string& message, const std::string& place, const std::vector<std::string>& words) {
  for (const std::string& line : lines_of(message)) {
    const bool all = std::all_of(words.begin(), words.end(), [&](const std::string& w) { return line.find(w) != std::string::npos; });
    if (line.starts_with(place) && all) return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure() << "no line at " << place << "with these words in:\n" << message;
}

}  // namespace mpm::testing
