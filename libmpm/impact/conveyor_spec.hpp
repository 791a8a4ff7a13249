#pragma once
/// The paper's set-up (Sect. 2.2), as a case gives it.

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/contact.hpp"
#include "libmpm/source/lattice.hpp"

namespace mpm {

class ParameterReport;
struct MaterialParameters;
struct ObstacleSpec;

/// [[conveyor.inflow]]: the inflow at one instant; linear between instants, constant before the first and after the last.
struct InflowPoint {
  double time = 0.0;                  ///< s
  std::optional<double> velocity;     ///< m/s, mean over the depth; empty: the conveyor's
  std::optional<double> flow_height;  ///< m; empty: the conveyor's
  double density_ratio = 1.0;         ///< density of the entering snow over rho_0, by compaction before it enters
  bool operator==(const InflowPoint&) const = default;

  /// The keys of [[conveyor.inflow]] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("time_s", &InflowPoint::time).unit("s").range(0.0, 1e6).required().text("Time of this row, above that of the row before");
    table.add("velocity_m_s", &InflowPoint::velocity)
        .unit("m/s")
        .positive(fastest_speed)
        .left_out("the conveyor's")
        .text("Speed of the incoming snow, of the belt and its side walls");
    table.add("flow_height_m", &InflowPoint::flow_height)
        .unit("m")
        .positive(1e3)
        .left_out("the conveyor's")
        .text("Height of the incoming snow");
    table.add("density_ratio", &InflowPoint::density_ratio)
        .range(1.0, 2.0)
        .text(
            "Density of the incoming snow over density_kg_m3: snow that was compacted, and so hardened, before it came. Above 1 with "
            "cohesive_cam_clay only");
  }
};

/// [conveyor]: the set-up of Sect. 2.2 of the paper.
struct ConveyorSpec {
  std::optional<double> froude_number;  ///< Fr = v / sqrt(g H), given instead of velocity, which resolve_conveyor computes from it
  double velocity = 0.0;                ///< v, m/s; 0: not given
  double flow_height = 1.75;            ///< H, m
  /// How far side walls, inlet and outlet are from the obstacle, if the file leaves it out.
  enum class WindowSize : std::uint8_t { compact, paper } window_size = WindowSize::compact;  ///< which of the two rules
  double width = 21.0;                                                                        ///< W, m
  /// How snow enters: a plug through a window, or a strip of finite length.
  enum class Feed : std::uint8_t { window, strip } feed = Feed::window;  ///< which of the two
  double upstream_length = 8.0;                                          ///< window: inlet at x = -upstream_length, m
  double downstream_length = 4.0;                                        ///< window: outlet at x = +downstream_length, m
  Contact sidewall_contact = Contact::no_slip;  ///< "coulomb" in a file is separable with friction: a wall cannot pull
  double sidewall_friction = 0.0;               ///< mu; separable only
  Lattice lattice = Lattice::staggered;         ///< where fresh particles lie; see the head of conveyor.hpp
  bool mirror_y = true;                         ///< compute y >= 0 only
  double slip_ratio = 1.0;      ///< s: sheared inflow u(z) = v (s + (1 - s)(1 + n)(z/H)^n), of depth mean v; 1 is the paper's plug
  double shear_exponent = 1.0;  ///< n
  double front_angle = 0.5 * std::numbers::pi;  ///< of the plug's front against the floor, rad; its foot is at the face at t = 0
  std::vector<InflowPoint> inflow;              ///< by ascending time; empty: steady
  std::optional<std::string> inflow_csv;        ///< file with these rows: read_inflow_csv converts it
  bool operator==(const ConveyorSpec&) const = default;

