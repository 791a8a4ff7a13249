#pragma once
/// Force and moment of the snow on the obstacle, from the impulses at grid nodes: exact sums over the steps.

#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Means over the interval before each sample, for the whole obstacle, even if half is computed.
class ContactForce : public Observer {
 public:
  /// @param boundary index of the obstacle in Scene::boundaries
  explicit ContactForce(std::size_t boundary) : boundary_(boundary) {}

  [[nodiscard]] std::string name() const override { return "contact_force"; }
  [[nodiscard]] Source source() const override { return Source::run; }

  [[nodiscard]] std::vector<Column> columns() const override {
    auto columns = vector_columns({.quantity = "force",
                                   .unit = "N",
                                   .meaning = "force of the snow on the obstacle",
                                   .kind = Column::Kind::interval_mean,
                                   .mean = true});
    for (const Column& c : vector_columns({.quantity = "moment",
                           .unit = "N m",
                           .meaning = "moment of the snow on the obstacle about the foot of the front face's centre",
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
  Vec3 linear_ = Vec3::Zero(), angular_ = Vec3::Zero();  // N s and N m s since the previous sample, of the computed part
};

}  // namespace mpm
