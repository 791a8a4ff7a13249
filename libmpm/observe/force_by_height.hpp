#pragma once
/// Stream-wise force on the obstacle by height, from the impulses of each grid layer: exact sums, not stresses.

#include "libmpm/impact/measure.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Force of one interval by height.
struct LayeredForce {
  std::vector<double> bins;   ///< N, in the bins of the pressure profile and, last, above them; they add up to the whole force
  double first_moment = 0.0;  ///< N m: sum of the layers' forces times their heights
};

/// A layer of nodes represents half a cell to either side: its force is distributed evenly over that, and folded back at the floor.
/// @param force N, of layers at lowest, lowest + dx, ... @param lowest m over the floor. @param cell_size dx, m
[[nodiscard]] LayeredForce force_by_height(std::span<const double> force, double lowest, double cell_size, const ImpactGeometry& geometry);

/// Mean force by height, for profile.csv and profiles.h5; the force above the pressure height, and the height of the resultant.
class ForceByHeight : public Observer {
 public:
  /// @param layered index of the obstacle in Scene::layered
  ForceByHeight(ImpactGeometry geometry, std::size_t layered) : geometry_(std::move(geometry)), layered_(layered) {}

  [[nodiscard]] std::string name() const override { return "force_by_height"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }
  void after_step(const StepReport& report, const State& state) override;
  void sample(const Instant& now, std::span<double> row) override;
  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override;
  [[nodiscard]] std::vector<HeightProfile> profiles(const Summary& end) const override;
  [[nodiscard]] Arrays save() const override { return {{"force_n", bins_}, {"first_moment_n_m", first_moment_}}; }
  void load(const Arrays& arrays, std::size_t samples) override;

 private:
  /// Bins of the profile, and one above them.
  [[nodiscard]] std::size_t width() const { return geometry_.profile_bins() + 1; }

  ImpactGeometry geometry_;
  std::size_t layered_;
  LayerImpulses layers_;              // since the previous sample, of the computed part
  std::vector<double> bins_;          // N, width() for each sample; NaN at the first
  std::vector<double> first_moment_;  // N m, one for each sample
};

}  // namespace mpm
