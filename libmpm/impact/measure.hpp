#pragma once
/// Geometry of the measurements at an obstacle (paper, Sect. 2.3 and Appendix A2): strip, impact box, bins of the pressure
/// profile; the pressure height of a profile, and its smoothing; the axis of a mast. The observers (observe/) use it.
///
/// Frame: x downstream with the obstacle's front face at x = 0, y across with its axis at y = 0, z up from the floor z = 0.
///
/// For a front other than that face (cylinder, wedge, turned box) the measurements follow the surface:
/// upstream is upstream of the surface at the same y; the impact box reaches as far from the surface as from the face, at
/// |y| <= 3w/7 with w the width of the whole obstacle across the flow; pressure is the one normal to the surface, -n.sigma.n with the
/// normal n of the nearest point. Its mean times w is the stream-wise force per height where it is uniform along the front, whatever the
/// shape.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/impact/measurement_spec.hpp"

namespace mpm {

/// Smooths equally spaced values: each one is replaced by the value, at its own place, of the polynomial of degree `order` fitted to the
/// `window` values around it (Savitzky and Golay 1964, Anal. Chem. 36, 1627).
///
/// Ends: the first and the last (window - 1)/2 values are taken from the one polynomial fitted to the first or last `window` values
/// (`mode='interp'` of scipy.signal.savgol_filter, its default), so that polynomials up to `order` pass unchanged everywhere.
/// @param window odd, > order, at most the number of values. @param order degree, >= 0.
/// @throws ConfigError when these do not hold.
[[nodiscard]] std::vector<double> savitzky_golay(std::span<const double> values, int window, int order);

/// Windows and filters of the measurements. Lengths in m.
struct ImpactGeometry {
  double flow_height;          ///< H
  double obstacle_width;       ///< w, across the flow
  double density;              ///< rho_0, kg/m^3
  bool mirror_y;               ///< only y >= 0 is computed: masses count twice (ratios of sums do not change)
  double strip_half_width;     ///< strip |y| <= this
  double box_upstream;         ///< the impact box reaches from x = -box_upstream ...
  double box_inside;           ///< ... to x = +box_inside: catches particles that penetrate the face slightly
  double bin_height;           ///< of the pressure profile
  double profile_height;       ///< of the pressure profile, from z = 0
  int filter_bins = 13;        ///< window of the Savitzky-Golay filter, odd
  int filter_order = 2;        ///< its degree
  double threshold = 0.05;     ///< fraction of the impact pressure at the pressure height
  double force_window = 0.1;   ///< s: of the moving mean behind the filtered peak of the force
  double box_area = 0.0;       ///< m^2: of the impact box in plan, upstream of the front
  double cell_volume;          ///< m^3, of the grid
  bool uneven_ground = false;  ///< the ground upstream may be higher than the snow at the obstacle
  UprightSolid obstacle;       ///< what is measured at: a box with its face at x = 0, unless set_obstacle is called

  /// Measures before this obstacle: its width, height and front.
  void set_obstacle(const ObstacleSpec& spec);

  /// Upper limit of the impact pressure: the flow height above the obstacle's foot, or the top of a lower obstacle.
  [[nodiscard]] double impact_top() const { return std::min(obstacle.foot() + flow_height, obstacle.top); }
  /// x of the front at y, m.
  [[nodiscard]] double front(double y) const { return obstacle.outline.section(y).value_or(Interval{}).low; }
  /// The volume ratio that a particle counts with: no particle fills more than a cell. The volume of snow that opens at a wall grows
  /// without bound; it bears no stress, and would outweigh all others. @param J  det F. @param mass  kg
  [[nodiscard]] double counted_ratio(double J, double mass) const { return std::min(J, cell_volume * density / mass); }
  /// Component of a symmetric tensor (xx yy zz xy xz yz) along the normal of the front near a position.
  [[nodiscard]] double normal_component(const Vec3& position, std::span<const double, 6> stress) const;

  [[nodiscard]] std::size_t profile_bins() const;  ///< of bin_height, from z = 0 to profile_height
  [[nodiscard]] double bin_centre(std::size_t bin) const { return (static_cast<double>(bin) + 0.5) * bin_height; }  ///< m above the floor

  /// Whether particles of a box may lie in the strip upstream of the obstacle's back: other particles are not measured.
  [[nodiscard]] bool may_measure(const Vec3& low, const Vec3& high) const {
    const double furthest = box_inside + (obstacle.outline.along_axes() ? 0.0 : obstacle.outline.bounds().max().x());
    return low[1] <= strip_half_width && high[1] >= -strip_half_width && low[0] <= furthest;
  }

  /// In the box from the foot of the obstacle to the top of the profile: only these particles' stress and J are measured.
  [[nodiscard]] bool in_profile_box(const Vec3& position) const {
    if (std::abs(position[1]) > strip_half_width || position[2] < obstacle.base || !(position[2] < std::min(profile_height, obstacle.top)))
      return false;
    if (position[0] < obstacle.outline.bounds().min().x() - box_upstream) return false;  // most of the flow: saves the distance
    const double before = obstacle.outline.nearest_of_front(position.head<2>()).distance;
    return before <= box_upstream && before >= -box_inside;
  }
};

/// The paper's procedure: strip |y| <= 3w/7 (0.75 m for w = 1.75 m), box from 2.5 dx upstream to 0.5 dx inside the face, bins of dx/2 up to
/// 5 H, filter of 13 bins and degree 2, threshold 5 %.
/// @param cell_size dx, m. @param windows lengths in metres that replace the paper's multiples of dx, if given.
/// @throws ConfigError for values that are not positive, a filter that is not an odd number of bins, or a cell too coarse for the filter
/// (fewer bins in 5 H than the filter spans).
[[nodiscard]] ImpactGeometry paper_geometry(double flow_height, double obstacle_width, double cell_size, double density, bool mirror_y,
                                            const MeasurementSpec& windows = {});

/// Pressure height h_p (Sect. 3.2), m: where the smoothed profile, going up, first falls below threshold * impact_pressure after it was at
/// or above it; linear between bin centres. A profile that never falls below gives profile_height, a lower
/// bound; no height is above the top of the obstacle. Empty if the impact
/// pressure is not positive or the smoothed profile is never at or above the threshold.
///
/// Smoothing biases it, the more the taller the bins: a hydrostatic profile, which passes the threshold at 0.975 H,
/// gives 1.16, 1.09, 1.04, 1.01 H at dx = 0.5, 0.35, 0.25, 0.175 m for H = 1.75 m, and a uniform pressure that ends at H
/// gives 1.42, 1.29, 1.21, 1.15 H.
/// @param pressure Pa, one a bin.
[[nodiscard]] std::optional<double> pressure_height(std::span<const double> pressure, double impact_pressure,
                                                    const ImpactGeometry& geometry);

}  // namespace mpm
