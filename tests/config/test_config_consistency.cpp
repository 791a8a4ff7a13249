/// Cases whose keys are each right and do not go together.

#include "libmpm/driver/case_file.hpp"

#include <gtest/gtest.h>

#include "support/case_texts.hpp"

namespace mpm {
namespace {

using testing::arm_case;
using testing::hand_case;
using testing::lines_of;
using testing::message_of;
using testing::reports;
using testing::sand_case;
using testing::small_scene;
using testing::strip_case;
using testing::window_case;

const std::string single_bracket_case = "[material]\nmodel = \"hencky_elastic\"\n[body]" + small_scene.substr(small_scene.find('\n'));

struct BadCase {
  std::string name;
  std::string base;
  std::vector<std::string> overrides;
  std::vector<std::string> words;
};

std::ostream& operator<<(std::ostream& out, const BadCase& bad) { return out << bad.name; }

class Inconsistent : public ::testing::TestWithParam<BadCase> {};

TEST_P(Inconsistent, CaseIsRefusedWithOneLine) {
  const BadCase& bad = GetParam();
  const std::string message = message_of(bad.base, bad.overrides);
  EXPECT_TRUE(reports(message, "", bad.words));
  EXPECT_EQ(lines_of(message).size(), 1u) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Config, Inconsistent,
    ::testing::Values(
        BadCase{"law_without_the_key",
                hand_case,
                {"material.hardening_xi=5"},
                {"hardening_xi is used with model = \"cohesive_cam_clay\" only"}},
        BadCase{"dilatancy_above_friction",
                "[material]\nmodel = \"drucker_prager\"\nfriction_angle_deg = 30\ndilatancy_angle_deg = 31\n" + small_scene,
                {},
                {"[material] dilatancy_angle_deg is above friction_angle_deg", "give at most that"}},
        BadCase{"dilatancy_with_rate_dependence",
                sand_case,
                {"material.dilatancy_angle_deg=1"},
                {"dilatancy_angle_deg is given beside limit_friction_angle_deg"}},
        BadCase{"limit_below_friction", sand_case, {"material.limit_friction_angle_deg=20"}, {"is below friction_angle_deg"}},
        BadCase{"three_of_four_rate_keys",
                "[material]\nmodel = \"drucker_prager\"\nfriction_angle_deg = 30\nlimit_friction_angle_deg = 33\n"
                "reference_inertial_number = 0.3\ngrain_diameter_m = 0.001\n" +
                    small_scene,
                {},
                {"grain_density_kg_m3 is missing beside limit_friction_angle_deg"}},
        BadCase{"flip_ratio_with_apic", window_case, {"numerics.transfer=apic"}, {"flip_ratio is used with transfer = \"flip\" only"}},
        BadCase{"friction_on_a_no_slip_wall", hand_case, {"wall[0].contact=no_slip"}, {"[wall[0]] friction is used with contact"}},
        BadCase{"sidewall_friction_without_coulomb", window_case, {"conveyor.sidewall_contact=slip"}, {"sidewall_friction is used with"}},
        BadCase{"coulomb_without_friction", strip_case, {"conveyor.sidewall_contact=coulomb"}, {"sidewall_friction is missing"}},
        BadCase{"strip_with_a_window_length",
                strip_case,
                {"conveyor.upstream_length_m=8"},
                {"upstream_length_m is used with feed = \"window\" only"}},
        BadCase{"offset_moves_the_mirror",
                strip_case,
                {"numerics.grid_offset_cells=[0, 0.5, 0]"},
                {"[numerics] grid_offset_cells shifts the mirror plane y = 0 off the grid by 0.5 cells in y", "give 0 there"}},
        BadCase{"filter_of_half_bins",
                strip_case,
                {"measurement.filter_length_m=1.7", "measurement.bin_height_m=0.125"},
                {"[measurement] filter_length_m = 1.7 is 13.6 bins of 0.125 m; give an odd number of bins", "such as 1.625 m"}},
        BadCase{"filter_of_even_bins", strip_case, {"measurement.filter_length_m=1.5"}, {"is 12 bins of 0.125 m"}},
        BadCase{"filter_of_one_bin", strip_case, {"measurement.filter_length_m=0.125"}, {"is 1 bin of", "at least 3", "such as 0.375 m"}},
        BadCase{"measurement_without_an_impact",
                hand_case,
                {"measurement.box_upstream_m=0.5"},
                {"[measurement] box_upstream_m is used with [conveyor] and [obstacle] only"}},
        BadCase{"mirror_with_a_conveyor", strip_case, {"domain.mirror=[\"y\"]"}, {"mirror is used with no [conveyor] only"}},
        BadCase{"body_with_a_conveyor",
                strip_case + "[[body]]\nmin_m = [-4, 0, 0]\nmax_m = [-3, 1, 1]\n",
                {},
                {"[body[0]] is given beside [conveyor]"}},
        BadCase{"wall_with_a_conveyor",
                strip_case + "[[wall]]\npoint_m = [0, 0, 0]\nnormal = [0, 0, 1]\n",
                {},
                {"[wall[0]] is given beside [conveyor]"}},
        BadCase{"body_upside_down", hand_case, {"body[0].max_m=[1, 1, -1]"}, {"--set body[0].max_m", "max_m is not above min_m in z"}},
        BadCase{
            "body_thinner_than_a_particle", hand_case, {"body[1].max_m=[3, 3, 0.01]"}, {"less than the distance of particles, 0.125 m"}},
        BadCase{"body_outside_the_domain", hand_case, {"body[1].max_m=[3, 3, 7]"}, {"lies outside [domain]"}},
        BadCase{"body_in_the_obstacle", hand_case, {"obstacle.depth_m=1"}, {"reach into the obstacle"}},
        BadCase{"underside_above_the_top",
                window_case,
                {"obstacle.height_m=2", "obstacle.base_m=2"},
                {"[obstacle] base_m is not below height_m, the top"}},
        BadCase{"arm_without_an_obstacle",
                sand_case,
                {"arm.length_m=4", "arm.depth_m=1.5", "arm.base_m=2", "arm.height_m=3"},
                {"[arm] is given without"}},
        BadCase{"arm_within_the_obstacle", arm_case, {"arm.length_m=1.7"}, {"length_m = 1.7 does not reach"}},
        BadCase{"arm_in_the_side_walls", arm_case, {"arm.length_m=20.5"}, {"length_m = 20.5 reaches the side walls"}},
        BadCase{"arm_before_the_obstacle", arm_case, {"arm.depth_m=1.6"}, {"depth_m = 1.6 reaches upstream", "at most 1.5 m"}},
        BadCase{"arm_above_the_obstacle",
                arm_case,
                {"arm.base_m=10", "arm.height_m=11"},
                {"base_m = 10 is not below the top of the obstacle, 10 m"}},
        BadCase{"arm_upside_down", arm_case, {"arm.base_m=3"}, {"[arm] base_m is not below height_m"}},
        BadCase{"domain_upside_down", hand_case, {"domain.min_m=[6, -5, -1]"}, {"[domain] max_m is not above min_m in x"}},
        BadCase{
            "slope_across_a_mirror_plane", hand_case, {"domain.mirror=[\"x\"]", "numerics.slope_deg=5"}, {"across the mirror plane x = 0"}},
        BadCase{"wall_across_a_mirror_plane",
                hand_case,
                {"domain.mirror=[\"y\"]", "wall[0].velocity_m_s=[0, 1, 0]"},
                {"wall[0]] velocity_m_s moves across the mirror plane y = 0"}},
        BadCase{"normal_zero", hand_case, {"wall[0].normal=[0, 0, 0.0]"}, {"normal = [0, 0, 0] has no direction"}},
        BadCase{"mast_as_wide_as_the_belt",
                window_case,
                {"obstacle.width_m=20.5"},
                {"obstacle] width_m = 20.5 leaves no room on the belt, 20.5 m wide"}},
        BadCase{"outlet_in_the_mast",
                window_case,
                {"conveyor.downstream_length_m=1.4"},
                {"downstream_length_m = 1.4 ends inside the obstacle"}},
        BadCase{"inlet_at_the_mast", window_case, {"conveyor.upstream_length_m=0.9"}, {"upstream_length_m = 0.9 leaves no room"}},
        BadCase{"front_longer_than_the_window",
                window_case,
                {"conveyor.front_angle_deg=10"},
                {"front_angle_deg = 10 makes a front 9.925 m long, of which the window has 8 m"}},
        BadCase{"flow_thinner_than_a_cell", window_case, {"numerics.cell_size_m=1.8"}, {"flow_height_m = 1.75 is less than one cell"}},
        BadCase{"conveyor_without_gravity", window_case, {"numerics.gravity_m_s2=0"}, {"gravity_m_s2 = 0 is given beside [conveyor]"}},
        BadCase{"speed_without_gravity", strip_case, {"numerics.gravity_m_s2=0"}, {"gravity_m_s2 = 0 is given beside [conveyor]"}},
        BadCase{"overlapping_bodies", hand_case, {"body[1].min_m=[0.5, 0.5, 0.5]"}, {"body[1]", "overlaps body[0]"}},
        BadCase{"other_format", window_case, {"format_version=2"}, {"format_version = 2 is out of range; give one of 1"}},
        BadCase{"single_bracket_body", single_bracket_case, {}, {"case.toml:3:", "body is a single table; write [[body]]"}},
        BadCase{"override_without_value", strip_case, {"numerics.cfl"}, {"--set numerics.cfl: not understood"}},
        BadCase{"override_beyond_the_last_body", hand_case, {"body[2].shape=box"}, {"there is no body[2]; the file has 2"}},
        BadCase{"override_without_index", hand_case, {"body.shape=box"}, {"body is repeated; give its number, e.g. body[0]"}},
        BadCase{"override_of_a_list_entry", hand_case, {"body[0]=3"}, {"only a whole key can be replaced"}},
        BadCase{"override_of_a_key_as_table", strip_case + "", {"output.duration_s.x=3"}, {"duration_s is no table"}},
        BadCase{
            "override_misspelt", strip_case, {"numerics.cell_siz_m=0.5"}, {"--set numerics.cell_siz_m=0.5: ", "did you mean cell_size_m?"}},
        BadCase{"first_row_after_the_end",
                strip_case,
                {"output.series_per_second=1e-6"},
                {"series_per_second = 1e-06 has its first row long after output.duration_s"}},
        BadCase{"domain_within_the_belt", window_case, {"domain.max_m=[1000, 3, 1000]"}, {"max_m cuts off a part of the flow", "m in y"}},
        BadCase{
            "domain_above_the_ground", window_case, {"domain.min_m=[-1000, -1000, 1]"}, {"min_m cuts off a part of the flow", "m in z"}},
        BadCase{"snow_too_soft", window_case, {"material.young_modulus_pa=1"}, {"[material", "cannot carry its own weight"}},
        BadCase{"bins_too_high", strip_case, {"measurement.bin_height_m=100"}, {"bin_height_m is too large for a flow height of 1.75 m"}},
        BadCase{"cells_too_large_to_measure", strip_case, {"numerics.cell_size_m=1.5"}, {"cell_size_m is too large for a flow height"}},
        BadCase{"override_two_values", strip_case, {"numerics.cfl=0.5\nx = 3"}, {"more than one value"}}),
    [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace mpm
