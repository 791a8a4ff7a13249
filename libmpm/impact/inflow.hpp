#pragma once
/// Inflow of the conveyor's window: speed, height and density over time, and speed over height.
///
/// Over time: linear between the rows of [[conveyor.inflow]], constant before the first and after the last. Over height, steady only:
/// u(z) = v r(z/H), r(h) = s + (1 - s)(1 + n) h^n, whose mean over the depth is 1; s = u(0)/v is the slip ratio, n the exponent.
///
/// The floor is frictionless, so that only the inlet maintains a sheared profile. Downstream the snow's internal friction reduces the
/// shear, with accelerations of at most tan(phi) g. Over the distance L to the obstacle a difference of speed falls by up to
/// tan(phi) g L / v. A short window preserves the profile.

#include <filesystem>
#include <vector>

#include "libmpm/impact/conveyor_spec.hpp"

namespace mpm {

/// Functions of time and height that follow from the rows of [[inflow]].
class Inflow {
 public:
  /// @param conveyor  resolved and checked
  explicit Inflow(const ConveyorSpec& conveyor);

  [[nodiscard]] bool steady() const { return points_.size() == 1; }  ///< nothing varies in time
  [[nodiscard]] bool sheared() const { return slip_ratio_ < 1.0; }   ///< speed varies over height

  [[nodiscard]] double velocity(double time) const { return interpolated(time, &Point::velocity); }        ///< v, mean over the depth, m/s
  [[nodiscard]] double flow_height(double time) const { return interpolated(time, &Point::flow_height); }  ///< H, m
  [[nodiscard]] double density_ratio(double time) const { return interpolated(time, &Point::density_ratio); }  ///< over rho_0
  [[nodiscard]] double travelled(double time) const;  ///< int v dt since t = 0, exactly, m
  [[nodiscard]] double fastest() const;               ///< v at its greatest, m/s
  [[nodiscard]] double highest() const;               ///< H at its greatest, m

  /// r at a relative height z/H; constant below 0 and above 1.
  [[nodiscard]] double shear(double relative_height) const;
  /// Mean of r between two relative heights in [0, 1]: with it the mean speed of the rows of particles is v, to round-off.
  [[nodiscard]] double mean_shear(double from, double to) const;

 private:
  struct Point {
    double time, velocity, flow_height, density_ratio;
    double travelled;  ///< since the first point
  };
  /// The points on either side of `time`, and the fraction of the interval between them.
  struct Between {
    const Point *a, *b;
    double fraction;
  };
  [[nodiscard]] Between between(double time) const;
  /// A quantity of the points, linear between them.
  [[nodiscard]] double interpolated(double time, double Point::*what) const;
  [[nodiscard]] double travelled_since_first(double time) const;
  std::vector<Point> points_;
  double slip_ratio_, exponent_;
};

class ParameterReport;

/// Converts [conveyor] inflow_csv to rows of [[conveyor.inflow]], so that the case does not depend on the file. Columns: time_s, depth_m,
/// velocity_m_s, and optionally density_kg_m3, which becomes the ratio to the material's density. If the conveyor's own speed or height is
/// not given, it is taken from the row with the greatest momentum flux v^2 H, so that 2 v/g and the equations refer to the strongest flow.
/// Does nothing without inflow_csv. Problems name the file, the row and the remedy.
/// @param folder   of the case file, to which the name is relative
/// @param density  of the material, kg/m^3
void read_inflow_csv(ConveyorSpec& belt, const std::filesystem::path& folder, double density, ParameterReport& report);

}  // namespace mpm
