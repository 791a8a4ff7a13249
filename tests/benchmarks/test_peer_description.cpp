/// The description of the reference problem for other programs (benchmarks/peers/reference_problem.json) against the problem that is timed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <variant>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "reference_problem.hpp"

namespace mpm::benchmarks {
namespace {

class PeerDescription : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    file = nlohmann::json::parse(read_file(std::string(MPM_SOURCE_DIR) + "/benchmarks/peers/reference_problem.json"));
  }
  static Vec3 vector(const nlohmann::json& a) { return {a[0].get<double>(), a[1].get<double>(), a[2].get<double>()}; }
  static inline nlohmann::json file;
};

TEST_F(PeerDescription, HasTheParticlesOfTheProblem) {
  const double dx = file["numerics"]["cell_size_m"], spacing = file["block"]["particle_spacing_m"];
  const Problem problem = make_reference(dx, Regime::fully_yielding);
  const auto particles = copy_particles(problem.state.grid);
  ASSERT_EQ(particles.size(), file["particles"].get<std::size_t>());
  const Vec3 min = vector(file["block"]["min_m"]), max = vector(file["block"]["max_m"]), first = vector(file["block"]["first_particle_m"]);
  const Vec3 along = (max - min) / spacing;
  EXPECT_EQ(std::lround(along.prod()), file["particles"].get<long>());
  const Vec3 start = vector(file["velocity"]["at_the_origin_m_s"]);
  Mat3 gradient;
  for (int i = 0; i < 3; ++i) gradient.row(i) = vector(file["velocity"]["gradient_1_s"][static_cast<std::size_t>(i)]).transpose();
  constexpr double round_off = 1e-12;  // m and m/s, of numbers below 30
  Vec3 low = Vec3::Constant(HUGE_VAL);
  for (const Particle& p : particles) {
    const Vec3 x(p.position[0], p.position[1], p.position[2]), place = (x - first) / spacing;
    low = low.cwiseMin(x);
    ASSERT_LE((place - Vec3(place.array().round())).norm() * spacing, round_off);
    ASSERT_LE((Eigen::Map<const Vec3>(p.velocity) - (start + gradient * x)).norm(), round_off);
    ASSERT_EQ(Eigen::Map<const Mat3>(p.affine), gradient);
    ASSERT_TRUE(std::ranges::all_of(p.stress, [](double s) { return s == file["stress_pa"].get<double>(); }));
  }
  EXPECT_LE((low - first).norm(), round_off);
}

TEST_F(PeerDescription, HasTheValuesAfterTwentySteps) {
  Problem problem = make_reference(file["numerics"]["cell_size_m"], Regime::fully_yielding);
  const auto& check = file["check"];
  for (int n = 0; n < check["after_steps"]; ++n) step(problem.state, problem.scene, stable_time_step(problem.state, problem.scene));
  const Totals sum = totals(problem.state, problem.scene);
  constexpr double enough = 1e-6;  // relative; other programs are asked for 1e-3
  const double mass = check["mass_kg"], height = check["centre_of_mass_height_m"];
  const Vec3 momentum = vector(check["momentum_n_s"]);
  EXPECT_NEAR(problem.state.time, check["time_s"], 1e-8);
  EXPECT_NEAR(sum.mass, mass, 1e-12 * mass);
  EXPECT_LE((sum.momentum - momentum).norm(), enough * momentum.norm()) << sum.momentum.transpose();
  EXPECT_NEAR(sum.centre.z(), height, enough * height);
}

TEST_F(PeerDescription, HasTheSceneOfTheProblem) {
  const Problem problem = make_reference(0.25, Regime::fully_yielding);
  const CamClay::Parameters snow = reference_snow();
  const auto& m = file["material"];
  EXPECT_EQ(m["density_kg_m3"], snow.density);
  EXPECT_EQ(m["young_modulus_pa"], snow.young_modulus);
  EXPECT_EQ(m["poisson_ratio"], snow.poisson_ratio);
  EXPECT_EQ(m["critical_state_slope"], snow.critical_state_slope);
  EXPECT_EQ(m["cohesion_beta"], snow.cohesion_beta);
  EXPECT_EQ(m["hardening_xi"], snow.hardening_xi);
  EXPECT_EQ(m["preconsolidation_pressure_pa"], snow.preconsolidation_pressure);
  EXPECT_EQ(vector(file["gravity_m_s2"]), problem.scene.gravity);
  EXPECT_EQ(file["numerics"]["cfl"], problem.scene.numerics.cfl);
  EXPECT_EQ(problem.scene.numerics.transfer, Transfer::apic);
  ASSERT_EQ(problem.scene.boundaries.size(), 1U);
  const auto& floor = std::get<Wall>(problem.scene.boundaries[0]);
  EXPECT_EQ(floor.point, vector(file["floor"]["point_m"]));
  EXPECT_EQ(floor.normal, vector(file["floor"]["normal"]));
  EXPECT_EQ(floor.contact, Contact::separable);
  EXPECT_EQ(floor.friction, 0.0);
}

}  // namespace
}  // namespace mpm::benchmarks
