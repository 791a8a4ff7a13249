#include "libmpm/campaign/input_columns.hpp"

#include <limits>

#include "libmpm/impact/semi_empirical.hpp"

namespace mpm {

const std::vector<InputColumn>& input_columns() {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto belt = [](auto get) { return [=](const Case& c) { return c.conveyor ? get(*c.conveyor, c) : none; }; };
  const auto mast = [](auto get) { return [=](const Case& c) { return c.obstacle ? get(*c.obstacle, c) : none; }; };
  const auto snow = [](auto get) {
    return [=](const Case& c) {
      const CamClay::Parameters* m = c.material.get_if<CamClay>();
      return m != nullptr ? get(*m) : none;
    };
  };
  static const std::vector<InputColumn> inputs{
      {"froude_number", "conveyor.froude_number", belt([](const ConveyorSpec& b, const Case& c) {
         return c.numerics.gravity > 0.0 ? froude_number(b.velocity, b.flow_height, c.numerics.gravity) : none;
       })},
      {"velocity_m_s", "conveyor.velocity_m_s", belt([](const ConveyorSpec& b, const Case&) { return b.velocity; })},
      {"flow_height_m", "conveyor.flow_height_m", belt([](const ConveyorSpec& b, const Case&) { return b.flow_height; })},
      {"conveyor_width_m", "conveyor.width_m", belt([](const ConveyorSpec& b, const Case&) { return b.width; })},
      {"gravity_m_s2", "numerics.gravity_m_s2", belt([](const ConveyorSpec&, const Case& c) { return c.numerics.gravity; })},
      {"critical_state_slope", "material.critical_state_slope", snow([](const CamClay::Parameters& m) { return m.critical_state_slope; })},
      {"cohesion_beta", "material.cohesion_beta", snow([](const CamClay::Parameters& m) { return m.cohesion_beta; })},
      {"hardening_xi", "material.hardening_xi", snow([](const CamClay::Parameters& m) { return m.hardening_xi; })},
      {"effective_friction", "", [](const Case& c) { return c.material.critical_state_ratio().value_or(none); }},
      {"plastic_compressibility", "", snow([](const CamClay::Parameters& m) {
         constexpr double quoted_at = 25e3;  // Pa; the paper's chi
         return plastic_compressibility(m.hardening_xi, quoted_at, m.preconsolidation_pressure,
                                        bulk_modulus(m.young_modulus, m.poisson_ratio));
       })},
      {"obstacle_width_m", "obstacle.width_m", mast([](const ObstacleSpec& o, const Case&) { return o.width(); })},
      {"relative_width", "",
       mast([](const ObstacleSpec& o, const Case& c) { return c.conveyor ? o.width() / c.conveyor->flow_height : none; })},
      {"obstacle_friction", "obstacle.friction", mast([](const ObstacleSpec& o, const Case&) { return o.friction; })},
      {"obstacle_friction_ratio", "obstacle.friction_ratio",
       mast([](const ObstacleSpec& o, const Case& c) { return o.friction / c.material.internal_friction().value_or(none); })},
      {"cell_size_m", "numerics.cell_size_m", [](const Case& c) { return c.numerics.cell_size; }},
  };
  return inputs;
}

}  // namespace mpm
