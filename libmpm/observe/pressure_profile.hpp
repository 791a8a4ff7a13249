#pragma once
/// Pressure on the front of the obstacle (paper, Sect. 2.3 and Appendix A2): profile over height, impact pressure, pressure height; and the
/// compaction of the snow before it.

#include <optional>

#include "libmpm/impact/measure.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Pressure of one instant. Cauchy, positive in compression.
struct FrontPressure {
  double impact_pressure = 0.0;  ///< Pa: minus the volume average of sigma_xx over the impact box up to H, or to the top of a lower
                                 ///< obstacle (Eq. A4); from its foot
  std::optional<double> pressure_height;  ///< h_p, m; see pressure_height(). Empty where it is not defined
  double compaction = 0.0;       ///< mass in the impact box outside the obstacle, up to the same height, over its volume, over rho_0
  std::vector<double> pressure;  ///< Pa, one a bin: -sum tau_xx / sum J (Eq. A4), J as ImpactGeometry::counted_ratio; 0 in an empty bin
};

/// Profile, impact pressure, pressure height and compaction, at each sample and over the steady interval.
class PressureProfile : public Observer {
 public:
  /// @param geometry  of the measurement; its bins are those of the profile
  explicit PressureProfile(const ImpactGeometry& geometry);

  [[nodiscard]] std::string name() const override { return "pressure_profile"; }
  [[nodiscard]] std::vector<Column> columns() const override;
  [[nodiscard]] bool visits(const Vec3& low, const Vec3& high) const override { return geometry_.may_measure(low, high); }
  void visit(const ParticleBatch& batch) override;
  void sample(const Instant& now, std::span<double> row) override;
  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override;
  [[nodiscard]] std::vector<HeightProfile> profiles(const Summary& end) const override;
  [[nodiscard]] Arrays save() const override { return {{"pressure_pa", over_time_}}; }
  void load(const Arrays& arrays, std::size_t samples) override;

  /// @param position m. @param tau_nn Kirchhoff stress along the normal of the front (tau_xx before a face), Pa, tension positive.
  /// @param J > 0, the volume ratio that the particle counts with. @param mass kg, as computed (not doubled for the mirror).
  /// Particles slightly below the floor count to the lowest bin, as those slightly inside the obstacle count to the box.
  void add(const Vec3& position, double tau_nn, double J, double mass);
  /// Evaluates the added particles, and starts again.
  [[nodiscard]] FrontPressure finish();

 private:
  /// Of the time-mean profile, one value a bin. The mean is that of the instants' pressures (an instant's empty bin counts as 0), as the
  /// paper averages its profiles. All empty without a steady interval.
  struct MeanProfile {
    std::vector<double> pressure;          ///< Pa
    std::vector<double> smoothed;          ///< Pa, by the filter that the pressure height uses
    std::vector<double> force_per_height;  ///< N/m: pressure times the obstacle's width, between its foot and its top
  };
  [[nodiscard]] MeanProfile mean_profile(const Summary& end) const;

  ImpactGeometry geometry_;
  double stress_below_flow_height_ = 0.0, volume_below_flow_height_ = 0.0;  // sum tau_xx, sum J for z < H
  double mass_ = 0.0;                                                       // outside the obstacle, z < H
  std::vector<double> stress_, volume_;                                     // sum tau_xx, sum J a bin
  std::vector<double> over_time_;                                           // Pa, one a bin for each sample
};

}  // namespace mpm
