#pragma once
/// Makes the Scene and the State of a case.

#include <optional>
#include <string>
#include <vector>

#include "libmpm/core/step.hpp"
#include "libmpm/driver/case.hpp"

namespace mpm {

class BlockExchange;
class ParameterReport;
struct ConveyorSetting;

/// The mirror planes of a case, of its domain or of its conveyor.
[[nodiscard]] MirrorPlanes mirror_planes(const Case& c);
/// Mirror planes stay on the grid: [numerics] grid_offset_cells is 0 across them. @param report  of [numerics]
void check_grid_offset(const Case& c, ParameterReport& report);

/// The rigid solids of a case: its obstacle, then the obstacle's arm; empty without an obstacle.
[[nodiscard]] std::vector<UprightSolid> solids_of(const Case& c);

/// What the conveyor of a case needs of the rest of it. @param ground  of the case; empty: none
[[nodiscard]] ConveyorSetting conveyor_setting(const Case& c, const std::shared_ptr<const HeightField>& ground);

/// Where particles may be in a case, m: its domain, cut by that of a conveyor. @param ground  of the case; empty: none
[[nodiscard]] Eigen::AlignedBox3d case_domain(const Case& c, const std::shared_ptr<const HeightField>& ground);

/// The scene of a case, and which of its boundaries are those whose forces are reported.
struct CaseScene : Scene {
  std::optional<std::size_t> obstacle;  ///< index of the obstacle
  std::optional<std::size_t> arm;       ///< of its arm
};

/// Law, walls, obstacle, particle source and domain of a case. @throws ConfigError
CaseScene make_scene(const Case& c);

/// The particles of t = 0: bodies and the conveyor's plug.
/// A body is a lattice that fills its shape with the body's exact volume; with mirror planes only the computed part is filled, and on
/// uneven ground only what lies above it. Identity numbers run from 0 in the order of the bodies, x fastest.
/// @param ranks  not null: all ranks call this, the others when the first is in it (Task::start). The blocks are divided evenly by their
///        particles, which are counted first, and no rank holds those of another. @throws ConfigError, on the first rank
State make_state(const Case& c, const Scene& scene, BlockExchange* ranks = nullptr);

/// One warning for every boundary that has particles inside (buried_particles). With a conveyor, whose snow starts behind the inlet, only
/// the obstacle and its arm are checked. Called on the first rank, for the particles of all ranks.
std::vector<std::string> particles_inside_boundaries(const State& state, const CaseScene& scene);

}  // namespace mpm