  /// The keys of [conveyor] (base/parameter.hpp), one statement each, in the order in which files and references list them.
  template <class Table>
  static void declare(Table& table) {
    table.add("froude_number", &ConveyorSpec::froude_number)
        .range(1e-3, 1e2)
        .left_out("velocity_m_s is given instead (one of the two is required)")
        .text("Fr = v / sqrt(g H); gives the speed of the belt");
    table.add("velocity_m_s", &ConveyorSpec::velocity)
        .unit("m/s")
        .positive(fastest_speed)
        .hide_default()
        .excludes("froude_number")
        .left_out("froude_number is given instead (one of the two is required)")
        .text("Speed v of the belt and of the incoming snow");
    table.add("flow_height_m", &ConveyorSpec::flow_height).unit("m").positive(1e3).text("Height H of the incoming snow");
    table.add("window_size", &ConveyorSpec::window_size, {"compact", "paper"})
        .hide_default()
        .text(
            "Rule for width_m, upstream_length_m and downstream_length_m that are left out. compact: from Fr 1 on the force "
            "changes by at most 2 %, of slower loose snow by more (docs/grid-studies.md); paper: the paper's width, which depends on "
            "hardening_xi, and 8 and 4 m");
    table.add("width_m", &ConveyorSpec::width)
        .unit("m")
        .positive(1e4)
        .left_out(
            "8 w, at least 6 r, with w the obstacle's width and r the larger of w and sqrt(w H); window_size = \"paper\": "
            "(6 + 3 log10(hardening_xi / 0.05)) w, 12 w for a law without hardening_xi")
        .text("Width W of the belt, both halves");
    table.add("feed", &ConveyorSpec::feed, {"window", "strip"})
        .text("window: a few metres around the obstacle, fresh snow enters at v; strip: the whole avalanche as particles");
    table.add("upstream_length_m", &ConveyorSpec::upstream_length)
        .unit("m")
        .positive(1e4)
        .only_with("feed", {"window"})
        .left_out("4 r; 10 r for snow of M' above 1.8 below Fr 5, which jams; 8 m without obstacle and with window_size = \"paper\"")
        .text("Inlet at x = -upstream_length_m; the obstacle's front face is x = 0");
    table.add("downstream_length_m", &ConveyorSpec::downstream_length)
        .unit("m")
        .positive(1e4)
        .only_with("feed", {"window"})
        .left_out("the obstacle's depth and r (below Fr 1: 2 r; if snow jams: 4 r); 4 m without obstacle and with window_size = \"paper\"")
        .text("Outlet at x = +downstream_length_m");
    table.add("sidewall_contact", &ConveyorSpec::sidewall_contact, {"no_slip", "slip", "coulomb"})
        .text(
            "Moving side walls: no_slip drags the snow along, slip is frictionless, coulomb slides with sidewall_friction and may lift "
            "off");
    table.add("sidewall_friction", &ConveyorSpec::sidewall_friction)
        .range(0.0, 10.0)
        .only_with("sidewall_contact", {"coulomb"})
        .required()
        .text("Coulomb coefficient of the side walls");
    table.add("lattice", &ConveyorSpec::lattice, {"staggered", "aligned", "random"})
        .text(
            "How layers of particles follow one another: staggered shifts each across the flow and in height, so that no gaps open where "
            "the mast spreads the flow; aligned is the plain lattice, whose particles keep to the same lines; random: Poisson discs");
    table.add("mirror_y", &ConveyorSpec::mirror_y).text("Compute the half y >= 0 only; results are for the whole");
    table.add("inflow_slip_ratio", &ConveyorSpec::slip_ratio)
        .range(0.0, 1.0)
        .hide_default()
        .only_with("feed", {"window"})
        .text(
            "Sheared inflow of depth mean v: u(z) = v (s + (1 - s)(1 + n)(z/H)^n) with s this ratio, u(0)/v, and n "
            "inflow_shear_exponent; below 1 with sidewall_contact = \"slip\"");
    table.add("inflow_shear_exponent", &ConveyorSpec::shear_exponent)
        .range(0.1, 10.0)
        .hide_default()
        .only_below("inflow_slip_ratio", 1.0)
        .text("Exponent n of the sheared inflow");
    table.add("front_angle_deg", &ConveyorSpec::front_angle)
        .degrees()
        .range(5.0, 90.0)
        .hide_default()
        .text("Angle of the avalanche's front at the start, with its foot at the obstacle; 90: a vertical wall of snow");
    table.add("inflow_csv", &ConveyorSpec::inflow_csv)
        .only_with("feed", {"window"})
        .left_out("[[conveyor.inflow]] or a steady inflow")
        .text(
            "Inflow over time from a table, relative to the case file: columns time_s, depth_m, velocity_m_s and, optionally, "
            "density_kg_m3. It becomes [[conveyor.inflow]]. Speed and height of the conveyor, if left out, are those of the row with the "
            "largest v^2 H");
  }
};

/// A flow, as far as the size of a window depends on it.
struct WindowFlow {
  double froude;                ///< Fr
  double height;                ///< H, m
  double critical_state_ratio;  ///< M' of the snow
};
/// Snow with a higher M' in slower flow (Fr) jams between the obstacle and an inlet 4.8 w away; up to M' = 1.76 twice the distance changes
/// heights by at most 3 %.
/// @{
inline constexpr double jamming_ratio = 1.8, fastest_jam = 5.0;
/// @}
/// Distances from an obstacle, m.
struct CompactWindow {
  double width;              ///< of the belt, both halves
  double upstream_length;    ///< from the obstacle's front face to the inlet
  double downstream_length;  ///< from the obstacle's front face to the outlet
};
/// The smallest window that from Fr 1 on changes the mean force by at most 2 % and the heights by some 1 % against one of 16 w, 6 w and 3
/// w. Measured for w = H, Fr 0.3 to 7 and three snows: docs/grid-studies.md. In loose snow below Fr 1 the force falls by 4 % for each
/// further w to the outlet: there is no snow yet downstream, and the outlet stands for it.
/// @param width  of the obstacle across the flow, w, m. @param depth  along the flow, m
[[nodiscard]] CompactWindow compact_window(const WindowFlow& flow, double width, double depth);

/// Other parameters that those of a conveyor depend on.
struct ConveyorSurroundings {
  double cell_size, gravity;           ///< m, m/s^2
  const MaterialParameters& material;  ///< gives xi
  const ObstacleSpec* obstacle;        ///< null: none
};

/// Fills in what follows from other parameters (velocity from froude_number, width from the law's xi and the obstacle), and checks
/// conditions between parameters of the conveyor, the obstacle and the grid. Names are paths: "conveyor.width_m".
void resolve_conveyor(ConveyorSpec& conveyor, const ConveyorSurroundings& surroundings, ParameterReport& report);

}  // namespace mpm
