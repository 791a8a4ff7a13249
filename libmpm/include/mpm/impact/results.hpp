#pragma once
/// From the time series of an impact to the figures of results.json and the rows of profile.csv.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mpm/impact/measure.hpp"
#include "mpm/impact/steady.hpp"
#include "mpm/types.hpp"

namespace mpm {

/// Stream-wise force on the obstacle by height, from what each grid layer took: exact sums of impulses, not stresses.
struct ForceByHeight {
  std::vector<double> bins;   ///< N, in the bins of the pressure profile and, last, above them; they add up to the whole force
  double first_moment = 0.0;  ///< N m: sum of the layers' forces times their heights
};

/// A layer of nodes stands for half a cell to either side: its force is spread evenly over that, folded back at the floor.
/// @param force N, of layers at lowest, lowest + dx, ... @param lowest m over the floor. @param cell_size dx, m
[[nodiscard]] ForceByHeight force_by_height(std::span<const double> force, double lowest, double cell_size, const ImpactGeometry& geometry);

/// What was measured at each sample instant, by columns of one length. Evenly spaced in time.
struct ImpactSeries {
  std::vector<double> time;             ///< s
  std::vector<double> runup;            ///< m
  std::vector<double> runup_p99;        ///< m
  std::vector<double> pressure_height;  ///< m; NaN where undefined
  std::vector<double> impact_pressure;  ///< Pa
  std::vector<double> compaction;       ///< dimensionless
  std::vector<Vec3> force;   ///< N, of snow on the whole obstacle: impulse since the sample before over the time since then; NaN if unknown
  std::vector<Vec3> moment;  ///< N m, the same, about the centre of the front face's foot
  std::size_t profile_bins = 0;
  std::vector<double> profile_pressure;  ///< Pa, profile_bins values for each sample
  /// Force by height over the interval before, profile_bins + 1 values for each sample, N, and its first moment, N m; NaN where unknown.
  /// Both empty if no force was booked by height (measurements from frames).
  std::vector<double> force_bins, force_first_moment;

  [[nodiscard]] std::size_t size() const { return time.size(); }
  /// @throws ConfigError if the number of bins differs from that of the samples before, or forces by height are given for some only.
  void append(double sample_time, const ImpactFrame& frame, const Vec3& mean_force, const Vec3& mean_moment,
              const std::optional<ForceByHeight>& by_height = {});
};

/// The flow that hits the obstacle.
struct ImpactFlow {
  double velocity = 0.0;                     ///< v, m/s
  double gravity = 9.81;                     ///< g, m/s^2
  double arrival = 0.0;                      ///< s; the conveyor's front stands at the face at t = 0
  std::optional<double> effective_friction;  ///< M'; empty for laws that have none: no prediction
};

/// The force while it varies. Raw figures are of the means over sampling intervals, which are exact impulses over time; filtered ones of a
/// moving mean over an odd number of them. The overturning moment is that about the axis y through the foot, M_y.
struct TransientForce {
  double interval = MeanEstimate::none, window = MeanEstimate::none;  ///< s: sampling interval, window of the moving mean
  double peak = MeanEstimate::none, peak_time = MeanEstimate::none;   ///< N and s (middle of the interval), of the stream-wise force F_x
  double filtered_peak = MeanEstimate::none, filtered_peak_time = MeanEstimate::none;  ///< N, s (middle of the window)
  double rise_time = MeanEstimate::none;  ///< s: of the filtered force from 10 to 90 % of its peak, first passages, linear between samples
  double first_impact_until = MeanEstimate::none;    ///< s: arrival + 2 v/g, when the first splash is back, or the end of the series
  double first_impact_impulse = MeanEstimate::none;  ///< N s: of F_x from the arrival until then
  double moment_peak = MeanEstimate::none, moment_peak_time = MeanEstimate::none;  ///< N m, s
  double moment_filtered_peak = MeanEstimate::none;                                ///< N m
};

/// @param window s, of the moving mean; taken to the nearest odd number of samples below
[[nodiscard]] TransientForce transient_force(const ImpactSeries& series, const ImpactFlow& flow, double window);

/// Figures of one impact. Means are over the steady span, one weight a sample (forces: averages over the sampling interval); all their
/// members are NaN where there is none. Peaks are over the whole series.
struct ImpactSummary {
  Steady span;  ///< of the run-up; every other mean is taken over the same span, so that the figures belong to one state of the flow
  MeanEstimate runup, runup_p99, pressure_height;    ///< m
  MeanEstimate impact_pressure;                      ///< Pa
  MeanEstimate compaction;                           ///< dimensionless
  std::array<MeanEstimate, 3> force;                 ///< N
  std::array<MeanEstimate, 3> moment;                ///< N m
  double runup_peak = MeanEstimate::none;            ///< m
  double pressure_height_peak = MeanEstimate::none;  ///< m
  double pressure_height_of_mean_profile =
      MeanEstimate::none;                                   ///< m: h_p of the time-mean profile, where pressure_height is the mean of h_p
  double profile_force = MeanEstimate::none;                ///< N: mean profile integrated over the face; compare with force[0]
  double force_above_pressure_height = MeanEstimate::none;  ///< N: mean stream-wise force on what is above the mean pressure height
  double force_resultant_height = MeanEstimate::none;       ///< m: height at which the mean stream-wise force acts
  bool force_by_height = false;                             ///< whether the series knows the two above
  std::optional<TransientForce> transient;                  ///< empty: not measured
  double predicted_runup = MeanEstimate::none, predicted_pressure_height = MeanEstimate::none;  ///< m, Eqs. 7-10 (regressed for w = H)
};

/// @throws ConfigError if the columns are not of one length, or see find_steady.
[[nodiscard]] ImpactSummary summarise(const ImpactSeries& series, const ImpactGeometry& geometry, const ImpactFlow& flow);

/// One bin of the time-mean profile.
struct ProfileRow {
  double z;         ///< m, bin centre
  double pressure;  ///< Pa: mean of the instants' pressures (an instant's empty bin counts as 0), as the paper averages its profiles
  double smoothed;  ///< Pa: by the filter that the pressure height uses
  double force_per_height;    ///< N/m: pressure times the obstacle's width w: the strip |y| <= 3w/7 stands for the whole face; 0 above it
  double force_x_per_height;  ///< N/m: what the obstacle took there, from the impulses (force_by_height); NaN if not booked
};

/// Rows from the floor up; none without a steady span.
[[nodiscard]] std::vector<ProfileRow> mean_profile(const ImpactSeries& series, const Steady& span, const ImpactGeometry& geometry);

/// Stream-wise force of a profile on the face, N: sum of force_per_height times the bin height.
[[nodiscard]] double profile_force(const std::vector<ProfileRow>& profile, const ImpactGeometry& geometry);

/// The summary as one JSON object with the keys of results.json (`runup_mean_m`, `runup_standard_error_m`, ...; vectors as arrays of
/// three); null where there is no figure. Each `X_mean_UNIT` has an `X_standard_error_UNIT` and an `X_effective_samples`.
[[nodiscard]] std::string to_json(const ImpactSummary& summary);

}  // namespace mpm
