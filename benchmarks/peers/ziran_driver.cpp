/// The reference problem (reference_problem.json) for the program Ziran (ziran2019): a main function that is linked with its libraries.
/// Its y axis points up, so our (x, y, z) is its (x, z, y); the snow is shifted by 5 m along all axes, because its grid has no negative
/// nodes. Law: the neo-Hookean model with the non-associative Cam clay, the only one with which this version compiles Cam clay.
///
///   ziran_driver [THREADS]     prints million particle-steps a second, and the values to compare with the section `check` of the file

#include <ctime>

#include <MPM/Force/FBasedMpmForceHelper.h>
#include <MPM/MpmSimulationBase.h>
#include <tbb/global_control.h>

#include <Ziran/Math/Geometry/AnalyticLevelSet.h>
#include <Ziran/Math/Geometry/CollisionObject.h>
#include <Ziran/Physics/ConstitutiveModel/ConstitutiveModel.h>
#include <Ziran/Physics/PlasticityApplier.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace {

using Vec3 = ZIRAN::Vector<double, 3>;
using Mat3 = ZIRAN::Matrix<double, 3, 3>;
using Simulation = ZIRAN::MpmSimulationBase<double, 3>;
using Elasticity = ZIRAN::NeoHookeanBorden<double, 3>;
using CamClay = ZIRAN::NonAssociativeCamClay<double>;

constexpr double cell = 0.05, spacing = 0.025, density = 300.0, young = 1e6, poisson = 0.1, cfl = 0.4, shift = 5.0;
constexpr double slope = 0.8, beta = 0.3, hardening = 0.5, preconsolidation = 1e4;  // M, beta, xi, p_c (Pa)
constexpr double volume = spacing * spacing * spacing, mass = density * volume;
constexpr int untimed_steps = 6, timed_steps = 20, check_step = 20;

void set_numbers(Simulation& sim) {
  sim.write_files = sim.write_log = sim.write_partio = sim.write_meshes = sim.autorestart = false;
  sim.mls_mpm = true;
  sim.transfer_scheme = Simulation::APIC_blend_RPIC;
  sim.useTrialCollision = false;  // contact once a step
  sim.setDx(cell);
  sim.gravity = Vec3(0.0, -9.81, 0.0);
  using Body = ZIRAN::AnalyticCollisionObject<double, 3>;
  sim.addCollisionObject(Body(std::make_unique<ZIRAN::HalfSpace<double, 3>>(Vec3(0.0, shift, 0.0), Vec3(0.0, 1.0, 0.0)), Body::SEPARATE));
}

void fill_with_snow(Simulation& sim) {
  const int along = 80, up = 160, across = 40;  // particles on a block of 2 x 4 x 1 m
  auto& particles = sim.particles;
  Mat3 gradient = Mat3::Zero();
  gradient(0, 0) = 5.0, gradient(0, 1) = 2.0, gradient(1, 1) = -5.0;  // 1/s
  {
    auto appender = particles.appender();
    for (int i = 0; i < along; ++i) {
      for (int j = 0; j < up; ++j) {
        for (int k = 0; k < across; ++k) {
          const Vec3 x = spacing * Vec3(i + 0.5, j + 0.5, k + 0.5);
          appender.append(mass, x + Vec3::Constant(shift), Vec3(-5.0, 0.0, 0.0) + gradient * x);
        }
      }
    }
  }
  ZIRAN::Range all;
  all.lower = 0, all.upper = particles.count;
  using Helper = ZIRAN::FBasedMpmForceHelper<Elasticity>;
  Helper& helper = sim.getMpmForce()->getHelper();
  const Elasticity elasticity(young, poisson);
  particles.add(helper.constitutive_model_name(), all, elasticity);
  particles.add(ZIRAN::element_measure_name<double>(), all, volume);
  particles.add(helper.F_name(), all, Mat3::Identity());
  particles.add(helper.constitutive_model_scratch_name(), all, Helper::Scratch());
  CamClay clay(-std::asinh(preconsolidation / elasticity.kappa - 1e-5) / hardening, 45.0, beta, hardening, 3);
  clay.M = slope;
  sim.plasticity_appliers.push_back(std::make_unique<ZIRAN::PlasticityApplier<Elasticity, CamClay, Mat3>>("F"));
  particles.add(ZIRAN::AttributeName<CamClay>(CamClay::name()), all, clay);
  sim.initialize();
  auto& affine = particles.DataManager::get(ZIRAN::C_name<Mat3>());
  for (int p = 0; p < particles.count; ++p) affine[p] = gradient;
}

double stable_time_step(const Simulation& sim) {
  const double p_modulus = young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));  // K + 4 G / 3
  double speed_squared = 0.0;
  for (int p = 0; p < sim.particles.count; ++p) speed_squared = std::max(speed_squared, sim.particles.V[p].squaredNorm());
  return cfl * cell / (std::sqrt(p_modulus / density) + std::sqrt(speed_squared));
}

void print_check_values(const Simulation& sim, int step, double time) {
  Vec3 momentum = Vec3::Zero();
  double height = 0.0;
  for (int p = 0; p < sim.particles.count; ++p) momentum += mass * sim.particles.V[p], height += sim.particles.X[p][1] - shift;
  std::fprintf(stderr, "step %d, t = %.6g ms: %.10g kg, momentum (%.8g, %.3g, %.8g) N s, height of the centre of mass %.8g m\n", step,
               1e3 * time, mass * sim.particles.count, momentum[0], momentum[2], momentum[1], height / sim.particles.count);
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Simulation sim;
  set_numbers(sim);
  fill_with_snow(sim);
  const auto& clay = sim.particles.DataManager::get(ZIRAN::AttributeName<CamClay>(CamClay::name()));
  const int count = sim.particles.count;
  std::vector<double> before(count);
  double time = 0.0, processor = 0.0, elapsed = 0.0, least_yielding = 1.0;
  for (int step = 1; step <= untimed_steps + timed_steps; ++step) {
    const double dt = stable_time_step(sim);
    for (int p = 0; p < count; ++p) before[p] = clay[p].logJp;
    const double processor_start = processor_seconds();
    const auto start = std::chrono::steady_clock::now();
    sim.beginTimeStep(0, step, time, dt);
    sim.advanceOneTimeStep(dt);
    if (step > untimed_steps) {
      processor += processor_seconds() - processor_start;
      elapsed += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      int resting = 0;
      for (int p = 0; p < count; ++p) resting += clay[p].logJp == before[p];
      least_yielding = std::min(least_yielding, 1.0 - static_cast<double>(resting) / count);
    }
    time += dt;
    if (step == check_step) print_check_values(sim, step, time);
  }
  const double million = 1e-6 * count * timed_steps;
  std::fprintf(
      stderr,
      "%d steps, %d threads: %.4g million particle-steps a second of processor time, %.4g of elapsed time; yielding: at least %.4f\n",
      timed_steps, threads, million / processor, million / elapsed, least_yielding);
  std::_Exit(0);  // without the timings that Ziran prints at its end
}
