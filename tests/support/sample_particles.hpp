#pragma once
/// Made-up states for tests of files and pictures: they look like an avalanche that piles up in front of a mast, and obey no law.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "libmpm/io/snapshot.hpp"
#include "libmpm/io/xdmf.hpp"

namespace mpm::testing {

/// Random numbers in every column, for tests of files.
inline ParticleTable random_particles(std::size_t n, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  ParticleTable p;
  const auto fill = [&](std::vector<double>& column, std::size_t components, double mean, double deviation) {
    column.resize(components * n);
    for (double& v : column) v = mean + deviation * normal(random);
  };
  for (std::size_t i = 0; i < n; ++i) p.id.push_back(3 * i + 1);
  fill(p.position, 3, 0.0, 5.0);
  fill(p.velocity, 3, 0.0, 10.0);
  fill(p.affine, 9, 0.0, 30.0);
  fill(p.stress, 6, 0.0, 1e4);
  fill(p.internal, 1, 0.0, 0.01);
  fill(p.volume_ratio, 1, 1.0, 0.02);
  fill(p.volume, 1, 2e-3, 1e-5);
  return p;
}

/// A heap in front of a mast of width 1.75 m (front face x = 0, axis y = 0), flow height 1.75 m, at time t after the impact.
/// @param spacing distance of particles, m
inline ParticleTable heap_particles(double t, double spacing) {
  constexpr double width = 1.75, height = 1.75, density = 300.0, gravity = 9.81, speed = 8.0;
  ParticleTable p;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> jitter(-0.3 * spacing, 0.3 * spacing);
  const double grown = 1.0 - std::exp(-t);
  for (double x = -8.0 + 0.5 * spacing; x < 4.0; x += spacing) {
    for (double y = 0.5 * spacing; y < 4.0; y += spacing) {
      const bool upstream = x < 0.0;
      if (!upstream && (y < 0.5 * width + 0.2 * x || x > speed * t)) continue;
      const double near = std::exp(-x * x / 4.0 - y * y / 1.5);
      const double top = upstream ? height * (1.0 + 2.8 * grown * near) : height * 0.9;
      for (double z = 0.5 * spacing; z < top; z += spacing) {
        p.id.push_back(p.id.size());
        for (const double c : {x, y, z}) p.position.push_back(c + jitter(random));
        p.velocity.insert(p.velocity.end(), {speed * (1.0 - 0.9 * (upstream ? near : 0.0)), 2.0 * near, 3.0 * near * (1.0 - grown)});
        p.affine.insert(p.affine.end(), 9, 0.0);
        const double pressure =
            density * gravity * std::max(0.0, height - z) + density * speed * speed / 2.0 * (upstream ? near : 0.0) * std::exp(-z / height);
        p.stress.insert(p.stress.end(), {-1.1 * pressure, -0.95 * pressure, -0.95 * pressure, 0.0, 0.1 * pressure, 0.0});
        p.internal.push_back(0.005);
        p.volume_ratio.push_back(1.0 - pressure / 1e6);
        p.volume.push_back(spacing * spacing * spacing);
      }
    }
  }
  return p;
}

/// The next frame of a series, with all its particles at once.
inline void append_frame(FrameSeries& series, const ParticleTable& particles, const SnapshotInfo& info) {
  series.append(info, [&](SnapshotWriter& file) {
    file.begin(particles.size());
    file.append(particles);
    file.commit();
  });
}

}  // namespace mpm::testing
