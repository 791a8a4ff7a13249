#pragma once
/// Sums over all snow: particles, mass, momentum, energies, and the largest speed.

#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Sums over the whole domain, including the images beyond mirror planes (diagnostics.hpp).
class Conservation : public Observer {
 public:
  [[nodiscard]] std::string name() const override { return "conservation"; }
  [[nodiscard]] Source source() const override { return Source::run; }  // frames hold neither C nor enough digits

  [[nodiscard]] std::vector<Column> columns() const override {
    std::vector<Column> columns = {{.quantity = "particles", .meaning = "number of particles"},
                                   {.quantity = "mass", .unit = "kg", .meaning = "mass of the snow"}};
    for (const Column& c : vector_columns({.quantity = "momentum", .unit = "kg m/s", .meaning = "momentum of the snow"}))
      columns.push_back(c);
    columns.push_back({.quantity = "kinetic_energy", .unit = "J", .meaning = "kinetic energy of the particle velocities"});
    columns.push_back({.quantity = "elastic_energy", .unit = "J", .meaning = "stored elastic energy"});
    columns.push_back({.quantity = "potential_energy", .unit = "J", .meaning = "potential energy, zero at the origin"});
    columns.push_back({.quantity = "max_speed", .unit = "m/s", .meaning = "speed of the fastest particle"});
    return columns;
  }

  void sample(const Instant& now, std::span<double> row) override {
    const Totals t = whole_of_mirrored(now.live->totals, now.live->scene.mirror);
    const double values[] = {static_cast<double>(t.particles),
                             t.mass,
                             t.momentum.x(),
                             t.momentum.y(),
                             t.momentum.z(),
                             t.kinetic_energy,
                             t.elastic_energy,
                             t.potential_energy,
                             now.live->state.max_speed};
    std::ranges::copy(values, row.begin());
  }
};

}  // namespace mpm
