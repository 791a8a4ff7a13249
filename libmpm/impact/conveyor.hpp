#pragma once
/// The conveyor belt of Sect. 2.2: a plug of height H and width W that moves at v towards an obstacle.
///
/// Frame: front face of the obstacle at x = 0, axis y = 0, floor z = 0. The front of the plug is at the face at t = 0, so the
/// front arrives at t = 0; downstream is empty. Of an inclined front the foot is there, and the snow above its slope is left out.
///
/// - floor: frictionless, separable; none where uneven ground takes its place. Side walls |y| = W/2 move with v along x; they drag the
///   plug, or it slips along them.
/// - strip: the published set-up. All L = v t_max + 3 m of snow (Table 2) are particles; the rear is a free surface.
/// - window: the plug from the inlet x = -upstream to the outlet x = +downstream. Nodes at or behind the inlet move with v along x and are
///   free along y and z; new layers are released two cells behind it, each at the position of the plug at that time, so that the lattice
///   continues without gaps. At and beyond the outlet v_x <= v is imposed, in place of the snow that the window omits: otherwise the flow
///   would collapse over an edge. Particles two cells beyond the outlet have left.
///
/// Inflow that varies (inflow.hpp; window only). In time: each layer enters with the speed, height and density of its time, the nodes at
/// the inlet and the side walls move at the current speed, the outlet limits the speed to the greatest of all times. Denser snow was
/// compacted before: it has J = 1/ratio and the hardness that the law gives for it. Over height: rows of particles enter at their own
/// speeds, each row when it is due; the inlet's nodes impose the profile, the side walls are frictionless, the outlet limits the speed to
/// the profile.
///
/// Uneven ground (ConveyorSetting::ground) takes the place of the floor: the snow enters at its height above the ground, and moves at v
/// along x and v dh/dx along z. Side walls are then frictionless (a wall that moves along x would push the snow into a slope), and no
/// inflow is sheared.
///
/// The plug starts at rest under its own weight (see settled_column), so that neither the first nor a fresh column oscillates.
///
/// Lattice. Particles on the same lattice line follow the same stream line: where a mast spreads the flow, gaps open between the lines, at
/// any resolution, and in the dead zone before it the particles' pressure and density deviate from those of the flow (at Fr 2, M 0.8,
/// beta 0.3 the density rose to 1.29 and the pressure fell by half, while the force stayed the same). So each layer is
/// shifted within the lattice across the flow and in height by the points of source/lattice.hpp: any few layers in a row sample the
/// cross-section evenly. Across the flow two layers in a row have opposite shifts. Otherwise the density beside the mirror plane
/// oscillates with a period of 51 layers (validation/cases/bernoulli_head). For comparison: "aligned" is the plain lattice; "random" are
/// Poisson discs (source/lattice.hpp), of one mass in each row, so that 32 layers bring exactly the mass of 32 layers of the lattice.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "libmpm/boundary/terrain.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/impact/inflow.hpp"
#include "libmpm/impact/steady.hpp"
#include "libmpm/source/lattice.hpp"

