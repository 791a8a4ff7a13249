#include "libmpm/boundary/edge_share.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "libmpm/boundary/axis_weights.hpp"

namespace mpm {

namespace {

constexpr int points = 16;        // of the side; the share does not change with more
constexpr double step = 0.05;     // cells, of the sum that stands for the integral of the squared error
constexpr double beyond = 3.0;    // cells past the edge: no point reaches further
constexpr double left_out = 4.0;  // cells at the inner end, where points are missing
/// Added to the diagonal, whose entries are about 0.4: keeps impulses small whose traction is zero. With the edge on a row of nodes, points
/// are midway between nodes, and impulses of alternating sign are such.
constexpr double unseen = 1e-3;

/// Weights of the nodes around a place.
struct Place {
  explicit Place(const Vec2& at) : x(at.x()), y(at.y()) {}
  AxisWeights x, y;
};

/// sum_k N_k(a) N_k(b), along one axis
double overlap(const AxisWeights& a, const AxisWeights& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const int j = a.first + static_cast<int>(i) - b.first;
    if (j >= 0 && j < 3) sum += a.w[i] * b.w[static_cast<std::size_t>(j)];
  }
  return sum;
}
double overlap(const Place& a, const Place& b) { return overlap(a.x, b.x) * overlap(a.y, b.y); }

}  // namespace

double edge_share(const Vec2& edge, const Vec2& inward, double spacing) {
  std::vector<Place> point;
  for (int i = 0; i < points; ++i) point.emplace_back(edge + (i + 0.5) * spacing * inward);
  const int samples = static_cast<int>((beyond + points * spacing - left_out) / step);
  Eigen::MatrixXd traction(samples, points);
  Eigen::VectorXd pressure(samples);
  for (int row = 0; row < samples; ++row) {
    const double s = (row + 0.5) * step - beyond;
    const Place at(edge + s * inward);
    pressure[row] = std::sqrt(std::max(s, 0.0));
    for (int i = 0; i < points; ++i) traction(row, i) = overlap(at, point[static_cast<std::size_t>(i)]);
  }
  Eigen::MatrixXd normal = traction.transpose() * traction * step;
  normal.diagonal().array() += unseen;
  const Eigen::VectorXd impulse = normal.ldlt().solve(traction.transpose() * pressure * step);
  return std::clamp(impulse[0] / impulse[1], 0.0, 1.0);
}

}  // namespace mpm
