#include "libmpm/observe/runup.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

/// Height below which a part of the mass lies; sorts the particles. Linear between particles, the k-th of which (from 0) is at
/// (m_0 + ... + m_{k-1} + k/(n-1) m_k) of the whole mass: for equal masses the k-th of n - 1 steps (Hyndman & Fan 1996, type 7).
double height_of(double part, std::vector<std::pair<double, double>>& particles) {
  if (particles.empty()) return 0.0;
  std::ranges::sort(particles);
  const double last = static_cast<double>(particles.size() - 1);
  double whole = 0.0;
  for (const auto& [z, mass] : particles) whole += mass;
  double below = 0.0, place = 0.0, height = particles.front().first;
  for (std::size_t k = 1; k < particles.size(); ++k) {
    below += particles[k - 1].second;
    const double next = below + static_cast<double>(k) / last * particles[k].second, above = particles[k].first;
    if (next >= part * whole) return height + (part * whole - place) / (next - place) * (above - height);
    place = next;
    height = above;
  }
  return height;
}

}  // namespace

void Runup::visit(const ParticleBatch& batch) {
  for (std::size_t i = 0; i < batch.size(); ++i) add(batch[i].position, batch[i].mass);
}

void Runup::add(const Vec3& position, double mass) {
  if (std::abs(position[1]) > geometry_.strip_half_width) return;
  const double x = position[0] - geometry_.front(position[1]), z = position[2];
  if (!(x < 0.0)) return;
  const bool near = x >= -geometry_.flow_height;
  if (near || !geometry_.uneven_ground) highest_ = std::max(highest_, z);
  if (near) near_.emplace_back(z, mass);
}

RunupHeights Runup::finish() {
  const RunupHeights heights{highest_, height_of(0.99, near_)};
  highest_ = 0.0;
  near_.clear();
  return heights;
}

void Runup::sample(const Instant&, std::span<double> row) {
  const RunupHeights heights = finish();
  row[0] = heights.highest;
  row[1] = heights.p99;
}

std::vector<Result> Runup::summary(const Summary& end) const {
  const double peak = end.peak("runup_m");
  return {
      {"runup_peak_m", peak, "m", "highest particle at any time, the first splash included"},
      {"runup_p99_peak_m", end.peak("runup_p99_m"), "m",
       "largest height that holds 99 % of the mass near the axis at any time, the first splash included"},
      {"runup_peak_to_mean", peak / end.mean("runup_m").mean, "", "highest particle at any time over the mean of the highest particle"}};
}

}  // namespace mpm
