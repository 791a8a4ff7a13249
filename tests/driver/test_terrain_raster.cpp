/// [terrain]: rasters of uneven ground in a case.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/terrain_raster.hpp"
#include "support/ground.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using ::testing::AllOf;
using testing::ground_points;
using ::testing::HasSubstr;

/// Waves of up to 17 degrees over 14 m x 14 m.
double relief(double x, double y) { return 0.3 * std::sin(0.7 * x) * std::cos(0.7 * y) + 0.1; }

class TerrainFiles : public ::testing::Test {
 protected:
  /// A case with this file beside it. @param name  of the file; @param more  further tables
  Case read(const std::string& name, const std::string& content, const std::string& more = conveyor) {
    std::ofstream(directory_ / name) << content;
    std::ofstream(directory_ / "case.toml") << "[material]\ncritical_state_slope = 0.4\ncohesion_beta = 0\nhardening_xi = 5\n"
                                               "[terrain]\nfile = \"" +
                                                   name + "\"\n" + more + "[output]\nduration_s = 4\n";
    return read_case(directory_ / "case.toml");
  }
  std::string message(const std::string& name, const std::string& content, const std::string& more = conveyor) {
    try {
      (void)read(name, content, more);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  static inline const std::string conveyor =
      "[conveyor]\nvelocity_m_s = 10\nwidth_m = 6\nupstream_length_m = 4\ndownstream_length_m = 3\nmirror_y = false\n"
      "sidewall_contact = \"slip\"\n[obstacle]\n";
  static inline const std::string by_hand =
      "[[body]]\nmin_m = [-1, -1, 0]\nmax_m = [1, 1, 1]\n[domain]\nmin_m = [-5, -5, -2]\nmax_m = [5, 5, 6]\n";
  testing::TemporaryDirectory directory_;
};

std::string esri(const std::string& heights, const std::string& head = "ncols 3\nnrows 2\nxllcenter -7\nyllcenter -7\ncellsize 14\n") {
  return head + heights;
}

TEST(Rasters, AreReadFromTheNorthWithCornersOrCentresAndBlanksOfEveryKind) {
  std::string problem;
  const HeightField::Points centres = parse_raster("NCOLS 3\r\nNROWS 2\nxllcenter 10\nyllcenter 20\ncellsize 2\n4 5 6\n1 2 3\n", problem);
  EXPECT_EQ(problem, "");
  EXPECT_EQ(centres.first, Vec2(10.0, 20.0));
  EXPECT_EQ(centres.height, (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(HeightField(centres).at(Vec2(12.0, 22.0)).height, 5.0);
  const HeightField::Points corners =
      parse_raster("ncols 3 nrows 2 xllcorner 9 yllcorner 19 cellsize 2 nodata_value -1 4 5 6 1 2 3", problem);
  EXPECT_EQ(problem, "");
  EXPECT_EQ(corners, centres);
  const std::string marked = "\xEF\xBB\xBFncols 3 nrows 2 xllcenter 10 yllcenter 20 ";  // a byte-order mark
  EXPECT_EQ(parse_raster(marked + "dx 2 dy 2 4 5 6 1 2 3", problem), centres);          // as GIS programs write it
  EXPECT_EQ(problem, "");
  (void)parse_raster(marked + "dx 2 dy 3 4 5 6 1 2 3", problem);
  EXPECT_EQ(problem, "has cells of 2 x 3; resample it to square ones");
}

TEST(Rasters, AsTextReadBackToTheSameBits) {
  HeightField::Points points = ground_points(relief, 7.0, 0.7);
  points.first = Vec2(0.1, -1.0 / 3.0);
  points.height[5] = -9999.0;  // a height here, no hole
  std::string problem;
  const std::string text = raster_text(points);
  EXPECT_EQ(parse_raster(text, problem), points);
  EXPECT_EQ(problem, "");
  EXPECT_EQ(raster_text(parse_raster(text, problem)), text);
  EXPECT_EQ(text.find('\n'), std::string::npos);
}

TEST_F(TerrainFiles, BecomePartOfTheCaseWhateverTheirFormat) {
  const HeightField::Points points = ground_points(relief, 7.0, 1.0);
  std::string table = "x_m,y_m,z_m\n";
  for (std::size_t n = points.height.size(); n-- > 0;) {  // in any order
    const std::size_t row = n / points.columns, column = n % points.columns;
    table += fmt::format("{},{},{}\n", points.first.x() + static_cast<double>(column), points.first.y() + static_cast<double>(row),
                         points.height[n]);
  }
  const Case grid = read("ground.asc", raster_text(points)), csv = read("ground.csv", table);
  EXPECT_EQ(grid.terrain->raster, raster_text(points));
  EXPECT_EQ(grid.terrain->file, std::nullopt);
  EXPECT_EQ(csv, grid);
  const std::string text = write_case(grid);
  EXPECT_EQ(text.find("ground.asc"), std::string::npos);
  EXPECT_EQ(parse_case(text, "elsewhere/case.toml"), grid);
  EXPECT_EQ(case_hash(csv), case_hash(grid));
}

TEST_F(TerrainFiles, DecideTheHashByTheirContentAndNotByTheirName) {
  HeightField::Points points = ground_points(relief, 7.0, 1.0);
  const Case first = read("a.asc", raster_text(points)), renamed = read("b.asc", raster_text(points));
  EXPECT_EQ(case_hash(first), case_hash(renamed));
  points.height[40] += 1e-9;
  const Case changed = read("a.asc", raster_text(points));
  EXPECT_NE(case_hash(first), case_hash(changed));
  const auto differences = case_differences(first, changed);
  ASSERT_EQ(differences.size(), 1U);
  EXPECT_THAT(differences[0], HasSubstr("terrain.raster was"));
  EXPECT_LT(differences[0].size(), 300U) << "a message, not the rasters";
}

TEST_F(TerrainFiles, ThatAreWrongAreNamedWithPlaceAndRemedy) {
  const std::string flat = "0 0 0\n0 0 0\n";
  EXPECT_THAT(message("g.asc", esri("0 0 0\n0 0\n")),
              AllOf(HasSubstr("case.toml:6"), HasSubstr("g.asc"), HasSubstr("has 5 heights, 3 x 2")));
  EXPECT_THAT(message("g.asc", esri("0 0 0\n0 -9999 0\n")), AllOf(HasSubstr("no height at x = 7, y = -7"), HasSubstr("fill the hole")));
  EXPECT_THAT(message("g.asc", esri("0 0 0\n0 one 0\n")), HasSubstr("has 'one' among its heights"));
  EXPECT_THAT(message("g.asc", ""), HasSubstr("has no ncols in its header"));
  EXPECT_THAT(message("g.asc", esri(flat, "ncols 3\nnrows 2\ncellsize 14\n")), HasSubstr("has no xllcenter"));
  EXPECT_THAT(message("g.asc", esri(flat, "ncols 3\nnrows 2\nxllcenter 0\nyllcenter 0\ncellsize 14\ncellsize 28\n")),
              HasSubstr("has 'cellsize' twice in its header"));
  EXPECT_THAT(message("g.asc", esri(flat, "ncols 3\nnrows many\n")), HasSubstr("'nrows many' is no entry"));
  EXPECT_THAT(message("g.asc", esri(flat, "ncols 3\nnrows 2\nxllcenter 0\nyllcenter 0\ncellsize 0.0001\n")), HasSubstr("degrees"));
  EXPECT_THAT(message("g.asc", esri(flat, "ncols 1e9\nnrows 1e9\nxllcenter 0\nyllcenter 0\ncellsize 1\n")), HasSubstr("at most 250000"));
  EXPECT_THAT(message("g.asc", esri("0 0 0\n0 2e5 0\n")), HasSubstr("height of 2e+05"));
  EXPECT_THAT(message("g.csv", "x_m,z_m\n0,0\n"), HasSubstr("has no column y_m, only 'x_m,z_m'"));
  EXPECT_THAT(message("g.asc", esri("0 0 0\n0 0 0\n", "ncols 3\nnrows 2\nxllcenter 0\nyllcenter 0\ncellsize -1\n")), HasSubstr("above 0"));
  EXPECT_THAT(message("g.csv", "x_m,y_m,z_m\n-7,-7,0\n7,-7,0\n-7,7,0\n5,7,0\n"), HasSubstr("is no regular grid"));
  EXPECT_THAT(message("g.tif", "II*"), HasSubstr("gdal_translate"));
  EXPECT_THAT(message("", ""), HasSubstr("names no file"));
}

TEST_F(TerrainFiles, ThatAreMissingAreNamed) {
  std::ofstream(directory_ / "case.toml")
      << "[material]\ncritical_state_slope = 0.4\ncohesion_beta = 0\nhardening_xi = 5\n[terrain]\nfile = "
         "\"none.asc\"\n" +
             conveyor + "[output]\nduration_s = 4\n";
  try {
    (void)read_case(directory_ / "case.toml");
    FAIL() << "no error";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("none.asc"), HasSubstr("case.toml:6"), HasSubstr("names no file")));
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "one problem, one message";
  }
}

TEST_F(TerrainFiles, HaveToCoverTheDomainAndToBeGentleAndSymmetric) {
  const auto ground = [](auto&& h, double half_width = 7.0) { return raster_text(ground_points(h, half_width, 1.0)); };
  EXPECT_EQ(message("g.asc", ground(relief)), "");
  EXPECT_THAT(message("g.asc", ground(relief, 3.0)), AllOf(HasSubstr("covers x from -3 to 3 m"), HasSubstr("give a larger raster")));
  HeightField::Points far = ground_points(relief, 7.0, 1.0);
  far.first += Vec2(652150.0, 5205030.0);
  EXPECT_THAT(message("g.asc", raster_text(far)), HasSubstr("in the coordinates of the case"));
  const auto steep = [](double x, double) { return x > 0.5 ? 1.0 : 0.0; };
  EXPECT_THAT(message("g.asc", ground(steep)), AllOf(HasSubstr("degrees steep at x = 0.5"), HasSubstr("smooth the raster")));
  const auto altitude = [](double x, double y) { return 1500.0 + relief(x, y); };
  EXPECT_THAT(message("g.asc", ground(altitude)), AllOf(HasSubstr("puts the ground at z = 1500.27 m"), HasSubstr("subtract 1500.27 m")));
  EXPECT_THAT(message("g.asc", ground(altitude), conveyor + "[domain]\nmin_m = [-5, -5, 1400]\nmax_m = [4, 5, 1600]\n"),
              ::testing::Not(HasSubstr("cuts off")))
      << "a domain around the ground is not the problem";
  const auto millimetres = [](double x, double y) { return 1000.0 * relief(x, y); };
  EXPECT_THAT(message("g.asc", ground(millimetres)), HasSubstr("same unit, metres"));
  const std::string half =
      "[conveyor]\nvelocity_m_s = 10\nwidth_m = 6\nupstream_length_m = 4\ndownstream_length_m = 3\n"
      "sidewall_contact = \"slip\"\n[obstacle]\n";
  EXPECT_EQ(message("g.asc", ground(relief), half), "") << "symmetric about y = 0";
  const auto tilted = [](double x, double y) { return relief(x, y) + 0.1 * y; };
  EXPECT_EQ(message("g.asc", ground(tilted)), "");
  EXPECT_THAT(message("g.asc", ground(tilted), half), AllOf(HasSubstr("is not symmetric"), HasSubstr("mirror_y = false")));
  const std::string drags = "[conveyor]\nvelocity_m_s = 10\nwidth_m = 6\nupstream_length_m = 4\ndownstream_length_m = 3\n[obstacle]\n";
  EXPECT_THAT(message("g.asc", ground(relief), drags), HasSubstr("sidewall_contact = \"slip\""));
  EXPECT_EQ(message("g.asc", ground(relief), by_hand), "");
  EXPECT_THAT(message("g.asc", ground(relief, 4.0), by_hand), HasSubstr("or a smaller domain"));
}

TEST_F(TerrainFiles, NeedOneOfFileAndRaster) {
  const auto with = [&](const std::string& keys) {
    try {
      (void)parse_case("[material]\nmodel = \"hencky_elastic\"\n[terrain]\n" + keys + by_hand + "[output]\nduration_s = 1\n", "case.toml");
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(with(""), HasSubstr("[terrain] has no ground; give file or raster"));
  EXPECT_THAT(with("file = \"a.asc\"\nraster = \"ncols 2\"\n"), HasSubstr("leave one out"));
  EXPECT_EQ(with("raster = \"\"\"\nncols 2\nnrows 2\nxllcenter -5\nyllcenter -5\ncellsize 10\n0 0\n0 0\"\"\"\n"), "");
}

// --- scenes --------------------------------------------------------------------------------------------------------------

/// All numbers of a state after some steps.
std::vector<Particle> stepped(const Case& c, int steps) {
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  for (int n = 0; n < steps; ++n) step(state, scene, stable_time_step(state, scene));
  return testing::particles_by_id(state.grid);
}

void expect_same_values(const std::vector<Particle>& a, const std::vector<Particle>& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_FALSE(a.empty());
  for (std::size_t n = 0; n < a.size(); ++n) {
    EXPECT_EQ(testing::position_of(a[n]), testing::position_of(b[n]));
    EXPECT_EQ(testing::velocity_of(a[n]), testing::velocity_of(b[n]));
    EXPECT_EQ(testing::stress_of(a[n]), testing::stress_of(b[n]));
  }
}

TEST(LevelGround, IsTheFloorOfTheConveyorToTheLastBit) {
  for (const ContactRule rule : {ContactRule::surface, ContactRule::nodal}) {
    Case floor = testing::small_avalanche(6.0);
    floor.numerics.contact = rule;
    floor.conveyor->sidewall_contact = Contact::slip;
    floor.conveyor->upstream_length = 1.0;
    Case ground = floor;
    ground.terrain = testing::ground_spec([](double, double) { return 0.0; }, 8.0, 1.0);
    expect_same_values(stepped(ground, 150), stepped(floor, 150));  // at the mast
  }
}

TEST(LevelGround, IsAWallUnderABodyToTheLastBit) {
  for (const ContactRule rule : {ContactRule::surface, ContactRule::nodal}) {
    Case wall = testing::empty_case();
    wall.material = testing::cam_clay_snow(0.8, 0.3);
    wall.numerics.contact = rule;
    wall.numerics.grid_offset = Vec3(0.2, -0.3, 0.4);
    wall.bodies = {testing::box_body({-0.5, -0.5, 0.15}, {0.5, 0.5, 1.15}, {2.0, 1.0, -3.0})};
    Case ground = wall;
    wall.walls = {testing::wall({0.0, 0.0, 0.1}, Vec3::UnitZ(), Contact::separable, 0.4)};
    ground.terrain = testing::ground_spec([](double, double) { return 0.1; }, 20.0, 10.0);
    ground.terrain->friction = 0.4;
    expect_same_values(stepped(ground, 100), stepped(wall, 100));
  }
}

TEST(UnevenGround, CarriesTheSnowOfTheConveyorAtItsHeightAndAlongItsSlope) {
  Case c = testing::small_avalanche(6.0);
  c.conveyor->sidewall_contact = Contact::slip;
  c.conveyor->mirror_y = false;
  const Case level = c;
  c.terrain = testing::ground_spec(relief, 7.0, 0.5);
  const auto field = height_field(*c.terrain);
  const auto there = stepped(c, 0), flat = stepped(level, 0);
  ASSERT_EQ(there.size(), flat.size());
  for (std::size_t n = 0; n < there.size(); ++n) {
    const Vec3 x = testing::position_of(there[n]), v = testing::velocity_of(there[n]);
    const HeightField::Surface ground = field->at(x.head<2>());
    EXPECT_EQ(x.head<2>(), testing::position_of(flat[n]).head<2>());
    EXPECT_NEAR(x.z() - ground.height, testing::position_of(flat[n]).z(), 1e-14);
    EXPECT_NEAR((v - Vec3(6.0, 0.0, 6.0 * ground.slope.x())).norm(), 0.0, 1e-14);
  }
  EXPECT_NEAR(make_scene(c).domain_min.z(), make_scene(level).domain_min.z() + field->lowest(), 1e-14);
}

TEST_F(TerrainFiles, AtTheirAltitudeKeepTheSnowOfABeltWithoutAMast) {
  const std::string ground = raster_text(ground_points([](double x, double y) { return 1500.0 + relief(x, y); }, 7.0, 1.0));
  const std::string belt = conveyor.substr(0, conveyor.find("[obstacle]"));
  const Case c = read("g.asc", ground, belt);
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  const std::size_t before = state.grid.particle_count();
  advance(state, scene, 0.02);
  EXPECT_GE(state.grid.particle_count(), before);
  EXPECT_THAT(message("g.asc", ground, belt + "[domain]\nmin_m = [-100, -100, -100]\nmax_m = [100, 100, 100]\n"),
              HasSubstr("max_m cuts off a part of the flow"));
}

TEST(UnevenGround, LeavesOutWhatABodyWouldHaveBelowIt) {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body({-3.0, -3.0, -1.0}, {3.0, 3.0, 1.0})};
  const std::size_t whole = stepped(c, 0).size();
  c.terrain = testing::ground_spec(relief, 20.0, 0.5);
  const auto field = height_field(*c.terrain);
  const auto particles = stepped(c, 0);
  double above = 0.0;
  for (const Particle& p : particles) {
    EXPECT_GE(p.position[2], field->at({p.position[0], p.position[1]}).height);
    above += p.volume;
  }
  EXPECT_LT(particles.size(), whole);
  EXPECT_NEAR(above, 36.0 * 0.9, 0.02 * 36.0);  // m^3: the ground is at 0.1 m on average; the waves are cut by the body's sides
  c.bodies[0].max.z() = -0.5;
  EXPECT_THROW(stepped(c, 0), ConfigError);  // all below
}

TEST(UnevenGround, ThatHoldsParticlesIsNamed) {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body({-1.0, -1.0, 0.5}, {1.0, 1.0, 1.5})};
  c.terrain = testing::ground_spec([](double, double) { return 0.0; }, 20.0, 10.0);
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  EXPECT_TRUE(particles_inside_boundaries(state, scene).empty());
  state.grid.insert(testing::particle_at({0.1, 0.1, -1.0}, state.next_id++));
  state.grid.refresh();
  EXPECT_THAT(particles_inside_boundaries(state, scene), ::testing::ElementsAre(HasSubstr("inside the [terrain]")));
}

}  // namespace
}  // namespace mpm
