#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

constexpr const char* avalanche = R"(
[material]
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 5.0
[conveyor]
froude_number = 1.0
mirror_y = false
[obstacle]
[output]
duration_s = 1.0
)";

Case with(const std::vector<std::string>& overrides) { return parse_case(avalanche, "case.toml", overrides); }

std::string message_of(const std::vector<std::string>& overrides) {
  try {
    (void)with(overrides);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(ObstacleKeys, ReadEachShapeAndWriteItBack) {
  for (const testing::TypicalShape& typical : testing::typical_shapes()) {
    const std::string name(std::visit([](const auto& shape) { return shape.name; }, typical.shape));
    Case c = with({"obstacle.shape=" + name});
    EXPECT_EQ(c.obstacle->shape.index(), typical.shape.index());
    c.obstacle->shape = typical.shape;
    EXPECT_EQ(parse_case(write_case(c), "again.toml"), c) << typical.name;
  }
  EXPECT_EQ(with({"obstacle.shape=wedge", "obstacle.width_m=2", "obstacle.depth_m=1.5"}).obstacle->shape,
            AnyShape(WedgeShape{.width = 2.0, .depth = 1.5}));
  EXPECT_EQ(with({"obstacle.shape=cylinder"}).obstacle->shape, AnyShape(CylinderShape{}));
  EXPECT_EQ(with({"obstacle.shape=wedge"}).obstacle->shape, AnyShape(WedgeShape{}));
  EXPECT_NEAR(with({"obstacle.rotation_deg=30"}).obstacle->as<BoxShape>().rotation, std::numbers::pi / 6.0, 1e-15);
}

TEST(ObstacleKeys, KeepTheHashOfCasesThatDoNotUseThem) {
  for (const char* line : {"\nrotation_deg = 0.0\n", "\nforce_window_s = 0.1\n"})
    EXPECT_THAT(write_case(with({})), ::testing::HasSubstr(line));
  EXPECT_EQ(case_value(with({}), "obstacle.rotation_deg"), "0.0");
  EXPECT_EQ(case_hash(with({})), case_hash(with({"obstacle.rotation_deg=0", "measurement.force_window_s=0.1"})));
  EXPECT_NE(case_hash(with({})), case_hash(with({"obstacle.rotation_deg=1"})));
  EXPECT_NE(case_hash(with({})), case_hash(with({"obstacle.shape=cylinder"})));
  EXPECT_NE(case_hash(with({})), case_hash(with({"measurement.force_window_s=0.2"})));
}

TEST(ObstacleKeys, ATurnedBoxMeetsTheFlowWithAnEdgeUnlessItIsOnItsSide) {
  for (const auto& [degrees, front] :
       {std::pair{0, Front::plane}, {90, Front::plane}, {-90, Front::plane}, {45, Front::edge}, {10, Front::edge}})
    EXPECT_EQ(with({fmt::format("obstacle.rotation_deg={}", degrees)}).obstacle->front(), front) << degrees;
  EXPECT_EQ(with({"obstacle.width_m=2", "obstacle.depth_m=1", "obstacle.rotation_deg=90"}).obstacle->width(), 1.0);
}

TEST(ObstacleKeys, AnArmMayBeAsDeepAsItsMast) {
  for (const char* depth : {"0.5", "1", "1.2", "2"}) {
    const auto key = [&](const char* name) { return std::string(name) + "=" + depth; };
    EXPECT_EQ(message_of({key("obstacle.width_m"), key("obstacle.depth_m"), key("arm.depth_m"), "arm.length_m=4", "arm.base_m=2",
                          "arm.height_m=3"}),
              "");
  }
}

TEST(ObstacleKeys, FrictionAsAShareOfTheSnowsOwn) {
  // M = 1.2, beta = 0.3: M' = 1.2 x 1.3 / (0.7 sqrt(1.6)) = 1.76184; sin phi' = 3 M' / (M' + 6) = 0.68096, tan phi' = 0.92988
  const Case snow = with({"obstacle.friction_ratio=0.5", "material.critical_state_slope=1.2", "material.cohesion_beta=0.3"});
  EXPECT_NEAR(snow.obstacle->friction, 0.46494, 1e-5);
  EXPECT_EQ(with({"obstacle.friction_ratio=0.5", "material.critical_state_slope=0"}).obstacle->friction, 0.0) << "a fluid slides freely";
  EXPECT_EQ(parse_case(write_case(snow), "again.toml"), snow);
  EXPECT_EQ(case_hash(snow), case_hash(with({fmt::format("obstacle.friction={}", snow.obstacle->friction),
                                             "material.critical_state_slope=1.2", "material.cohesion_beta=0.3"})))
      << "the same case, however its friction was given";
  EXPECT_NE(message_of({"obstacle.friction_ratio=0.5", "obstacle.friction=0.2"}).find("friction_ratio is given beside friction"),
            std::string::npos);

  const auto of_law = [](const std::string& material) {
    std::string text = avalanche;
    const auto from = text.find("critical_state_slope"), to = text.find("[conveyor]");
    return text.replace(from, to - from, material).replace(text.find("[obstacle]"), 10, "[obstacle]\nfriction_ratio = 0.5");
  };
  const Case sand = parse_case(of_law("model = \"drucker_prager\"\nfriction_angle_deg = 30.0\n"), "case.toml");
  EXPECT_NEAR(sand.obstacle->friction, 0.5 / std::sqrt(3.0), 1e-15);
  try {
    (void)parse_case(of_law("model = \"hencky_elastic\"\n"), "case.toml");
    ADD_FAILURE() << "an elastic body has no friction of its own";
  } catch (const ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("friction_ratio is a part of the material's own friction, and \"hencky_elastic\" has none"),
              std::string::npos)
        << e.what();
  }

  std::string text = avalanche;
  text.replace(text.find("[obstacle]"), 10, "[obstacle]\nfriction = 0.1\nfriction_ratio = 0.5");
  EXPECT_THROW((void)parse_case(text, "case.toml"), ConfigError);
  EXPECT_NE(message_of({"obstacle.friction_ratio=0.5", "material.critical_state_slope=5"}).find("makes a friction of inf"),
            std::string::npos);
  EXPECT_NE(message_of({"obstacle.friction_ratio=1.5"}).find("friction_ratio"), std::string::npos);
}

TEST(ObstacleKeys, AreRefusedWhereTheyMeanNothingOrAreOutOfRange) {
  const auto tells = [](const std::vector<std::string>& keys, const std::string& part) {
    const std::string message = message_of(keys);
    EXPECT_NE(message.find(part), std::string::npos) << "'" << message << "' does not say '" << part << "'";
  };
  tells({"obstacle.shape=cylindre"}, "did you mean \"cylinder\"?");
  tells({"obstacle.rotaton_deg=3"}, "did you mean rotation_deg?");
  tells({"obstacle.rotation_deg=91"}, "out of range");
  tells({"measurement.force_window_s=0"}, "out of range");
  tells({"obstacle.shape=cylinder", "obstacle.depth_m=2"}, "depth_m is used with shape = \"box\" or \"wedge\" only");
  tells({"obstacle.shape=wedge", "obstacle.rotation_deg=20"}, "rotation_deg is used with shape = \"box\" only");
  tells({"obstacle.rotation_deg=20", "conveyor.mirror_y=true"}, "not symmetric about y = 0");
  const std::string near = "conveyor.downstream_length_m=4";
  tells({near, "obstacle.rotation_deg=45", "obstacle.width_m=3", "obstacle.depth_m=3"},
        "ends inside the obstacle; give at least its depth, 4.24264 m");
  tells({near, "obstacle.shape=cylinder", "obstacle.width_m=4.1"}, "ends inside the obstacle; give at least its depth, 4.1 m");
  tells({"obstacle.rotation_deg=45", "conveyor.width_m=2"}, "leaves no room on the belt");
  EXPECT_EQ(message_of({"obstacle.rotation_deg=45", "conveyor.mirror_y=true"}), "") << "a square on its edge is symmetric";
  EXPECT_EQ(message_of({"obstacle.shape=wedge", "conveyor.mirror_y=true"}), "");
}

TEST(InflowKeys, ReadATableAndWriteItBack) {
  const std::string text = std::string(avalanche) + R"(
[[conveyor.inflow]]
time_s = 0.0
velocity_m_s = 3.0
[[conveyor.inflow]]
time_s = 2
flow_height_m = 2.5
density_ratio = 1.1
)";
  const Case c = parse_case(text, "case.toml");
  ASSERT_EQ(c.conveyor->inflow.size(), 2u);
  EXPECT_EQ(c.conveyor->inflow[0].velocity, 3.0);
  EXPECT_FALSE(c.conveyor->inflow[0].flow_height);
  EXPECT_EQ(c.conveyor->inflow[1].time, 2.0);
  EXPECT_EQ(c.conveyor->inflow[1].flow_height, 2.5);
  EXPECT_EQ(c.conveyor->inflow[1].density_ratio, 1.1);
  EXPECT_EQ(parse_case(write_case(c), "again.toml"), c);
  EXPECT_NE(case_hash(c), case_hash(with({})));

  const auto tells = [&](const std::vector<std::string>& keys, const std::string& part) {
    std::string message;
    try {
      (void)parse_case(text, "case.toml", keys);
    } catch (const ConfigError& e) {
      message = e.what();
    }
    EXPECT_NE(message.find(part), std::string::npos) << "'" << message << "' does not say '" << part << "'";
  };
  tells({"conveyor.inflow[1].time_s=0"}, "is not above that of the row before, 0; sort the rows");
  tells({"conveyor.inflow[1].density_ratio=0.9"}, "out of range");
  tells({"conveyor.inflow[1].velocity_m_s=0"}, "out of range");
  tells({"conveyor.inflow[1].flow_height_m=0.1"}, "less than one cell");
  tells({"conveyor.inflow[1].velocty_m_s=1"}, "did you mean velocity_m_s?");
  tells({"conveyor.feed=strip"}, "is given beside feed = \"strip\"");
  tells({"conveyor.inflow_slip_ratio=0.5", "conveyor.sidewall_contact=slip"}, "is given beside inflow_slip_ratio");
}

