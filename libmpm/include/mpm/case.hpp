#pragma once
/// A case as pure data: the resolved content of a case file, in SI units, with every default filled in.
/// io/config.hpp reads it from TOML and writes it back; scene.hpp turns it into particles, walls and a feed.
/// Nothing here computes.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mpm/types.hpp"

namespace mpm {

/// On which test a Drucker-Prager cone agrees with the Mohr-Coulomb angle; formulas in materials/drucker_prager.hpp.
enum class ConeMatching : std::uint8_t { plane_strain, triaxial_compression, simple_shear };

/// [material]; keys that a law does not use keep their defaults and are refused by the reader when given.
struct MaterialSpec {
  std::string model = "cohesive_cam_clay";
  double density = 300.0;                    ///< rho_0, kg/m^3
  double young_modulus = 1.0e6;              ///< E, Pa
  double poisson_ratio = 0.1;                ///< nu
  double critical_state_slope = 0.4;         ///< M
  double cohesion_beta = 0.0;                ///< beta = p_t / p_c
  double hardening_xi = 5.0;                 ///< xi
  double preconsolidation_pressure = 1.0e4;  ///< p_c0, Pa

  ConeMatching cone_matching = ConeMatching::plane_strain;
  double friction_angle = 0.5;                      ///< phi, rad
  double dilatancy_angle = 0.0;                     ///< psi, rad
  double cohesion = 0.0;                            ///< c, Pa
  std::optional<double> limit_friction_angle;       ///< phi_2 of mu(I), rad; these four together or none
  std::optional<double> reference_inertial_number;  ///< I_0
  std::optional<double> grain_diameter;             ///< d, m
  std::optional<double> grain_density;              ///< rho_s, kg/m^3

