/// The reference problem (reference_problem.json) for the program Matter: a main function that uses only Matter's public interface.
/// Its y axis points up, so our (x, y, z) is its (x, z, y). It needs three dimensions (THREEDIM) and double precision.
///
///   matter_driver [THREADS]     prints million particle-steps a second, and the values to compare with the section `check` of the file
///
/// Each call of simulate() computes one frame, which is one step here: its length is that of libmpm, and Matter's own limits of the step
/// are out of reach. Matter keeps its particles and its grid from call to call.

#include <ctime>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <vector>

#include "objects/object_plate.hpp"
#include "simulation/simulation.hpp"
#include "tools.hpp"

namespace {

constexpr double cell = 0.05, spacing = 0.025, density = 300.0, young = 1e6, poisson = 0.1, cfl = 0.4;
constexpr double slope = 0.8, beta = 0.3, hardening = 0.5, preconsolidation = 1e4;  // M, beta, xi, p_c (Pa)
constexpr int untimed_steps = 6, timed_steps = 20, check_step = 20;

void fill_with_snow(Simulation& sim) {
  const int along = 80, up = 160, across = 40;  // particles on a block of 2 x 4 x 1 m
  sim.Np = static_cast<unsigned>(along * up * across);
  sim.particles = Particles(sim.Np);
  TM gradient = TM::Zero();
  gradient(0, 0) = 5.0, gradient(0, 1) = 2.0, gradient(1, 1) = -5.0;  // 1/s
  std::size_t p = 0;
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < up; ++j) {
      for (int k = 0; k < across; ++k, ++p) {
        sim.particles.x[p] = spacing * TV(i + 0.5, j + 0.5, k + 0.5);
        sim.particles.v[p] = TV(-5.0, 0.0, 0.0) + gradient * sim.particles.x[p];
        sim.particles.Bmat[p] = 0.25 * cell * cell * gradient;  // Matter keeps C_p without the inverse of D_p
      }
    }
  }
  sim.particle_volume = spacing * spacing * spacing;
  sim.particle_mass = density * sim.particle_volume;
}

void set_numbers(Simulation& sim, int threads) {
  sim.n_threads = static_cast<unsigned>(threads);
  sim.save_sim = false;
  sim.reduce_verbose = true;
  sim.Lx = 2.0, sim.Ly = 4.0, sim.Lz = 1.0;
  sim.dx = cell;
  sim.grid_reference_point = TV::Zero();  // nodes at whole multiples of the cell size
  sim.gravity = TV(0.0, -9.81, 0.0);
  sim.rho = density, sim.E = young, sim.nu = poisson;
  sim.flip_ratio = -2.0;  // below -1: affine transfer
  sim.cfl = sim.cfl_elastic = 1e9;
  sim.plastic_model = PlasticModel::MCC;
  sim.hardening_law = HardeningLaw::SinhImpl;
  sim.q_prefac = std::sqrt(1.5);                // q = sqrt(3/2 s:s)
  sim.M = slope / std::sqrt(1.0 + 2.0 * beta);  // Matter's yield function has no factor 1 + 2 beta
  sim.beta = beta, sim.xi = hardening, sim.p0 = preconsolidation;
  sim.plates.push_back(std::make_unique<ObjectPlate>(0.0, PlateType::bottom, BC::SlipFree));
}

double stable_time_step(const Simulation& sim) {
  const double p_modulus = young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));  // K + 4 G / 3
  double speed_squared = 0.0;
  for (const TV& v : sim.particles.v) speed_squared = std::max(speed_squared, v.squaredNorm());
  return cfl * cell / (std::sqrt(p_modulus / density) + std::sqrt(speed_squared));
}

void print_check_values(const Simulation& sim, int step, double time) {
  TV momentum = TV::Zero();
  double height = 0.0;
  for (std::size_t p = 0; p < sim.Np; ++p) momentum += sim.particle_mass * sim.particles.v[p], height += sim.particles.x[p][1];
  std::printf("step %d, t = %.6g ms: %.10g kg, momentum (%.8g, %.3g, %.8g) N s, height of the centre of mass %.8g m\n", step, 1e3 * time,
              sim.Np * sim.particle_mass, momentum[0], momentum[2], momentum[1], height / sim.Np);
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main(int argc, char** argv) {
  Simulation sim;
  std::cout.setstate(std::ios::failbit);  // Matter reports every step
  sim.initialize(false);
  set_numbers(sim, argc > 1 ? std::atoi(argv[1]) : 1);
  fill_with_snow(sim);
  double time = 0.0, processor = 0.0, elapsed = 0.0, least_yielding = 1.0;
  for (int step = 1; step <= untimed_steps + timed_steps; ++step) {
    const double dt = stable_time_step(sim);
    sim.fps = 1.0 / dt;
    const std::vector<T> before = sim.particles.eps_pl_vol;
    const double processor_start = processor_seconds();
    const auto start = std::chrono::steady_clock::now();
    sim.simulate();
    if (step > untimed_steps) {
      processor += processor_seconds() - processor_start;
      elapsed += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      std::size_t resting = 0;
      for (std::size_t p = 0; p < sim.Np; ++p) resting += sim.particles.eps_pl_vol[p] == before[p];
      least_yielding = std::min(least_yielding, 1.0 - static_cast<double>(resting) / sim.Np);
    }
    time += dt;
    if (step == check_step) print_check_values(sim, step, time);
    if (sim.exit != 0) return 1;
  }
  const double million = 1e-6 * sim.Np * timed_steps;
  std::printf(
      "%d steps, %d threads: %.4g million particle-steps a second of processor time, %.4g of elapsed time; yielding: at least %.4f\n",
      timed_steps, static_cast<int>(sim.n_threads), million / processor, million / elapsed, least_yielding);
}
