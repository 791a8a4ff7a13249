#include "libmpm/impact/conveyor_spec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmpm/base/parameter.hpp"
#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/material/any_material.hpp"

namespace mpm {

namespace {

constexpr double least_upstream_cells = 4;  // inlet layer, the kernel's width and one free cell

void resolve_velocity(ConveyorSpec& belt, double gravity, ParameterReport& report) {
  const std::string froude = "conveyor.froude_number", velocity = "conveyor.velocity_m_s";
  if (!report.given(froude) && !report.given(velocity) && report.given("conveyor.inflow_csv")) return;  // the table gives it
  if (!report.given(froude) && !report.given(velocity))
    return report.problem("conveyor", "has no speed; give froude_number or velocity_m_s");
  if (!belt.froude_number) return;
  const double fr = *belt.froude_number;
  belt.froude_number.reset();
  if (!(gravity > 0.0) || !report.all_valid({froude, velocity, "conveyor.flow_height_m", "numerics.gravity_m_s2"})) return;
  belt.velocity = flow_velocity(fr, belt.flow_height, gravity);
  if (!(belt.velocity > 0.0 && belt.velocity <= fastest_speed)) {
    report.problem(froude, fmt::format("= {} makes a speed v = Fr sqrt(g H) of {} m/s; it has to be above 0 and at most {} m/s", fr,
                                       belt.velocity, fastest_speed));
  }
}

/// Distances that the file leaves out, in widths of the obstacle.
void resolve_window(ConveyorSpec& belt, const ConveyorSurroundings& around, ParameterReport& report) {
  const auto left_out = [&](const char* key) { return !report.given(key); };
  if (around.obstacle == nullptr) {
    if (left_out("conveyor.width_m") && report.valid("obstacle"))
      report.problem("conveyor.width_m", "is missing; without [obstacle] it does not follow from the obstacle's width, give it");
    return;
  }
  if (!report.all_valid({"material.model", "material.hardening_xi", "obstacle.width_m", "conveyor.window_size", "conveyor.flow_height_m"}))
    return;
  const double w = around.obstacle->width();
  if (belt.window_size == ConveyorSpec::WindowSize::paper) {
    const std::optional<double> xi = around.material.hardening_xi();
    if (left_out("conveyor.width_m")) belt.width = xi ? conveyor_width(*xi, w) : 12.0 * w;
    return;
  }
  if (!ObstacleSpec::plan_is_valid(TableReport(report, "obstacle")) || !(around.gravity > 0.0) ||
      !report.all_valid({"material.critical_state_slope", "material.cohesion_beta", "conveyor.velocity_m_s", "conveyor.froude_number"}))
    return;
  const WindowFlow flow{.froude = froude_number(belt.velocity, belt.flow_height, around.gravity),
                        .height = belt.flow_height,
                        .critical_state_ratio = around.material.critical_state_ratio().value_or(0.0)};
  const CompactWindow window = compact_window(flow, w, outline_of(around.obstacle->shape).bounds().max().x());
  if (left_out("conveyor.width_m")) belt.width = window.width;
  if (left_out("conveyor.upstream_length_m")) belt.upstream_length = window.upstream_length;
  if (left_out("conveyor.downstream_length_m")) belt.downstream_length = window.downstream_length;
}

void check_obstacle(const ConveyorSpec& belt, const ObstacleSpec& obstacle, ParameterReport& report) {
  if (!ObstacleSpec::plan_is_valid(TableReport(report, "obstacle"))) return;
  const Outline outline = outline_of(obstacle.shape);
  const double width = outline.bounds().sizes().y(), depth = outline.bounds().max().x();
  if (report.all_valid({"conveyor.width_m", "material.hardening_xi"}) && belt.width <= width) {
    const std::string turned = width == obstacle.width() ? "" : fmt::format(" ({:.6g} across the flow)", width);
    report.problem("obstacle.width_m",
                   fmt::format("= {}{} leaves no room on the belt, {} m wide; make it narrower, or give a larger conveyor.width_m",
                               obstacle.width(), turned, belt.width));
  }
  const bool window = belt.feed == ConveyorSpec::Feed::window;
  if (window && report.all_valid({"conveyor.feed", "conveyor.downstream_length_m"}) && belt.downstream_length < depth) {
    report.problem("conveyor.downstream_length_m",
                   fmt::format("= {} ends inside the obstacle; give at least its depth, {:.6g} m", belt.downstream_length, depth));
  }
  if (report.valid("conveyor.mirror_y") && belt.mirror_y && !outline.symmetric())
    report.problem("obstacle", "is not symmetric about y = 0, so that half of it cannot replace the whole; give conveyor.mirror_y = false");
}

/// Inflow that varies over height or in time.
void check_inflow(const ConveyorSpec& belt, const ConveyorSurroundings& around, ParameterReport& report) {
  const bool sheared = belt.slip_ratio < 1.0 && report.valid("conveyor.inflow_slip_ratio");
  if (sheared && belt.sidewall_contact != Contact::slip && report.valid("conveyor.sidewall_contact")) {
    report.problem("conveyor.inflow_slip_ratio",
                   "is below 1, and side walls that move at one speed would even the flow out; give sidewall_contact = \"slip\"");
  }
  if (belt.inflow.empty() || !report.valid("conveyor.inflow")) return;
  if (belt.feed != ConveyorSpec::Feed::window && report.valid("conveyor.feed"))
    report.problem("conveyor.inflow[0]",
                   "is given beside feed = \"strip\", all of whose snow is there from the start; give feed = \"window\"");
  if (sheared)
    report.problem("conveyor.inflow[0]", "is given beside inflow_slip_ratio; inflow that varies in time enters as a plug, leave one out");
  for (std::size_t i = 0; i < belt.inflow.size(); ++i) {
    const auto key = [&](std::size_t row, const char* name) { return fmt::format("conveyor.inflow[{}].{}", row, name); };
    const InflowPoint& p = belt.inflow[i];
    if (i > 0 && !(p.time > belt.inflow[i - 1].time) && report.all_valid({key(i, "time_s"), key(i - 1, "time_s")})) {
      report.problem(key(i, "time_s"),
                     fmt::format("= {} is not above that of the row before, {}; sort the rows", p.time, belt.inflow[i - 1].time));
    }
    if (p.flow_height && *p.flow_height < around.cell_size && report.all_valid({key(i, "flow_height_m"), "numerics.cell_size_m"})) {
      report.problem(key(i, "flow_height_m"),
                     fmt::format("= {} is less than one cell; give at least cell_size_m = {} m", *p.flow_height, around.cell_size));
    }
    if (p.density_ratio > 1.0 && !around.material.keeps_compaction() && report.all_valid({key(i, "density_ratio"), "material.model"})) {
      report.problem(key(i, "density_ratio"),
                     fmt::format("= {} asks for snow that was compacted before; {} does not keep compaction, leave it out", p.density_ratio,
                                 around.material.name()));
    }
  }
}

void check_lengths(const ConveyorSpec& belt, double cell_size, ParameterReport& report) {
  if (!report.valid("numerics.cell_size_m")) return;
  if (report.valid("conveyor.flow_height_m") && belt.flow_height < cell_size) {
    report.problem("conveyor.flow_height_m", fmt::format("= {} is less than one cell; give at least cell_size_m = {} m, or finer cells",
                                                         belt.flow_height, cell_size));
  }
  const bool window = belt.feed == ConveyorSpec::Feed::window;
  if (window && report.valid("conveyor.upstream_length_m") && belt.upstream_length < least_upstream_cells * cell_size) {
    report.problem("conveyor.upstream_length_m", fmt::format("= {} leaves no room between inlet and obstacle; give at least {} cells, {} m",
                                                             belt.upstream_length, least_upstream_cells, least_upstream_cells * cell_size));
  }
  const double front = belt.flow_height / std::tan(belt.front_angle);
  if (window && report.all_valid({"conveyor.upstream_length_m", "conveyor.flow_height_m", "conveyor.front_angle_deg"}) &&
      front > belt.upstream_length) {
    report.problem("conveyor.front_angle_deg",
                   fmt::format("= {:.4g} makes a front {:.4g} m long, of which the window has {:.4g} m; give a steeper one or a longer "
                               "upstream_length_m",
                               belt.front_angle * 180.0 / std::numbers::pi, front, belt.upstream_length));
  }
}

}  // namespace

CompactWindow compact_window(const WindowFlow& flow, double width, double depth) {
  const double reach = std::max(width, std::sqrt(width * flow.height));
  const bool jams = flow.critical_state_ratio > jamming_ratio && flow.froude < fastest_jam;
  return {.width = std::max(8.0 * width, 6.0 * reach),
          .upstream_length = (jams ? 10.0 : 4.0) * reach,
          .downstream_length = depth + (jams                ? 4.0
                                        : flow.froude < 1.0 ? 2.0
                                                            : 1.0) *
                                           reach};
}

void resolve_conveyor(ConveyorSpec& belt, const ConveyorSurroundings& around, ParameterReport& report) {
  if (report.valid("numerics.gravity_m_s2") && !(around.gravity > 0.0)) {
    report.problem("numerics.gravity_m_s2",
                   "= 0 is given beside [conveyor], whose run-up and Froude number need gravity; give more than 0, or a scene of [[body]]");
  }
  resolve_velocity(belt, around.gravity, report);
  resolve_window(belt, around, report);
  if (around.obstacle != nullptr) check_obstacle(belt, *around.obstacle, report);
  check_inflow(belt, around, report);
  check_lengths(belt, around.cell_size, report);
}

}  // namespace mpm
