#include "libmpm/observe/force_by_height.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

constexpr double no_mean = MeanEstimate::none;

/// Adds layers to a sum, which grows to hold them.
void add(LayerImpulses& sum, const LayerImpulses& more) {
  if (more.layer.empty()) return;
  if (sum.layer.empty()) sum.first = more.first;
  if (more.first < sum.first) {
    sum.layer.insert(sum.layer.begin(), static_cast<std::size_t>(sum.first - more.first), Vec3::Zero());
    sum.first = more.first;
  }
  const auto base = static_cast<std::size_t>(more.first - sum.first);
  if (sum.layer.size() < base + more.layer.size()) sum.layer.resize(base + more.layer.size(), Vec3::Zero());
  for (std::size_t k = 0; k < more.layer.size(); ++k) sum.layer[base + k] += more.layer[k];
}

/// Force above a height of a mean force by height, N.
double force_above(double height, std::span<const double> bins, double bin_height) {
  double sum = bins.back();
  for (std::size_t bin = 0; bin + 1 < bins.size(); ++bin) {
    const double low = bin_height * static_cast<double>(bin);
    sum += bins[bin] * std::clamp((low + bin_height - height) / bin_height, 0.0, 1.0);
  }
  return sum;
}

}  // namespace

LayeredForce force_by_height(std::span<const double> force, double lowest, double cell_size, const ImpactGeometry& geometry) {
  const std::size_t above = geometry.profile_bins();
  LayeredForce result{std::vector<double>(above + 1, 0.0), 0.0};
  // each bin gets the part of the interval of heights that lies in it
  const auto spread = [&](double from, double to, double per_metre) {
    for (double low = from; low < to;) {
      const auto bin = std::min(static_cast<std::size_t>(low / geometry.bin_height), above);
      const double end = bin == above ? to : std::min(to, geometry.bin_height * static_cast<double>(bin + 1));
      if (end <= low) {  // rounding of low / bin_height
        low = std::nextafter(low, to);
        continue;
      }
      result.bins[bin] += per_metre * (end - low);
      low = end;
    }
  };
  for (std::size_t k = 0; k < force.size(); ++k) {
    const double z = lowest + static_cast<double>(k) * cell_size, low = z - 0.5 * cell_size, high = z + 0.5 * cell_size;
    result.first_moment += force[k] * z;
    if (force[k] == 0.0) continue;
    const double per_metre = force[k] / cell_size;
    spread(std::max(low, 0.0), std::max(high, 0.0), per_metre);
    if (low < 0.0) spread(std::max(-high, 0.0), -low, per_metre);
  }
  return result;
}

void ForceByHeight::after_step(const StepReport& report, const State&) { add(layers_, report.layers[layered_]); }

void ForceByHeight::sample(const Instant& now, std::span<double>) {
  LayeredForce mean{std::vector<double>(width(), no_mean), no_mean};
  if (now.interval > 0.0) {
    const double dx = now.live->state.grid.cell_size(), whole = now.live->scene.mirror.y ? 2.0 : 1.0;
    std::vector<double> force;
    for (const Vec3& impulse : layers_.layer) force.push_back(whole * impulse.x() / now.interval);
    mean = mpm::force_by_height(force, dx * layers_.first - now.live->scene.offset.z(), dx, geometry_);
  }
  bins_.insert(bins_.end(), mean.bins.begin(), mean.bins.end());
  first_moment_.push_back(mean.first_moment);
  layers_ = {};
}

void ForceByHeight::load(const Arrays& arrays, std::size_t samples) {
  bins_ = stored_array(arrays, "force_n", samples * width());
  first_moment_ = stored_array(arrays, "first_moment_n_m", samples);
}

std::vector<Result> ForceByHeight::summary(const Summary& end) const {
  double above = no_mean, resultant = no_mean;
  if (end.span.steady) {
    const double pressure_height = end.mean("pressure_height_m").mean;
    if (std::isfinite(pressure_height)) above = force_above(pressure_height, end.mean_rows(bins_, width()), geometry_.bin_height);
    resultant = end.mean_rows(first_moment_, 1)[0] / end.mean("force_x_n").mean;
  }
  return {
      {"force_above_pressure_height_n", above, "N", "mean stream-wise force on the part of the obstacle above the mean pressure height"},
      {"force_resultant_height_m", resultant, "m", "height at which the mean stream-wise force acts"}};
}

std::vector<HeightProfile> ForceByHeight::profiles(const Summary& end) const {
  const std::size_t bins = geometry_.profile_bins();
  HeightProfile profile{
      {.quantity = "force_x_per_height",
       .unit = "N/m",
       .meaning = "stream-wise force that the obstacle took there, on all its sides, from the impulses of the grid layers",
       .kind = Column::Kind::interval_mean},
      {},
      {}};
  if (bins_.empty()) {  // measured from frames, which lack it
    profile.mean.assign(bins, no_mean);
    return {profile};
  }
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    if (i % width() != bins) profile.over_time.push_back(bins_[i] / geometry_.bin_height);
  }
  profile.mean = end.mean_rows(bins_, width());
  if (!profile.mean.empty()) profile.mean.pop_back();  // above the profile
  for (double& f : profile.mean) f /= geometry_.bin_height;
  return {profile};
}

}  // namespace mpm
