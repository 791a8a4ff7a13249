#include "libmpm/impact/grid_uncertainty.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

#include "libmpm/boundary/obstacle_spec.hpp"

namespace mpm {
namespace {

GridResolution nodal(double cells) { return {.cells = cells, .width_excess = nodal_width_ratio(cells) - 1.0}; }
GridResolution surface(double cells) { return {.contact = ContactRule::surface, .transfer = Transfer::aflip, .cells = cells}; }

TEST(KnownGridUncertainty, CoversTheLimitOnTheGridsThatWereStudied) {
  // validation/cases/avalanche_convergence: force in kN, limit 124; run-up over H, limit 4.38 (nodal: of the highest particle, 4.7)
  for (const auto& [r, force, runup] : {std::tuple{nodal(3), 199.1, 3.18},
                                        {nodal(5), 160.5, 3.92},
                                        {nodal(7), 148.5, 4.18},
                                        {nodal(4), 208.4, 3.84},
                                        {nodal(12), 148.6, 4.40},
                                        {surface(3), 129.0, 3.98},
                                        {surface(4), 127.7, 4.05},
                                        {surface(5), 127.6, 4.20},
                                        {surface(6), 125.2, 4.31},
                                        {surface(7), 125.9, 4.40},
                                        {surface(8), 124.9, 4.41},
                                        {surface(9), 125.5, 4.39},
                                        {surface(12), 124.5, 4.36}}) {
    const GridUncertainty u = grid_uncertainty(r);
    EXPECT_GE(u.force * force, std::abs(force - 124.0)) << r.cells;
    EXPECT_GE(u.runup * runup, std::abs(runup - (r.contact == ContactRule::surface ? 4.38 : 4.7))) << r.cells;
    EXPECT_LE(u.force * force, std::abs(force - 124.0) + 0.07 * force)
        << "and not much more (3 % of the limit; the force scatters by up to 3 % about it), at " << r.cells;
  }
}

TEST(KnownGridUncertainty, CoversTheFinestGridOfTheStudyOfOtherSnow) {
  // validation/study/rows/grids.csv: value at w/5, w/7, w/10; of fluid and sticky snow by the solver before
  struct Point {
    SnowTraits snow;
    double GridUncertainty::*of;
    std::array<double, 3> value;
  };
  const SnowTraits moderate{}, fluid{.fluid = true}, sticky{.compressible_cohesive = true}, stiff{.stiff = true};
  for (const Point& p : {Point{fluid, &GridUncertainty::runup, {9.44, 9.99, 10.50}},
                         {fluid, &GridUncertainty::force, {93.98, 95.72, 99.44}},
                         {sticky, &GridUncertainty::runup, {2.52, 2.96, 3.2}},
                         {sticky, &GridUncertainty::runup, {3.80, 4.67, 4.66}},
                         {sticky, &GridUncertainty::pressure_height, {1.91, 1.98, 2.06}},
                         {sticky, &GridUncertainty::pressure_height, {1.80, 1.89, 1.99}},
                         {moderate, &GridUncertainty::pressure_height, {3.425, 3.451, 3.641}},
                         {moderate, &GridUncertainty::pressure_height, {3.134, 3.160, 3.228}},
                         {moderate, &GridUncertainty::force, {37.98, 37.07, 36.31}},
                         {moderate, &GridUncertainty::force, {330.8, 326.4, 322.0}},
                         {moderate, &GridUncertainty::force, {298.4, 293.7, 297.8}},
                         {stiff, &GridUncertainty::runup, {5.713, 6.346, 6.614}},
                         {stiff, &GridUncertainty::runup, {6.236, 6.532, 5.912}},
                         {stiff, &GridUncertainty::runup, {4.627, 4.471, 4.772}},
                         {stiff, &GridUncertainty::pressure_height, {3.421, 3.526, 4.107}},
                         {stiff, &GridUncertainty::pressure_height, {3.319, 3.487, 3.928}},
                         {stiff, &GridUncertainty::force, {476.9, 466.2, 530.4}},
                         {stiff, &GridUncertainty::force, {535.7, 542.5, 565.9}}}) {
    for (const auto& [i, cells] : {std::pair{0, 5.0}, {1, 7.0}, {2, 10.0}}) {
      GridResolution r = surface(cells);
      r.snow = p.snow;
      const double value = p.value[static_cast<std::size_t>(i)], uncertainty = grid_uncertainty(r).*p.of;
      EXPECT_GE(uncertainty * value, std::abs(p.value[2] - value)) << cells << " cells, " << p.value[2];
      EXPECT_GE(uncertainty, grid_uncertainty(surface(cells)).*p.of);
    }
  }
}

TEST(KnownGridUncertainty, IsAtLeastThatOfTheSnowAlsoOnNodes) {
  GridResolution r = nodal(7);
  const double before = grid_uncertainty(r).runup;
  r.snow.fluid = true;
  EXPECT_GT(grid_uncertainty(r).runup, before);
  EXPECT_EQ(grid_uncertainty(r).moment, grid_uncertainty(r).force + grid_uncertainty(r).pressure_height);
  r.cells = 2.0;
  EXPECT_TRUE(std::isnan(grid_uncertainty(r).runup)) << "nothing is known";
}

TEST(KnownGridUncertainty, IsTheLargestOfAllThatSlowsTheConvergence) {
  GridResolution r = surface(5), sticky = r, stiff = r;
  r.snow = {.compressible_cohesive = true, .stiff = true};
  sticky.snow.compressible_cohesive = true;
  stiff.snow.stiff = true;
  EXPECT_EQ(grid_uncertainty(r).runup, grid_uncertainty(sticky).runup);
  EXPECT_EQ(grid_uncertainty(r).pressure_height, grid_uncertainty(stiff).pressure_height);
  EXPECT_EQ(grid_uncertainty(r).force, grid_uncertainty(stiff).force);
  EXPECT_GT(grid_uncertainty(sticky).runup, grid_uncertainty(stiff).runup);
}

TEST(KnownGridUncertainty, FallsWithRefinementToTheUncertaintyOfTheLimit) {
  for (double cells = 7.0; cells < 40.0; cells += 2.0) {
    EXPECT_LT(grid_uncertainty(nodal(cells + 2.0)).force, grid_uncertainty(nodal(cells)).force);
    EXPECT_LT(grid_uncertainty(nodal(cells + 2.0)).runup, grid_uncertainty(nodal(cells)).runup);
  }
  EXPECT_NEAR(grid_uncertainty(nodal(1e5 + 1)).force, 0.03, 1e-4);
}

TEST(KnownGridUncertainty, IsUnknownBelowThreeCells) {
  EXPECT_TRUE(std::isnan(grid_uncertainty(nodal(2.9)).force));
  EXPECT_TRUE(std::isnan(grid_uncertainty(surface(0.0)).runup));
}

TEST(KnownGridUncertainty, IsLargerForTheForceOnARoundMast) {
  GridResolution round = surface(8);
  round.front = Front::round;
  EXPECT_GT(grid_uncertainty(round).force, grid_uncertainty(surface(8)).force);
  EXPECT_EQ(grid_uncertainty(round).runup, grid_uncertainty(surface(8)).runup);
}

TEST(KnownGridUncertainty, OfTheHighestParticleIsUnknownOnASmoothMast) {
  GridResolution smooth = surface(7);
  smooth.smooth = true;
  EXPECT_TRUE(std::isnan(grid_uncertainty(smooth).highest_particle)) << "8.3 H at w/12, and rising";
  EXPECT_EQ(grid_uncertainty(smooth).runup, grid_uncertainty(surface(7)).runup);
  EXPECT_EQ(grid_uncertainty(surface(7)).highest_particle, grid_uncertainty(surface(7)).runup);
  smooth.snow.fluid = true;
  EXPECT_FALSE(std::isnan(grid_uncertainty(smooth).highest_particle)) << "a fountain, which was studied on smooth masts";
}

TEST(KnownGridUncertainty, IsUnknownForAShapeLikeNoneThatWasStudied) {
  GridResolution other = surface(8);
  other.front = Front::other;
  const GridUncertainty u = grid_uncertainty(other);
  EXPECT_TRUE(std::isnan(u.force) && std::isnan(u.runup) && std::isnan(u.pressure_height) && std::isnan(u.moment));
}

TEST(KnownGridUncertainty, IsLookedUpByTheFrontOfBoxCylinderAndWedge) {
  EXPECT_EQ(ObstacleSpec{.shape = BoxShape{}}.front(), Front::plane);
  EXPECT_EQ(ObstacleSpec{.shape = CylinderShape{}}.front(), Front::round);
  EXPECT_EQ(ObstacleSpec{.shape = WedgeShape{}}.front(), Front::edge);
}

TEST(RowsOfNodesOnAnObstacle, MakeItOneCellWiderWhereTheirNumberIsEven) {
  EXPECT_NEAR(nodal_width_ratio(5.0), 1.0, 1e-12);
  EXPECT_NEAR(nodal_width_ratio(6.0), 7.0 / 6.0, 1e-12);
  EXPECT_NEAR(nodal_width_ratio(3.2), 3.0 / 3.2, 1e-12);
}

}  // namespace
}  // namespace mpm
