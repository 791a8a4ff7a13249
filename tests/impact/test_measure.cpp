#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/impact/measure.hpp"
#include "libmpm/observe/pressure_profile.hpp"
#include "libmpm/observe/runup.hpp"

namespace mpm {
namespace {

constexpr double H = 1.75, w = 1.75, rho0 = 300.0, g = 9.81;

struct Point {
  Vec3 position;
  double tau_xx, J, mass;
};

/// What both observers measure on the same particles.
struct Measured : FrontPressure {
  double runup, runup_p99;
};
Measured measure(PressureProfile& profile, Runup& runup, const std::vector<Point>& points) {
  for (const Point& p : points) {
    profile.add(p.position, p.tau_xx, p.J, p.mass);
    runup.add(p.position, p.mass);
  }
  const RunupHeights heights = runup.finish();
  return {profile.finish(), heights.highest, heights.p99};
}
Measured measure(const ImpactGeometry& geometry, const std::vector<Point>& points) {
  PressureProfile profile(geometry);
  Runup runup(geometry);
  return measure(profile, runup, points);
}

/// A lattice of eight particles a cell of snow at rest in front of the face, up to the given height, with the Cauchy stress sigma_xx(z).
template <class Stress>
std::vector<Point> lattice(double dx, double height, Stress sigma_xx, bool half = false) {
  std::vector<Point> points;
  const double s = 0.5 * dx;
  for (double x = -4.0 + 0.5 * s; x < 0.0; x += s) {
    for (double y = half ? 0.5 * s : -3.0 + 0.5 * s; y < 3.0; y += s) {
      for (double z = 0.5 * s; z < height; z += s) points.push_back({{x, y, z}, sigma_xx(z), 1.0, rho0 * s * s * s});
    }
  }
  return points;
}

std::vector<double> profile(const ImpactGeometry& geometry, auto pressure) {
  std::vector<double> p;
  for (std::size_t i = 0; i < geometry.profile_bins(); ++i) p.push_back(pressure(geometry.bin_centre(i)));
  return p;
}

TEST(ImpactGeometry, IsThePapersAtItsCellSize) {
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  EXPECT_EQ(geometry.profile_bins(), 70u);
  EXPECT_DOUBLE_EQ(geometry.bin_height, 0.125);
  EXPECT_DOUBLE_EQ(geometry.strip_half_width, 0.75);
  EXPECT_DOUBLE_EQ(geometry.box_upstream, 0.625);
  EXPECT_DOUBLE_EQ(geometry.box_inside, 0.125);
  EXPECT_DOUBLE_EQ(geometry.profile_height, 8.75);
}

TEST(ImpactGeometry, FixedLengthsAreThoseOfThePapersGridWhateverTheObstacle) {
  const auto fixed = paper_geometry(H, 3.5, 0.25, rho0, true);
  EXPECT_DOUBLE_EQ(fixed.bin_height, 0.125);
  EXPECT_DOUBLE_EQ(fixed.filter_bins * fixed.bin_height, 1.625);
  EXPECT_DOUBLE_EQ(fixed.box_upstream, 0.625);
  EXPECT_DOUBLE_EQ(fixed.strip_half_width, 1.5);
}

TEST(ImpactGeometry, RefusesWhatCannotBeMeasured) {
  EXPECT_THROW((void)paper_geometry(0.0, w, 0.25, rho0, false), ConfigError);
  EXPECT_THROW((void)paper_geometry(H, -1.0, 0.25, rho0, false), ConfigError);
  EXPECT_THROW((void)paper_geometry(H, w, std::nan(""), rho0, false), ConfigError);
  EXPECT_THROW((void)paper_geometry(H, w, 0.25, 0.0, false), ConfigError);
  EXPECT_THROW((void)paper_geometry(H, w, H, rho0, false), ConfigError) << "10 bins, the filter needs 13";
}

TEST(ImpactGeometry, WindowsInMetresTakeThePlaceOfThoseInCells) {
  MeasurementSpec windows;
  windows.bin_height = 0.125;
  windows.filter_length = 1.625;
  windows.box_upstream = 0.625;
  windows.box_inside = 0.125;
  const ImpactGeometry fixed = paper_geometry(1.75, 1.75, 0.25, 300.0, true);
  for (const double dx : {1.75 / 3.0, 1.75 / 4.0, 1.75 / 12.0}) {
    const ImpactGeometry measured = paper_geometry(1.75, 1.75, dx, 300.0, true, windows);
    EXPECT_EQ(measured.bin_height, fixed.bin_height);
    EXPECT_EQ(measured.filter_bins, fixed.filter_bins);
    EXPECT_EQ(measured.box_upstream, fixed.box_upstream);
    EXPECT_EQ(measured.box_inside, fixed.box_inside);
  }
  windows = {};
  windows.box_upstream = 0.5;  // one alone leaves the others to the cell size
  const ImpactGeometry partly = paper_geometry(1.75, 1.75, 0.2, 300.0, true, windows);
  EXPECT_EQ(partly.box_upstream, 0.5);
  EXPECT_EQ(partly.bin_height, 0.1);
  windows.filter_length = 1.2;  // twelve bins of 0.1 m
  EXPECT_THROW((void)paper_geometry(1.75, 1.75, 0.2, 300.0, true, windows), ConfigError);
}

TEST(PressureHeight, HasTheKnownBiasOfTheFilter) {
  // Reference: the same profiles smoothed by scipy.signal.savgol_filter(p, 13, 2) (scipy 1.10), crossing by NumPy; printed to 16 digits, so
  // that only round-off of the sums is left. Depth average: rho g H/2 (hydrostatic) and p (uniform).
  struct Case {
    double cell_size, hydrostatic, step;
  };
  for (const auto& c : {Case{0.5, 1.1610182370820668, 1.4183035714285714}, Case{0.35, 1.0898936170212765, 1.2928125},
                        Case{0.25, 1.0424772036474164, 1.2091517857142855}, Case{0.175, 1.013111888111888, 1.1464062499999998}}) {
    const auto geometry = paper_geometry(H, w, c.cell_size, rho0, false);
    const auto hydrostatic = profile(geometry, [](double z) { return rho0 * g * std::max(H - z, 0.0); });
    const auto step = profile(geometry, [](double z) { return z < H ? 5e4 : 0.0; });
    EXPECT_NEAR(pressure_height(hydrostatic, 0.5 * rho0 * g * H, geometry).value() / H, c.hydrostatic, 1e-12) << c.cell_size;
    EXPECT_NEAR(pressure_height(step, 5e4, geometry).value() / H, c.step, 1e-12) << c.cell_size;
  }
}

TEST(PressureHeight, OfAFineHydrostaticProfileIsWhereItPassesTheThreshold) {
  // 5 % of the depth average rho g H/2 is passed at 0.975 H. A window of one bin leaves the profile as it is; it is linear between bins
  // there.
  auto geometry = paper_geometry(H, w, 0.01, rho0, false);
  geometry.filter_bins = 1;
  geometry.filter_order = 0;
  const auto p = profile(geometry, [](double z) { return rho0 * g * std::max(H - z, 0.0); });
  EXPECT_NEAR(pressure_height(p, 0.5 * rho0 * g * H, geometry).value() / H, 0.975, 1e-12);
}

TEST(PressureHeight, DoesNotDependOnTheUnitOfPressure) {
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  const auto pa = profile(geometry, [](double z) { return 1e4 * std::exp(-z); });
  const auto kpa = profile(geometry, [](double z) { return 10.0 * std::exp(-z); });
  EXPECT_NEAR(pressure_height(pa, 5e3, geometry).value(), pressure_height(kpa, 5.0, geometry).value(), 1e-12);
}

TEST(PressureHeight, TakesTheFirstFallGoingUpAndIgnoresWhatFollows) {
  auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  geometry.filter_bins = 1;
  geometry.filter_order = 0;
  // Bins 0.125 m: empty, 1, 1, 0, 1, ...: rises above the threshold first, falls between bins 2 and 3; threshold 0.05 of 1.
  std::vector<double> p(geometry.profile_bins(), 1.0);
  p[0] = p[3] = 0.0;
  EXPECT_NEAR(pressure_height(p, 1.0, geometry).value(), 0.3125 + 0.95 * 0.125, 1e-14);
}

TEST(PressureHeight, IsEmptyOrBoundedWhereItIsNotDefined) {
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  const std::vector<double> none(70, 0.0), all(70, 1.0);
  EXPECT_FALSE(pressure_height(none, 0.0, geometry));
  EXPECT_FALSE(pressure_height(all, -1.0, geometry)) << "tension in the impact box";
  EXPECT_FALSE(pressure_height(none, 1.0, geometry)) << "never above the threshold";
  EXPECT_EQ(pressure_height(all, 1.0, geometry), geometry.profile_height) << "never below: a lower bound";
}

TEST(ImpactMeasurements, MeasuresAHydrostaticColumn) {
  const double dx = 0.25;
  const auto geometry = paper_geometry(H, w, dx, rho0, false);
  const auto frame = measure(geometry, lattice(dx, H, [](double z) { return -rho0 * g * (H - z); }));
  // One lattice plane in each bin, at its centre: the averages are the values there.
  for (std::size_t i = 0; i < 70; ++i) {
    EXPECT_NEAR(frame.pressure[i], rho0 * g * std::max(H - geometry.bin_centre(i), 0.0), 1e-9) << i;  // round-off of sums near 5e3 Pa
  }
  EXPECT_NEAR(frame.impact_pressure, 0.5 * rho0 * g * H, 1e-9);
  EXPECT_NEAR(frame.pressure_height.value() / H, 1.0424772036474164, 1e-12);
  EXPECT_NEAR(frame.runup, H - 0.0625, 1e-12) << "the highest particle's centre";
  EXPECT_NEAR(frame.compaction, 1.0, 1e-12) << "reference density fills the box";
}

TEST(ImpactMeasurements, WeighsStressByTheParticlesVolume) {
  // Eq. A4: tau_xx = J sigma_xx, so that <sigma> = sum J sigma / sum J; here (2 * 100 + 1 * 400) / 3 = 200.
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  const auto frame = measure(geometry, {{{-0.1, 0, 0.3}, -2.0 * 100.0, 2.0, 1.0}, {{-0.1, 0, 0.3}, -1.0 * 400.0, 1.0, 1.0}});
  EXPECT_DOUBLE_EQ(frame.impact_pressure, 200.0);
  EXPECT_DOUBLE_EQ(frame.pressure[2], 200.0);
  EXPECT_DOUBLE_EQ(frame.pressure[1], 0.0);
}

TEST(ImpactMeasurements, CountsNoParticleWithMoreThanACell) {
  const double dx = 0.25, mass = rho0 * dx * dx * dx / 8.0;  // one of eight in a cell
  const auto geometry = paper_geometry(H, w, dx, rho0, false);
  EXPECT_EQ(geometry.counted_ratio(0.5, mass), 0.5);
  EXPECT_EQ(geometry.counted_ratio(7.9, mass), 7.9);
  EXPECT_DOUBLE_EQ(geometry.counted_ratio(1e5, mass), 8.0);
  // so that one that has opened does not take the pressure of a full box away
  auto points = lattice(dx, H, [](double) { return -1e5; });
  points.push_back({{-0.1, 0.0, 0.3}, 0.0, geometry.counted_ratio(1e5, mass), mass});
  EXPECT_NEAR(measure(geometry, points).impact_pressure, 1e5, 1.2e3);  // 8 of 840 volumes
}

TEST(ImpactMeasurements, CountsOnlyTheImpactBox) {
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  const double volume = 1.5 * 0.625 * H;
  const auto one = [&](double x, double y, double z) { return measure(geometry, {{{x, y, z}, -100.0, 1.0, rho0 * volume}}); };
  EXPECT_EQ(one(-0.6, 0.74, 0.5).impact_pressure, 100.0);
  EXPECT_EQ(one(0.12, 0.0, 0.5).impact_pressure, 100.0) << "slightly inside the obstacle";
  EXPECT_EQ(one(0.13, 0.0, 0.5).impact_pressure, 0.0);
  EXPECT_EQ(one(-0.63, 0.0, 0.5).impact_pressure, 0.0);
  EXPECT_EQ(one(-0.1, -0.76, 0.5).impact_pressure, 0.0);
  EXPECT_EQ(one(-0.1, 0.0, 1.76).impact_pressure, 0.0) << "above the flow height";
  EXPECT_EQ(one(-0.1, 0.0, 1.76).pressure[14], 100.0) << "but in the profile";
  EXPECT_EQ(one(-0.1, 0.0, -0.01).pressure[0], 100.0) << "slightly below the floor";
  EXPECT_NEAR(one(-0.1, 0.0, 0.5).compaction, 1.0, 1e-12);
  EXPECT_EQ(one(0.1, 0.0, 0.5).compaction, 0.0) << "compaction leaves out the obstacle";
  EXPECT_EQ(one(-0.1, 0.0, 8.76).runup, 8.76) << "run-up has no upper end";
  EXPECT_EQ(one(-50.0, 0.0, 3.0).runup, 3.0) << "nor an upstream one";
  EXPECT_EQ(one(0.01, 0.0, 3.0).runup, 0.0) << "upstream of the face only";
  EXPECT_EQ(one(-0.1, 0.76, 3.0).runup, 0.0) << "in the strip only";
}

TEST(ImpactMeasurements, PercentileDoesNotDependOnTheLengthOfTheWindow) {
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  std::vector<Point> near, far;
  for (int i = 0; i <= 100; ++i) near.push_back({{-0.01 - 0.0174 * i, 0.0, 0.1 * i}, 0.0, 1.0, 1.0});
  for (int i = 0; i <= 1000; ++i) far.push_back({{-2.0 - 0.01 * i, 0.0, 0.5}, 0.0, 1.0, 1.0});
  EXPECT_NEAR(measure(geometry, near).runup_p99, 9.9, 1e-12) << "heights 0, 0.1 .. 10: the 99th of 100 steps";
  near.insert(near.end(), far.begin(), far.end());
  EXPECT_NEAR(measure(geometry, near).runup_p99, 9.9, 1e-12);
}

TEST(ImpactMeasurements, HalfADomainWithAMirrorMeasuresLikeTheWhole) {
  const auto stress = [](double z) { return -1e4 * std::exp(-z); };
  for (const double dx : {0.25, 0.125}) {
    const auto whole = measure(paper_geometry(H, w, dx, rho0, false), lattice(dx, 3.0, stress));
    const auto half = measure(paper_geometry(H, w, dx, rho0, true), lattice(dx, 3.0, stress, true));
    EXPECT_EQ(whole.runup, half.runup);
    EXPECT_NEAR(whole.runup_p99, half.runup_p99, 0.5 * dx) << "two populations: at most one lattice plane apart";
    EXPECT_NEAR(whole.impact_pressure, half.impact_pressure, 1e-8);  // round-off of sums of 1e4 Pa
    EXPECT_NEAR(whole.compaction, half.compaction, 1e-12);
    EXPECT_NEAR(whole.pressure_height.value(), half.pressure_height.value(), 1e-11);
  }
}

TEST(ImpactMeasurements, AgreesWithAPlainSumOverRandomParticles) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  std::vector<Point> points;
  for (int i = 0; i < 20000; ++i) {
    points.push_back(
        {{-3.0 + 3.5 * u(random), -1.5 + 3.0 * u(random), 10.0 * u(random)}, -1e4 * u(random), 0.5 + u(random), 1.0 + u(random)});
  }
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  const auto frame = measure(geometry, points);
  const auto in_box = [&](const Point& p) { return p.position[0] >= -0.625 && p.position[0] <= 0.125 && std::abs(p.position[1]) <= 0.75; };
  for (std::size_t bin = 0; bin < 70; ++bin) {
    double stress = 0.0, volume = 0.0;
    const double bottom = 0.125 * static_cast<double>(bin);
    for (const Point& p : points) {
      if (in_box(p) && p.position[2] >= bottom && p.position[2] < bottom + 0.125) stress += p.tau_xx, volume += p.J;
    }
    EXPECT_NEAR(frame.pressure[bin], volume > 0.0 ? -stress / volume : 0.0, 1e-8);
  }
  double mass = 0.0, strip = 0.0, below = 0.0;
  for (const Point& p : points) {
    if (in_box(p) && p.position[0] < 0.0 && p.position[2] < H) mass += p.mass;
    if (p.position[0] < 0.0 && p.position[0] >= -H && std::abs(p.position[1]) <= 0.75) {
      strip += p.mass;
      below += p.position[2] < frame.runup_p99 ? p.mass : 0.0;
    }
  }
  EXPECT_NEAR(frame.compaction, mass / (1.5 * 0.625 * H * rho0), 1e-12);
  EXPECT_NEAR(below, 0.99 * strip, 2.0) << "to the mass of one particle, 2 kg at most";
}

TEST(ImpactMeasurements, RunupHolds99PercentOfTheMassWhateverTheNumberOfParticles) {
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  std::vector<Point> points;
  for (int i = 0; i <= 1000; ++i) points.push_back({{-0.1, 0.0, 0.001 * i}, 0.0, 1.0, 1.0});
  for (int i = 0; i < 1000; ++i) points.push_back({{-0.1, 0.0, 5.0}, 0.0, 1.0, 1e-6});
  EXPECT_NEAR(measure(geometry, points).runup_p99, 0.99, 1e-3) << "half of the particles are at 5 m, with a millionth of the mass";
}

TEST(ImpactMeasurements, OneStrayParticleDoesNotMoveTheRunup) {
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  auto points = lattice(0.25, 3.0, [](double) { return 0.0; });
  const auto without = measure(geometry, points);
  points.push_back({{-0.1, 0.0, 30.0}, 0.0, 1.0, points.front().mass});
  const auto with = measure(geometry, points);
  EXPECT_EQ(with.runup, 30.0);
  EXPECT_NEAR(with.runup_p99, without.runup_p99, 1e-12) << "all particles of the lattice's top layer are at one height";
}

TEST(ImpactMeasurements, OnUnevenGroundTheRunupIsThatNearTheObstacle) {
  auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  const std::vector<Point> points = {{{-0.1, 0.0, 2.0}, 0.0, 1.0, 1.0}, {{-5.0 * H, 0.0, 9.0}, 0.0, 1.0, 1.0}};
  EXPECT_EQ(measure(geometry, points).runup, 9.0);
  geometry.uneven_ground = true;
  EXPECT_EQ(measure(geometry, points).runup, 2.0) << "not the hill";
}

TEST(ImpactMeasurements, NothingIsMeasuredAboveTheTopOfALowObstacle) {
  auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  geometry.obstacle.top = 0.6;
  EXPECT_LE(*measure(geometry, lattice(0.25, 3.0, [](double z) { return z < 1.2 ? -1e4 : 0.0; })).pressure_height, 0.6);
  EXPECT_EQ(pressure_height(std::vector<double>(70, 1.0), 1.0, geometry), 0.6);
}

TEST(ImpactMeasurements, StartsAnewAfterEachInstant) {
  const auto geometry = paper_geometry(H, w, 0.25, rho0, false);
  PressureProfile profile(geometry);
  Runup runup(geometry);
  const std::vector<Point> one = {{{-0.1, 0.0, 1.0}, -5e3, 1.0, 10.0}};
  const auto first = measure(profile, runup, one);
  const auto empty = measure(profile, runup, {});
  const auto second = measure(profile, runup, one);
  EXPECT_EQ(empty.runup, 0.0);
  EXPECT_EQ(empty.runup_p99, 0.0);
  EXPECT_EQ(empty.impact_pressure, 0.0);
  EXPECT_EQ(empty.compaction, 0.0);
  EXPECT_FALSE(empty.pressure_height);
  EXPECT_EQ(first.runup, second.runup);
  EXPECT_EQ(first.compaction, second.compaction);
  EXPECT_EQ(first.pressure, second.pressure);
}

}  // namespace
}  // namespace mpm
