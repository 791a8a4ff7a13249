#pragma once
/// Force and moment of the snow on the obstacle, from the impulses at grid nodes (exact sums over the steps); and the force while it
/// varies: peaks, rise time, first impact.

#include "libmpm/impact/steady.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Means over the interval before each sample, for the whole obstacle or arm, even if half is computed.
class ContactForce : public Observer {
 public:
  /// What the force is on.
  enum class On : std::uint8_t { obstacle, arm };

  /// @param boundary  its index in Scene::boundaries
  explicit ContactForce(std::size_t boundary, On on = On::obstacle) : boundary_(boundary), on_(on) {}

  [[nodiscard]] std::string name() const override { return on_ == On::arm ? "arm_force" : "contact_force"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }

  [[nodiscard]] std::vector<Column> columns() const override {
    const bool arm = on_ == On::arm;
    auto columns = vector_columns({.quantity = arm ? "arm_force" : "force",
                                   .unit = "N",
                                   .meaning = arm ? "force of the snow on the arm" : "force of the snow on the obstacle, without its arm",
                                   .kind = Column::Kind::interval_mean,
                                   .mean = true});
    const char* const of_arm = "moment of the snow on the arm about the foot of the centre of the obstacle's front face";
    for (const Column& c : vector_columns({.quantity = arm ? "arm_moment" : "moment",
                           .unit = "N m",
                           .meaning = arm ? of_arm : "moment of the snow on the obstacle about the foot of the front face's centre",
                           .kind = Column::Kind::interval_mean,
                           .mean = true}))
      columns.push_back(c);
    return columns;
  }

  void after_step(const StepReport& report, const State&) override {
    linear_ += report.impulses[boundary_].linear;
    angular_ += report.impulses[boundary_].angular;
  }

  void sample(const Instant& now, std::span<double> row) override {
    if (now.interval > 0.0) {  // the first sample has no interval: its row stays unknown
      const MirrorPlanes& mirror = now.live->scene.mirror;
      const Vec3 force = whole_force(linear_ / now.interval, mirror), moment = whole_moment(angular_ / now.interval, mirror);
      std::copy_n(force.data(), 3, row.begin());
      std::copy_n(moment.data(), 3, row.begin() + 3);
    }
    linear_ = angular_ = Vec3::Zero();
  }

 private:
  std::size_t boundary_;
  On on_;
  Vec3 linear_ = Vec3::Zero(), angular_ = Vec3::Zero();  // N s and N m s since the previous sample, of the computed part
};

/// Raw values are those of the means over sampling intervals, which are exact impulses over time; filtered ones are of a moving mean over
/// several of them, with no force before the first. The overturning moment is that about an axis along y at the base of the mast. NaN:
/// unknown.
struct ForcePeaks {
  double interval = MeanEstimate::none, window = MeanEstimate::none;  ///< s: sampling interval, window of the moving mean
  double peak = MeanEstimate::none, peak_time = MeanEstimate::none;   ///< N and s (middle of the interval), of the stream-wise force F_x
  double filtered_peak = MeanEstimate::none, filtered_peak_time = MeanEstimate::none;  ///< N, s (middle of the window)
  double rise_time = MeanEstimate::none;  ///< s: of the filtered force from 10 to 90 % of its peak, first passages, linear between samples
  double first_impact_until = MeanEstimate::none;  ///< s: arrival + 2 v/g, when the first splash has fallen back, or the end of the series
  double first_impact_impulse = MeanEstimate::none;                                ///< N s: of F_x from the arrival until then
  double moment_peak = MeanEstimate::none, moment_peak_time = MeanEstimate::none;  ///< N m, s
  double moment_filtered_peak = MeanEstimate::none;                                ///< N m
};

/// Moment about the line along y through (x, *, 0), N m, from that about the line through the origin: M_y + x F_z, since M' = M - r x F.
/// @param x  m
[[nodiscard]] std::vector<double> overturning_moment(std::span<const double> moment_y, std::span<const double> force_z, double x);

/// @param time s, evenly spaced. @param force_x N, @param moment_y N m: means over the intervals before each time; the first is not used
/// @param window s, of the moving mean; rounded down to whole samples, at least one
[[nodiscard]] ForcePeaks force_peaks(std::span<const double> time, std::span<const double> force_x, std::span<const double> moment_y,
                                     const ImpactFlow& flow, double window);

/// Has no columns: its entries of results.json follow from those of ContactForce.
class TransientForce : public Observer {
 public:
  /// @param window s, of the moving mean. @param axis m, x of the mast's own axis: the overturning moment is about the line along y that
  /// crosses this axis at the ground
  TransientForce(const ImpactFlow& flow, double window, double axis = 0.0) : flow_(flow), window_(window), axis_(axis) {}

  [[nodiscard]] std::string name() const override { return "transient_force"; }
  [[nodiscard]] MeasuredFrom measured_from() const override {
    return MeasuredFrom::run;
  }  // between two frames the force is only known as a mean
  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override;

 private:
  ImpactFlow flow_;
  double window_, axis_;
};

/// Has no columns: the highest forces on the arm, along the flow and upwards, and its moment about the mast's axis, from those of
/// ContactForce.
class ArmLoads : public Observer {
 public:
  /// @param window  s, of the moving mean. @param axis m, x of the mast's own axis
  ArmLoads(const ImpactFlow& flow, double window, double axis) : flow_(flow), window_(window), axis_(axis) {}

  [[nodiscard]] std::string name() const override { return "arm_loads"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }
  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override;

 private:
  ImpactFlow flow_;
  double window_, axis_;
};

}  // namespace mpm
