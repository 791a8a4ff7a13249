#include "libmpm/observe/runup.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

/// Percentile between order statistics (numpy's default, Hyndman and Fan's type 7); reorders the values.
double percentile(std::vector<double>& values, double part) {
  if (values.empty()) return 0.0;
  const double place = part * static_cast<double>(values.size() - 1);
  const auto below = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), below, values.end());
  const auto above = below + 1 == values.end() ? below : std::min_element(below + 1, values.end());
  return *below + (place - std::floor(place)) * (*above - *below);
}

}  // namespace

void Runup::visit(const ParticleBatch& batch) {
  for (std::size_t i = 0; i < batch.size(); ++i) add(batch[i].position);
}

void Runup::add(const Vec3& position) {
  if (std::abs(position[1]) > geometry_.strip_half_width) return;
  const double x = position[0] - geometry_.front(position[1]), z = position[2];
  if (!(x < 0.0)) return;
  highest_ = std::max(highest_, z);
  if (x >= -geometry_.flow_height) near_heights_.push_back(z);
}

RunupHeights Runup::finish() {
  const RunupHeights heights{highest_, percentile(near_heights_, 0.99)};
  highest_ = 0.0;
  near_heights_.clear();
  return heights;
}

void Runup::sample(const Instant&, std::span<double> row) {
  const RunupHeights heights = finish();
  row[0] = heights.highest;
  row[1] = heights.p99;
}

std::vector<Result> Runup::summary(const Summary& end) const {
  const double peak = end.peak("runup_m");
  return {{"runup_peak_m", peak, "m", "highest run-up at any time, the first splash included"},
          {"runup_peak_to_mean", peak / end.mean("runup_m").mean, "", "highest run-up over its mean"}};
}

}  // namespace mpm
