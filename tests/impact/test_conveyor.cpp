#include "libmpm/impact/conveyor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "libmpm/base/error.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/driver/case_file.hpp"
#include "support/solver_states.hpp"

namespace mpm {
namespace {

using testing::cam_clay_snow;
using testing::elastic_snow;
using testing::position_of;
using testing::small_avalanche;
using testing::velocity_of;

constexpr double weight = 300.0 * 9.81;  ///< N/m^3

double cauchy_zz(const AnyMaterial& material, const MaterialState<double>& s) {
  return s.stress.zz / std::visit([&](const auto& law) { return law.volume_ratio(s); }, material);
}
double settled_height(const AnyMaterial& material, double height, int count) {
  double sum = 0.0;
  for (const auto& p : settled_column(material, weight, height, count)) {
    sum += height / count * std::visit([&](const auto& law) { return law.volume_ratio(p.state); }, material);
  }
  return sum;
}

TEST(SettledColumn, CarriesItsWeightInEveryLayerWhateverTheLaw) {
  for (const MaterialParameters& spec : {elastic_snow(), cam_clay_snow(0.0, 0.0), cam_clay_snow(0.4, 0.0), cam_clay_snow(0.8, 0.3),
                                         cam_clay_snow(1.2, 0.3), cam_clay_snow(0.8, 0.15, 0.05), cam_clay_snow(0.4, 0.0, 15.0)}) {
    const AnyMaterial material = make_material(spec);
    for (const double height : {1.75, 10.0}) {
      for (const int count : {1, 14, 80}) {
        const auto column = settled_column(material, weight, height, count);
        ASSERT_EQ(column.size(), static_cast<std::size_t>(count));
        double below = 0.0;
        for (int j = 0; j < count; ++j) {
          const auto& point = column[static_cast<std::size_t>(j)];
          const double depth = height - (j + 0.5) * height / count;
          EXPECT_NEAR(cauchy_zz(material, point.state), -weight * depth, 1e-9 * weight * height);  // bisection to the last bits of dl
          EXPECT_EQ(point.state.stress.xx, point.state.stress.yy);
          EXPECT_EQ(point.state.stress.xy, 0.0);
          EXPECT_LE(point.state.stress.xx, 0.0);
          EXPECT_GT(point.height, below);  // from the floor up
          below = point.height;
        }
        EXPECT_LT(below, height);
      }
    }
  }
}

TEST(SettledColumn, SettlesAsTheExactSolutionDoes) {
  // -ln J = W(rho g (H - Z) / E_oed), Lambert's function, with K for E_oed when M = 0: 4.384 mm elastic and 10.684 mm as a fluid for 1.75
  // m. The midpoint sum over 200 layers misses less than 1e-6 of that.
  const AnyMaterial elastic = make_material(elastic_snow());
  MaterialParameters fluid_spec = cam_clay_snow(0.0, 0.0);
  const AnyMaterial fluid = make_material(fluid_spec);
  EXPECT_NEAR(1.75 - settled_height(elastic, 1.75, 200), 4.384e-3, 0.5e-6);  // the printed digits
  EXPECT_NEAR(1.75 - settled_height(fluid, 1.75, 200), 10.684e-3, 0.5e-6);
}

TEST(SettledColumn, HasTheLateralStressOfTheLaw) {
  for (const auto& p : settled_column(make_material(elastic_snow()), weight, 1.75, 14)) {
    EXPECT_NEAR(p.state.stress.xx / p.state.stress.zz, 0.1 / 0.9, 1e-9);  // K0 = nu / (1 - nu); both Kirchhoff
  }
  for (const auto& p : settled_column(make_material(cam_clay_snow(0.0, 0.0)), weight, 1.75, 14)) {
    EXPECT_NEAR(p.state.stress.xx / p.state.stress.zz, 1.0, 1e-9);  // a fluid
  }
}

TEST(SettledColumn, WithoutWeightIsStressFree) {
  const auto column = settled_column(make_material(cam_clay_snow(0.8, 0.3)), 0.0, 2.0, 8);
  for (std::size_t j = 0; j < column.size(); ++j) {
    EXPECT_EQ(column[j].state.stress.zz, 0.0);
    EXPECT_NEAR(column[j].height, 0.25 * (static_cast<double>(j) + 0.5), 1e-14);
  }
}

TEST(SettledColumn, ThatCrushesALayerAtOnceIsUnstable) {
  EXPECT_THROW(settled_column(make_material(elastic_snow()), weight, 1e5, 1), UnstableError);  // 150 MPa on one layer of 1 MPa: J = 0.01
}

/// The window without an obstacle.
Case plug(const MaterialParameters& material, double velocity) {
  Case c = small_avalanche(velocity);
  c.obstacle.reset();
  c.material = material;
  c.conveyor->sidewall_contact = Contact::slip;  // the floor alone carries
  return c;
}

TEST(Conveyor, PlugOfTheBeginningHasItsVolumeMassAndSpeed) {
  for (const bool mirror : {true, false}) {
    Case c = small_avalanche();
    c.conveyor->mirror_y = mirror;
    const CaseScene scene = make_scene(c);
    const State state = make_state(c, scene);
    const Totals t = whole_of_mirrored(totals(state, scene), {mirror, false});
    const double mass = 300.0 * 1.0 * 3.0 * (2.0 + 2.0 * 0.25);  // H W (upstream + two cells of reservoir)
    EXPECT_NEAR(t.mass, mass, 1e-10 * mass);
    for (const Particle& p : testing::stored_particles(state.grid)) {
      EXPECT_EQ(velocity_of(p), Vec3(4.0, 0.0, 0.0));
      EXPECT_LT(p.position[0], 0.0);
    }
    EXPECT_EQ(state.max_speed, 4.0);
    EXPECT_EQ(state.entered.count, 0U);
  }
}

TEST(Conveyor, StripIsAsLongAsThePublishedOne) {
  Case c = small_avalanche();
  c.conveyor->feed = ConveyorSpec::Feed::strip;
  c.output.duration = 2.0;
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  double rear = 0.0;
  for (const Particle& p : testing::stored_particles(state.grid)) rear = std::min(rear, p.position[0]);
  EXPECT_NEAR(rear, -(4.0 * 2.0 + 3.0) + 0.5 * 0.125, 1e-12);  // L = v t + 3 m, half a spacing in from its end
  const auto before = state.grid.particle_count();
  advance(state, scene, 0.02);
  EXPECT_EQ(state.entered.count, 0U);
  EXPECT_EQ(state.grid.particle_count(), before);
}

TEST(Conveyor, StripBeyondTheDefaultDomainIsWhole) {
  const Case c = parse_case(
      "[material]\ncritical_state_slope = 0.4\ncohesion_beta = 0\nhardening_xi = 5\n[conveyor]\nvelocity_m_s = 40\nfeed = "
      "\"strip\"\n[obstacle]\n"
      "[output]\nduration_s = 40\n",
      "strip.toml");
  EXPECT_LT(make_scene(c).domain_min.x(), -1603.0) << "L = v t + 3 m";
}

TEST(Conveyor, FlowIsConstantUntilTheRearOfAStripThinsItOrFromTheLastRowOfAnInflow) {
  ConveyorSpec belt;
  belt.velocity = 4.0;
  belt.flow_height = 1.0;
  EXPECT_EQ(constant_flow(belt, 9.0, 5.0).from, 0.0);
  EXPECT_EQ(constant_flow(belt, 9.0, 5.0).until, std::numeric_limits<double>::infinity());
  belt.upstream_length = 6.0;
  belt.inflow = {{1.0, 4.0, 1.0, 1.0}, {2.0, 3.0, 1.0, 1.0}};
  EXPECT_DOUBLE_EQ(constant_flow(belt, 9.0, 5.0).from, 2.0 + 6.0 / 3.0);
  belt.inflow.clear();
  belt.feed = ConveyorSpec::Feed::strip;
  EXPECT_DOUBLE_EQ(constant_flow(belt, 9.0, 5.0).until, (4.0 * 5.0 + 3.0) / (4.0 + 3.0));
}

/// At t = 0. @param spacing  of the particles, m
std::uint64_t particles_per_layer(const ConveyorSpec& belt, double spacing) {
  const auto count = [&](double length) { return static_cast<std::uint64_t>(std::lround(length / spacing)); };
  return count(belt.flow_height) * count(belt.mirror_y ? 0.5 * belt.width : belt.width);
}

TEST(Conveyor, StaggeredLayersSampleTheCrossSectionEvenly) {
  Case c = plug(elastic_snow(), 4.0);
  c.conveyor->upstream_length = 4.5;
  c.numerics.gravity = 0.0;  // so that heights are not settled
  const CaseScene scene = make_scene(c);
  const auto per_layer = particles_per_layer(*c.conveyor, 0.125);
  const State state = make_state(c, scene);
  const double spacing = 0.125;
  std::set<std::pair<int, int>> met;       // places of a layer within the share of a particle, in a raster of 3 x 3
  std::map<std::uint64_t, double> across;  // y of the first particle of each layer
  for (const Particle& p : testing::stored_particles(state.grid)) {
    ASSERT_GT(p.position[1], 0.0);
    ASSERT_LT(p.position[1], 0.5 * c.conveyor->width);
    ASSERT_GT(p.position[2], 0.0);
    ASSERT_LT(p.position[2], c.conveyor->flow_height);
    if (p.id % per_layer != 0) continue;
    met.emplace(static_cast<int>(3.0 * p.position[1] / spacing), static_cast<int>(3.0 * p.position[2] / spacing));
    across[p.id / per_layer] = p.position[1];
  }
  EXPECT_EQ(state.grid.particle_count() / per_layer, 40U);  // 5 m
  EXPECT_EQ(met.size(), 9U);                                // 40 layers leave none of the nine empty
  for (std::uint64_t layer = 0; layer < across.size(); layer += 2)
    EXPECT_NEAR(across[layer] + across[layer + 1], spacing, 1e-14) << "opposite shifts of layers " << layer << " and the next";
}

TEST(Conveyor, RandomParticlesBringTheMassOfTheLatticeAndKeepTheirDistance) {
  Case c = plug(elastic_snow(), 4.0);
  c.conveyor->lattice = Lattice::random;
  c.conveyor->upstream_length = 7.5;  // and two cells of reservoir: 64 layers, twice the period of the points
  c.numerics.gravity = 0.0;           // so that heights are not settled
  const CaseScene scene = make_scene(c);
  const State state = make_state(c, scene);
  const double spacing = 0.125, length = 64 * spacing, mass = 300.0 * 1.0 * 1.5 * length;
  EXPECT_NEAR(totals(state, scene).mass, mass, 1e-12 * mass);
  const auto all = testing::stored_particles(state.grid);
  EXPECT_NEAR(static_cast<double>(all.size()), 64.0 * 12.0 * 8.0, 0.02 * 64.0 * 12.0 * 8.0) << "one a cell of the lattice";
  double nearest = length;
  for (std::size_t a = 0; a < all.size(); ++a) {
    const Vec3 x = position_of(all[a]);
    ASSERT_TRUE(x.x() < 0.0 && x.x() > -length && x.y() > 0.0 && x.y() < 1.5 && x.z() > 0.0 && x.z() < 1.0) << x.transpose();
    for (std::size_t b = 0; b < a; ++b) nearest = std::min(nearest, (position_of(all[b]) - x).norm());
  }
  EXPECT_GE(nearest, (random_distance - 1.0 / 16.0) * spacing) << "heights are rounded to sixteenths of a row";
}

TEST(Conveyor, InclinedFrontIsThePlugWithoutTheSnowAboveItsSlope) {
  Case c = plug(elastic_snow(), 4.0);
  c.numerics.gravity = 0.0;
  const double spacing = 0.125, length = 2.5, height = 1.0;
  for (const Lattice lattice : {Lattice::staggered, Lattice::random}) {
    c.conveyor->lattice = lattice;
    for (const double angle : {90.0, 45.0, 30.0}) {
      c.conveyor->front_angle = angle / 180.0 * std::numbers::pi;
      const CaseScene scene = make_scene(c);
      State state = make_state(c, scene);
      const double run = angle == 90.0 ? 0.0 : 1.0 / std::tan(c.conveyor->front_angle);
      for (const Particle& p : testing::stored_particles(state.grid)) ASSERT_LE(p.position[0], 1e-12 - run * p.position[2]) << angle;
      const double mass = 300.0 * 1.5 * height * (length - 0.5 * run * height);
      const double half_a_row = 300.0 * 1.5 * run * height * 0.5 * spacing;    // a layer ends at whole rows: over the length of the slope
      const double part_of_period = lattice == Lattice::random ? 0.02 : 1e-9;  // 20 of the 32 layers with which random points repeat
      EXPECT_NEAR(totals(state, scene).mass, mass, half_a_row + part_of_period * mass) << angle;
      advance(state, scene, 0.2);
      EXPECT_NEAR(state.entered.mass, 300.0 * 1.5 * height * 4.0 * 0.2, 300.0 * 1.5 * height * 1.05 * spacing) << "what enters is a plug";
    }
  }
}

/// Two windows' passage after the start, the plug is what it was: nothing but the belt moved it.
class PlugWithoutObstacle : public ::testing::TestWithParam<std::tuple<MaterialParameters, Lattice>> {};
INSTANTIATE_TEST_SUITE_P(LawsAndLattices, PlugWithoutObstacle,
                         ::testing::Combine(::testing::Values(elastic_snow(), cam_clay_snow(0.8, 0.3), cam_clay_snow(0.4, 0.0)),
                                            ::testing::Values(Lattice::aligned, Lattice::staggered)));

TEST_P(PlugWithoutObstacle, StaysAPlug) {
  const double velocity = 8.0, dx = 0.25, spacing = 0.125;
  const auto& [material, lattice] = GetParam();
  Case c = plug(material, velocity);
  c.conveyor->lattice = lattice;
  c.numerics.contact = ContactRule::nodal;  // the floor's cell below
  c.numerics.transfer = Transfer::apic;
  const CaseScene scene = make_scene(c);
  const auto per_layer = particles_per_layer(*c.conveyor, 0.125);
  State state = make_state(c, scene);
  advance(state, scene, 0.8);
  double floor_impulse = 0.0, gravity_impulse = 0.0, mass_seconds = 0.0;
  advance(state, scene, 1.0, [&](const StepReport& report) {
    floor_impulse += report.impulses[0].linear.z();
    gravity_impulse += report.gravity_impulse.z();
    mass_seconds += report.dt * totals(state, scene).mass;
    EXPECT_LE(std::abs(totals(state, scene).mass - 300.0 * 1.5 * 4.5), 1.001 * 300.0 * 1.5 * spacing);  // of the half; one layer to and fro
  });
  EXPECT_NEAR(floor_impulse, gravity_impulse, 0.005 * std::abs(gravity_impulse));  // the floor carries the weight
  EXPECT_NEAR(mass_seconds / 0.2, 300.0 * 1.5 * (4.5 - 0.5 * spacing), 300.0 * 1.5 * 0.5 * spacing);
  EXPECT_EQ(state.left.count, state.left.through_x_max);
  EXPECT_NEAR(static_cast<double>(state.entered.count), velocity / spacing * static_cast<double>(per_layer),
              1.01 * static_cast<double>(per_layer));

  // What a grid keeps of a hydrostatic profile: inside, the weight of a cell is its resolution, a seventh of which is allowed. In the cell
  // on the floor the nodes on and behind it carry a part themselves: a uniform stress sigma of particles at 1/4, 3/4, 5/4 dx pushes the
  // nodes above with (27/32 + 27/32 + 5/32) / 2 sigma = 0.922 sigma (weights times 4 (x_i - x_p) / dx), so the particles there carry 1 /
  // 0.922 of the exact. Particles at every height from 0 to 3/2 dx, as staggered layers are: the mean of the same, 13/32 + 1/2.
  const double resolved = 0.15 * weight * dx, wall_cell = 1.0 / (lattice == Lattice::aligned ? 0.921875 : 0.90625);
  // That misfit of a fresh column, at most 0.4 rho g dx, relaxes with sigma / (rho c_P) = 0.017 m/s.
  const double relaxation = 0.02;
  std::map<std::uint64_t, std::pair<double, double>> layers;  // by number: mean and deviation of x
  std::array<double, 8> sigma{}, count{};
  for (const Particle& p : testing::stored_particles(state.grid)) {
    const std::uint64_t layer = p.id / per_layer;
    auto& [mean, deviation] = layers[layer];
    mean += p.position[0] / static_cast<double>(per_layer);
    if (p.position[0] > 1.0) continue;  // the outlet's neighbourhood
    const auto k = p.id % per_layer / 12;
    sigma[k] += p.stress[2] / volume_ratio(scene.material, p);
    count[k] += 1.0;
    EXPECT_LE((velocity_of(p) - Vec3(velocity, 0.0, 0.0)).norm(), relaxation);
    deviation = std::max(deviation, std::abs(p.position[0] - (velocity * state.time - (static_cast<double>(layer) + 0.5) * spacing)));
  }
  for (std::size_t k = 0; k < 8; ++k) {
    const double exact = -weight * (1.0 - (static_cast<double>(k) + 0.5) / 8.0) * (k < 2 ? wall_cell : 1.0);
    EXPECT_NEAR(sigma[k] / count[k], exact, resolved) << k;
  }
  // The lattice runs on unbroken: exactly behind the inlet, where the belt alone moves it, and everywhere but for that relaxation over the
  // time that the snow spent in the window.
  for (auto it = layers.begin(); std::next(it) != layers.end(); ++it) {
    const double here = it->second.first;
    if (here > 1.0) continue;
    EXPECT_EQ(std::next(it)->first, it->first + 1);
    EXPECT_NEAR(here - std::next(it)->second.first, spacing, here < -2.25 ? 1e-12 : 1e-3 * spacing) << it->first;
    EXPECT_LE(it->second.second, here < -2.25 ? 1e-12 : relaxation * (here + 2.5) / velocity) << it->first;
  }
}

TEST(Conveyor, MirroredHalvesAgreeWithTheWhole) {
  Case half_case = small_avalanche();
  half_case.numerics.contact = ContactRule::nodal;  // the sweeps of contact at a surface go from one end of the whole mast to the other
  Case whole_case = half_case;
  whole_case.conveyor->mirror_y = false;
  const CaseScene half_scene = make_scene(half_case), whole_scene = make_scene(whole_case);
  State half = make_state(half_case, half_scene), whole = make_state(whole_case, whole_scene);
  Vec3 half_force = Vec3::Zero(), whole_force_sum = Vec3::Zero();
  for (int n = 0; n < 60; ++n) {
    const double dt = 1.5e-3;
    half_force += step(half, half_scene, dt).impulses.back().linear;
    whole_force_sum += step(whole, whole_scene, dt).impulses.back().linear;
  }
  // Number l n_z n_y + k n_y + j in both, with n_y half as large and j counted from the middle in the half.
  const std::uint64_t n_y = 12, n_z = 8;
  const auto all = testing::particles_by_id(whole.grid);
  const auto some = testing::particles_by_id(half.grid);
  ASSERT_EQ(all.size(), 2 * some.size());
  for (const Particle& p : some) {
    const auto j = p.id % n_y, k = p.id / n_y % n_z, l = p.id / n_y / n_z;
    const Particle& q = all[(l * n_z + k) * 2 * n_y + n_y + j];
    // round-off of 1e-14 m/s a step, as in the test of the mirror planes
    ASSERT_LE((position_of(p) - position_of(q)).norm(), 1e-12) << p.id;
    ASSERT_LE((velocity_of(p) - velocity_of(q)).norm(), 1e-11);
    ASSERT_LE((testing::stress_of(p) - testing::stress_of(q)).norm(), 1e-5);
  }
  EXPECT_GT(whole_force_sum.x(), 10.0);
  EXPECT_LE((whole_force(half_force, {false, true}) - whole_force_sum).norm(), 1e-10 * whole_force_sum.norm());
}

}  // namespace
}  // namespace mpm
