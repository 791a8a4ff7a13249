#pragma once
/// Particles behind the surface of the obstacle or of its arm, where no snow can be: an error of the contact.

#include <algorithm>

#include "libmpm/boundary/outline.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Counts the particles deeper than 0.1 dx behind the nearest face, and adds up their volumes. Contact lets particles pass the surface
/// slightly, at most by some hundredths of a cell where it works. The largest depth counts every particle.
class ParticlesInsideObstacle : public Observer {
 public:
  static constexpr double counted_cells = 0.1;     ///< depth in cells from which a particle counts
  static constexpr double tolerated_share = 0.01;  ///< of the obstacle's volume: above it the run ends with a warning

  /// Numbers of the case.
  struct Setting {
    double cell_size;          ///< dx, m
    double density;            ///< rho_0, kg/m^3
    double snow_depth;         ///< m: of the flow, or of the bodies at the start
    MirrorPlanes mirror = {};  ///< numbers and volumes are those of the whole flow
  };
  /// @param solids  the obstacle first. @param setting  numbers of the case
  ParticlesInsideObstacle(std::vector<UprightSolid> solids, const Setting& setting) : solids_(std::move(solids)), setting_(setting) {}

  [[nodiscard]] std::string name() const override { return "particles_inside_obstacle"; }
  [[nodiscard]] std::vector<Column> columns() const override {
    return {{.quantity = "particles_inside_obstacle",
             .meaning = "particles deeper than 0.1 cells behind the surface of the obstacle or its arm"},
            {.quantity = "volume_inside_obstacle", .unit = "m^3", .meaning = "their present volume, that is, compacted or loosened"},
            {.quantity = "depth_inside_obstacle",
             .unit = "m",
             .meaning = "largest distance of a particle behind the nearest surface of the obstacle; 0: none is behind it"}};
  }

  [[nodiscard]] bool visits(const Vec3& low, const Vec3& high) const override {
    const Eigen::AlignedBox3d box(low, high);
    return std::ranges::any_of(solids_, [&](const UprightSolid& solid) { return solid.bounds().intersects(box); });
  }
  void visit(const ParticleBatch& batch) override {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const ParticleView p = batch[i];
      double inside = -solids_.front().distance(p.position);
      for (std::size_t s = 1; s < solids_.size(); ++s) inside = std::max(inside, -solids_[s].distance(p.position));
      depth_ = std::max(depth_, inside);
      if (inside <= counted_cells * setting_.cell_size) continue;
      count_ += 1.0;
      volume_ += p.mass / setting_.density * p.volume_ratio();
    }
  }
  void sample(const Instant&, std::span<double> row) override {
    row[0] = setting_.mirror.parts() * count_;
    row[1] = setting_.mirror.parts() * volume_;
    row[2] = depth_;
    count_ = volume_ = depth_ = 0.0;
  }

  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override {
    const auto last = [&](std::string_view column) {
      const auto values = end.series[column];
      return values.empty() ? MeanEstimate::none : values.back();
    };
    const UprightSolid& obstacle = solids_.front();
    const double volume = last("volume_inside_obstacle_m3");
    return {
        {"particles_inside_obstacle", last("particles_inside_obstacle"), "",
         "particles deeper than 0.1 cells behind the surface of the obstacle or its arm at the end, where no snow can be"},
        {"volume_inside_obstacle_m3", volume, "m^3", "their volume"},
        {"share_inside_obstacle", volume / (obstacle.outline.area() * std::min(obstacle.top - obstacle.foot(), setting_.snow_depth)), "",
         "that volume over the obstacle's own from its foot up to the flow height (without a conveyor: to the top of the bodies at the "
         "start), or to its top if that is lower"},
        {"depth_inside_obstacle_m", last("depth_inside_obstacle_m"), "m",
         "largest distance of a particle behind the nearest surface of the obstacle at the end"}};
  }

 private:
  std::vector<UprightSolid> solids_;
  Setting setting_;
  double count_ = 0.0, volume_ = 0.0, depth_ = 0.0;  // of the computed part, since the previous sample; m^3, m
};

}  // namespace mpm
