#pragma once
/// Run-up on the obstacle: the height of the snow before its front, without single particles, and the paper's highest particle (Sect. 2.3).

#include <utility>
#include <vector>

#include "libmpm/impact/measure.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Heights of one instant, m; 0 without particles.
struct RunupHeights {
  double highest = 0.0;  ///< h_r of the paper: highest particle in the strip upstream of the front
  double p99 = 0.0;      ///< height that holds 99 % of the mass in the strip within H of the front, which does not depend on how much
                         ///< avalanche is computed upstream, and hardly on single particles
};

/// Run-up at each sample, and its highest value.
class Runup : public Observer {
 public:
  /// @param geometry  of the measurement
  explicit Runup(ImpactGeometry geometry) : geometry_(std::move(geometry)) {}

  [[nodiscard]] std::string name() const override { return "runup"; }
  [[nodiscard]] std::vector<Column> columns() const override {
    return {
        {.quantity = "runup", .unit = "m", .meaning = "run-up: highest particle upstream of the obstacle and near its axis", .mean = true},
        {.quantity = "runup_p99",
         .unit = "m",
         .meaning = "run-up: height that holds 99 % of the mass of the snow near the axis, within H upstream of the obstacle",
         .mean = true}};
  }
  [[nodiscard]] bool visits(const Vec3& low, const Vec3& high) const override { return geometry_.may_measure(low, high); }
  void visit(const ParticleBatch& batch) override;
  void sample(const Instant& now, std::span<double> row) override;
  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override;

  /// @param position m @param mass kg
  void add(const Vec3& position, double mass);
  /// Evaluates the added particles, and starts again.
  [[nodiscard]] RunupHeights finish();

 private:
  ImpactGeometry geometry_;
  double highest_ = 0.0;
  std::vector<std::pair<double, double>> near_;  // z and mass of the particles within H of the front
};

}  // namespace mpm