  double bulk_modulus = 1.0e6;  ///< K = rho_0 c^2 of the fluid, Pa
  int tait_exponent = 7;        ///< n
  double viscosity = 0.0;       ///< eta, Pa s
  bool carries_tension = false;
  bool operator==(const MaterialSpec&) const = default;
};

enum class Contact : std::uint8_t {
  no_slip,    ///< sticks fully
  slip,       ///< stays on the plane, slides (with Coulomb friction if mu > 0)
  separable,  ///< may lift off, slides (with Coulomb friction if mu > 0)
};

/// [[body]]: a lattice of particles.
struct BodySpec {
  enum class Shape : std::uint8_t { box, cylinder, sphere } shape = Shape::box;
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< bounding box, m; cylinder (axis z) and sphere are inscribed
  Vec3 velocity = Vec3::Zero();                 ///< m/s
  bool operator==(const BodySpec&) const = default;
};

/// [[wall]]: half-space; acts on grid nodes on or behind the plane.
struct WallSpec {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< unit, into the material
  Contact contact = Contact::no_slip;
  double friction = 0.0;  ///< Coulomb mu; slip and separable only
  Vec3 velocity = Vec3::Zero();
  bool operator==(const WallSpec&) const = default;
};

/// [obstacle]: rigid, upright, on the floor; its most upstream point at x = 0, its centre at y = 0; separable Coulomb contact.
/// Cross-sections in plan: obstacle.hpp.
struct ObstacleSpec {
  enum class Shape : std::uint8_t { box, cylinder, wedge } shape = Shape::box;
  double width = 1.75;           ///< w, m: across the flow; diameter of a cylinder, base of a wedge
  double depth = 1.75;           ///< m: along the flow; of a wedge from edge to base; not used by a cylinder
  double rotation = 0.0;         ///< rad, box only: counter-clockwise from above about its own vertical axis
  std::optional<double> height;  ///< m; empty: taller than any jet
  double friction = 0.15;        ///< mu
  bool operator==(const ObstacleSpec&) const = default;
};

/// [[conveyor.inflow]]: what enters at one instant; linear between instants, constant before the first and after the last.
struct InflowPoint {
  double time = 0.0;                  ///< s
  std::optional<double> velocity;     ///< m/s, mean over the depth; empty: the conveyor's
  std::optional<double> flow_height;  ///< m; empty: the conveyor's
  double density_ratio = 1.0;         ///< density of the entering snow over rho_0, by compaction before it enters
  bool operator==(const InflowPoint&) const = default;
};

/// [conveyor]: the set-up of Sect. 2.2 of the paper.
struct ConveyorSpec {
  double velocity = 0.0;      ///< v, m/s (from froude_number where that was given)
  double flow_height = 1.75;  ///< H, m
  double width = 21.0;        ///< W, m
  enum class Feed : std::uint8_t { window, strip } feed = Feed::window;
  double upstream_length = 8.0;                 ///< window: inlet at x = -upstream_length, m
  double downstream_length = 4.0;               ///< window: outlet at x = +downstream_length, m
  Contact sidewall_contact = Contact::no_slip;  ///< "coulomb" in a file is separable with friction: a wall cannot pull
  double sidewall_friction = 0.0;               ///< mu; separable only
  enum class Lattice : std::uint8_t { staggered, aligned };
  Lattice lattice = Lattice::staggered;  ///< how layers of particles follow one another
  bool mirror_y = true;                  ///< compute y >= 0 only
  double slip_ratio = 1.0;               ///< s: sheared inflow u(z) = v (s + (1 - s)(1 + n)(z/H)^n), of depth mean v; 1 is the paper's plug
  double shear_exponent = 1.0;           ///< n
  std::vector<InflowPoint> inflow;       ///< by rising time; empty: steady
  bool operator==(const ConveyorSpec&) const = default;
};

/// [domain]: particles that leave are removed and counted. Mirror planes pass through the origin: only x >= 0 (y >= 0) is
/// computed, and sums such as forces and masses are reported for the whole.
struct DomainSpec {
  Vec3 min = Vec3::Constant(-1e3), max = Vec3::Constant(1e3);
  bool mirror_x = false, mirror_y = false;
  bool operator==(const DomainSpec&) const = default;
};

enum class Transfer : std::uint8_t { apic, flip };

struct NumericsSpec {
  double cell_size = 0.25;     ///< dx, m
  int particles_per_cell = 8;  ///< a cube number: 1, 8, 27, 64
  Transfer transfer = Transfer::apic;
  double flip_ratio = 0.95;         ///< share of FLIP in the PIC/FLIP blend
  double cfl = 0.4;                 ///< dt <= cfl dx / (c_P + |v|max)
  double gravity = 9.81;            ///< m/s^2
  double slope = 0.0;               ///< rad; gravity = g (sin, 0, -cos)
  Vec3 grid_offset = Vec3::Zero();  ///< shift of the whole scene against the grid, in cells; for studies of where surfaces cut cells
  bool operator==(const NumericsSpec&) const = default;
};

/// [measurement]: windows of the pressure profile on the obstacle, m. What is empty follows the cell size, as in the paper (Sect. 2.3):
/// a grid study fixes them, because the bias of a window that shrinks with the grid would pass for a grid error.
struct MeasurementSpec {
  std::optional<double> bin_height;     ///< of the profile's bins; empty: dx/2
  std::optional<double> filter_length;  ///< of the Savitzky-Golay window, an odd number of bins; empty: 13 bins
  std::optional<double> box_upstream;   ///< depth of the measuring box before the face; empty: 2.5 dx
  std::optional<double> box_inside;     ///< its depth behind the face; empty: 0.5 dx
  double force_window = 0.1;            ///< s: of the moving mean behind the filtered peak of the force
  bool operator==(const MeasurementSpec&) const = default;
};

struct OutputSpec {
  double duration = 1.0;             ///< s
  double series_per_second = 50.0;   ///< rows of series.csv
  double frames_per_second = 5.0;    ///< HDF5 frames
  double checkpoint_minutes = 10.0;  ///< wall time between checkpoints
  bool operator==(const OutputSpec&) const = default;
};

struct Case {
  std::string title;
  MaterialSpec material;
  std::vector<BodySpec> bodies;
  std::vector<WallSpec> walls;
  std::optional<ConveyorSpec> conveyor;
  std::optional<ObstacleSpec> obstacle;
  DomainSpec domain;
  NumericsSpec numerics;
  MeasurementSpec measurement;
  OutputSpec output;
  bool operator==(const Case&) const = default;
};

}  // namespace mpm