TEST(InflowKeys, OfShearAreReadWithSlippingSideWallsOnly) {
  const Case c = with({"conveyor.inflow_slip_ratio=0.25", "conveyor.inflow_shear_exponent=0.5", "conveyor.sidewall_contact=slip"});
  EXPECT_EQ(c.conveyor->slip_ratio, 0.25);
  EXPECT_EQ(c.conveyor->shear_exponent, 0.5);
  EXPECT_EQ(parse_case(write_case(c), "again.toml"), c);
  EXPECT_EQ(case_hash(with({})), case_hash(with({"conveyor.inflow_slip_ratio=1"})));
  const auto tells = [](const std::vector<std::string>& keys, const std::string& part) {
    const std::string message = message_of(keys);
    EXPECT_NE(message.find(part), std::string::npos) << "'" << message << "' does not say '" << part << "'";
  };
  tells({"conveyor.inflow_slip_ratio=0.5"}, "give sidewall_contact = \"slip\"");
  tells({"conveyor.inflow_slip_ratio=1.5"}, "out of range");
  tells({"conveyor.inflow_shear_exponent=2"}, "is used with inflow_slip_ratio below 1 only");
  tells({"conveyor.inflow_slip_ratio=0.5", "conveyor.inflow_shear_exponent=0", "conveyor.sidewall_contact=slip"}, "out of range");
  tells({"conveyor.feed=strip", "conveyor.inflow_slip_ratio=0.5"}, "is used with feed = \"window\" only");
}

}  // namespace
}  // namespace mpm