namespace mpm {

/// One particle height of a laterally confined column that carries its own weight.
struct ColumnPoint {
  double height;                ///< settled height above the floor, m
  MaterialState<double> state;  ///< Kirchhoff stress and internal variable
};

/// Column of height H before settling, cut into `count` layers, compressed from the stress-free state until the Cauchy stress
/// sigma_zz = -rho_0 g (H - Z) in every layer (exact equilibrium of a confined column). The law itself is integrated along this oedometric
/// path from the top down, so that the lateral stress is the law's own K_0, elastic or plastic.
/// @param weight rho_0 g, N/m^3, >= 0. @param density_ratio of the stress-free snow over rho_0, >= 1: it starts from the internal variable
/// X_0 + log(ratio) of snow compacted by that much (Cam-Clay; 1 for every other law). @throws UnstableError if the law cannot carry the
/// weight
std::vector<ColumnPoint> settled_column(const AnyMaterial& material, double weight, double height, int count, double density_ratio = 1.0);

/// Properties of the computation that the conveyor needs.
struct ConveyorSetting {
  double cell_size = 0.0;                               ///< dx, m
  double particle_spacing = 0.0;                        ///< edge of the cube of one particle, m
  double gravity = 0.0;                                 ///< g, m/s^2
  double slope = 0.0;                                   ///< of the floor, rad
  double duration = 0.0;                                ///< of the run, s: sets the length of a strip
  Vec3 offset = Vec3::Zero();                           ///< of the scene against the grid, m
  std::shared_ptr<const HeightField> ground = nullptr;  ///< in place of the level floor; empty: that floor
};

/// Releases the plug, layer by layer; State::source_count is the number of layers released so far.
class ConveyorSource : public ParticleSource {
 public:
  /// @throws ConfigError for an inflow that the feed does not support
  ConveyorSource(const ConveyorSpec& conveyor, const AnyMaterial& material, const ConveyorSetting& setting);

  /// Layers due at state.time: layer j has its centre at x_j = -(j + 1/2) s + v t, with int v dt for v t if it varies. Sheared, row k of it
  /// at -(j + 1/2) s + r_k v t with r_k the mean of r over the row; rows are inserted whenever the plug would have moved by a multiple of
  /// s.
  FluxTotals release(State& state) const override;
  /// The snow at t = 0, which does not count as entered.
  void fill(State& state) const override;

 private:
  /// The snow at rest in the inflow at `time`, s: a particle for each row and each of the levels_ of its part of the height, from the floor
  /// up, with x = y = 0.
  [[nodiscard]] std::vector<Particle> column_at(double time) const;
  [[nodiscard]] int rows(double time) const;
  /// Number of layers of a row that are due when the plug has moved by `distance`.
  [[nodiscard]] std::uint64_t due(double rate, double distance) const;
  void insert_layer(State& state, FluxTotals& entered) const;
  void insert_rows(State& state, FluxTotals& entered) const;
  void insert_row(State& state, FluxTotals& entered, std::span<const Particle> column, int row, std::uint64_t layer, double distance) const;
  /// Shift of a layer of the lattice, in its cells; across the flow that of y > 0, reversed on the other side.
  [[nodiscard]] Vec3 shift_of(std::uint64_t layer) const;

  AnyMaterial material_;
  Inflow inflow_;
  double spacing_, spacing_y_, release_at_, density_, weight_;
  double front_run_;  ///< length over height of the front's slope
  int half_count_, levels_;
  bool mirror_y_;
  Vec3 offset_;                                ///< of the scene against the grid, m
  std::shared_ptr<const HeightField> ground_;  ///< empty: level
  bool endless_;
  std::uint64_t initial_layers_;
  Lattice lattice_;
  std::array<double, random_period> share_{};  ///< volume of a random particle over that of a cell, by row
  std::vector<Particle> column_;               ///< column_at of a steady inflow
};

/// From when the last row of an inflow that varies has come from the inlet; until the wave that thins a strip from its rear, with the
/// celerity sqrt(g H) of shallow water, has come. Friction slows that wave.
/// @param gravity  normal to the ground, m/s^2. @param duration  of the run, s
[[nodiscard]] ConstantFlow constant_flow(const ConveyorSpec& conveyor, double gravity, double duration);

/// Length of the snow in a window, m: from behind the inlet to beyond the outlet.
[[nodiscard]] double window_length(const ConveyorSpec& conveyor, double cell_size);

/// Floor, side walls, inlet and outlet. @param floor  false: without the floor, which uneven ground replaces
std::vector<Boundary> conveyor_walls(const ConveyorSpec& conveyor, ContactRule rule, bool floor = true);

/// Bounds beyond which particles have left, m; follows from the spec; high enough for jets of four velocity heads.
[[nodiscard]] Eigen::AlignedBox3d conveyor_domain(const ConveyorSpec& conveyor, const ConveyorSetting& setting);

}  // namespace mpm
