#pragma once
/// An observer only for tests; it shows that a new quantity needs one file.

#include <algorithm>
#include <limits>

#include "libmpm/observe/observer.hpp"

namespace mpm::testing {

/// The furthest position of snow downstream, now and since the start.
class TrialObserver : public Observer {
 public:
  [[nodiscard]] std::string name() const override { return "trial"; }
  [[nodiscard]] std::vector<Column> columns() const override {
    return {{.quantity = "trial_front", .unit = "m", .meaning = "largest x of all particles", .mean = true}};
  }
  [[nodiscard]] bool visits(const Vec3&, const Vec3&) const override { return true; }
  void visit(const ParticleBatch& batch) override {
    for (std::size_t i = 0; i < batch.size(); ++i) front_ = std::max(front_, batch[i].position.x());
  }
  void sample(const Instant&, std::span<double> row) override {
    row[0] = front_;
    largest_ = std::max(largest_, front_);
    front_ = -std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] std::vector<Result> summary(const Summary&) const override {
    return {{"trial_front_largest_m", largest_, "m", "largest x of all particles at any time"}};
  }
  [[nodiscard]] Arrays save() const override { return {{"largest_x_m", {largest_}}}; }
  void load(const Arrays& arrays, std::size_t) override { largest_ = stored_array(arrays, "largest_x_m", 1).front(); }

 private:
  double front_ = -std::numeric_limits<double>::infinity(), largest_ = front_;
};

}  // namespace mpm::testing
