#pragma once
/// A case as pure data: the resolved content of a case file, in SI units, with every default filled in. Each part declares its own keys.
/// case_file.hpp reads it from TOML and writes it back; scene.hpp turns it into particles, walls and a source.

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/base/limits.hpp"
#include "libmpm/base/precision.hpp"
#include "libmpm/base/types.hpp"
#include "libmpm/boundary/contact.hpp"
#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/core/transfer.hpp"
#include "libmpm/impact/conveyor_spec.hpp"
#include "libmpm/impact/measurement_spec.hpp"
#include "libmpm/material/any_material.hpp"
#include "libmpm/source/body.hpp"

namespace mpm {

/// Version of the case format, the key format_version. A file may give it; another version is refused.
inline constexpr int case_format_version = 1;

/// [[wall]]: half-space. NumericsSpec::contact decides whether it acts at its plane or on the nodes on and behind it.
struct WallSpec {
  Vec3 point = Vec3::Zero();           ///< m, on the plane
  Vec3 normal = Vec3::UnitZ();         ///< unit, into the material
  Contact contact = Contact::no_slip;  ///< how the surface acts (boundary/contact.hpp)
  double friction = 0.0;               ///< Coulomb mu; slip and separable only
  Vec3 velocity = Vec3::Zero();        ///< of the surface, m/s
  bool operator==(const WallSpec&) const = default;

  /// The keys of [[wall]] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("point_m", &WallSpec::point).unit("m").range(-longest_length, longest_length).required().text("A point of the plane");
    table.add("normal", &WallSpec::normal)
        .range(-1e6, 1e6)
        .stored_as(&WallSpec::unit)
        .required()
        .text("Normal of the plane, into the material; any length but zero");
    table.add("contact", &WallSpec::contact, {"no_slip", "slip", "separable"})
        .text("no_slip: sticks; slip: stays on the plane and slides; separable: slides and may lift off");
    table.add("friction", &WallSpec::friction).range(0.0, 10.0).only_with("contact", {"slip", "separable"}).text("Coulomb coefficient mu");
    table.add("velocity_m_s", &WallSpec::velocity).unit("m/s").range(-fastest_speed, fastest_speed).text("Velocity of the wall");
  }
  /// Normalised; a vector that already has unit length keeps its bits.
  static Vec3 unit(const Vec3& n) {
    constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();  // of normalising: a few ulp in the square
    const double length = n.stableNorm();
    return length == 0.0 || std::abs(n.squaredNorm() - 1.0) < rounding ? n : Vec3(n / length);
  }
  /// Conditions between these keys.
  void check(ParameterReport& report) const;
};

/// [domain]: particles that leave are removed and counted. Mirror planes pass through the origin: only x >= 0 (y >= 0) is
/// computed, and sums such as forces and masses are reported for the whole.
struct DomainSpec {
  Vec3 min = Vec3::Constant(-1e3), max = Vec3::Constant(1e3);  ///< corners, m
  bool mirror_x = false, mirror_y = false;                     ///< planes x = 0 and y = 0
  bool operator==(const DomainSpec&) const = default;

  /// The keys of [domain] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("min_m", &DomainSpec::min)
        .unit("m")
        .range(-longest_length, longest_length)
        .required_without_table("conveyor")
        .text("Lower corner; particles that leave are removed and counted");
    table.add("max_m", &DomainSpec::max)
        .unit("m")
        .range(-longest_length, longest_length)
        .required_without_table("conveyor")
        .text("Upper corner; particles that leave are removed and counted");
    table.add_axes("mirror", &DomainSpec::mirror_x, &DomainSpec::mirror_y)
        .only_with_table("conveyor", false)
        .text("Symmetry planes through the origin: only x >= 0 (y >= 0) is computed");
  }
  /// min is below max along every axis.
  void check(ParameterReport& report) const;
};

/// [numerics]
struct NumericsSpec {
  double cell_size = 0.25;     ///< dx, m
  int particles_per_cell = 8;  ///< a cube number: 1, 8, 27, 64
  /// Velocities between grid and particles (core/transfer.hpp).
  Transfer transfer = Transfer::aflip;
  double flip_ratio = 0.95;                           ///< fraction of FLIP in the PIC/FLIP blend
  double relaxation_cells = 5.0;                      ///< AFLIP: relaxation time of what the grid cannot represent, in dx/(c_P + |v|max)
  ContactRule contact = ContactRule::surface;         ///< where walls and obstacle act (boundary/contact.hpp)
  Precision precision = Precision::double_precision;  ///< of particles and of computations on them (base/precision.hpp)
  double cfl = 0.4;                                   ///< dt <= cfl dx / (c_P + |v|max)
  double gravity = 9.81;                              ///< m/s^2
  double slope = 0.0;                                 ///< rad; gravity = g (sin, 0, -cos)
  Vec3 grid_offset = Vec3::Zero();  ///< shift of the whole scene against the grid, in cells; for studies of where surfaces cut cells
  bool operator==(const NumericsSpec&) const = default;

  /// The keys of [numerics] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("cell_size_m", &NumericsSpec::cell_size).unit("m").range(1e-4, 1e2).text("Grid spacing dx");
    table.add("particles_per_cell", &NumericsSpec::particles_per_cell)
        .one_of({"1", "8", "27", "64"})
        .text("Particles of a full cell, a cube number");
    table.add("transfer", &NumericsSpec::transfer, {"apic", "flip", "aflip"})
        .text(
            "Velocities between grid and particles: affine (APIC); a blend of PIC and FLIP; affine, and particles keep for some time the "
            "part of their velocity that the grid cannot represent (AFLIP)");
    table.add("flip_ratio", &NumericsSpec::flip_ratio)
        .range(0.0, 1.0)
        .only_with("transfer", {"flip"})
        .text("Fraction of FLIP in the blend; 0 is pure PIC");
    table.add("relaxation_cells", &NumericsSpec::relaxation_cells)
        .unit("cells")
        .range(1e-3, 1e6)
        .only_with("transfer", {"aflip"})
        .text(
            "Time in which particles lose the part of their velocity that the grid cannot represent, as the distance that the fastest wave "
            "travels in it; a time step takes cfl / this of that part");
    table.add("contact", &NumericsSpec::contact, {"nodal", "surface"})
        .text(
            "Where walls and obstacle act: on every node on or behind them (first order), or at their surface (second order; walls normal "
            "to an axis and upright obstacles)");
    table.add("precision", &NumericsSpec::precision, {"double", "single"})
        .text(
            "Precision of particles and of computations on them: double is the reference; single takes half the memory and less time "
            "(docs/precision.md gives the errors)");
    table.add("cfl", &NumericsSpec::cfl).positive(1.0).text("Safety factor: dt = cfl dx / (c_P + largest speed)");
    table.add("gravity_m_s2", &NumericsSpec::gravity).unit("m/s^2").range(0.0, 1e3).text("Acceleration g of gravity");
    table.add("slope_deg", &NumericsSpec::slope).degrees().range(-90.0, 90.0).text("Inclination: gravity acts along g (sin, 0, -cos)");
    table.add("grid_offset_cells", &NumericsSpec::grid_offset)
        .unit("cells")
        .range(-1.0, 1.0)
        .text("Shift of the whole scene against the grid; results keep the coordinates of the case. 0 along an axis with a mirror plane");
  }
};

/// [output]
struct OutputSpec {
  double duration = 1.0;             ///< s
  double stop_when_steady = 0.0;     ///< largest relative standard error of the means at which a run ends sooner; 0: it does not
  double series_per_second = 50.0;   ///< rows of series.csv
  double frames_per_second = 5.0;    ///< HDF5 frames
  double checkpoint_minutes = 10.0;  ///< wall time between checkpoints
  bool operator==(const OutputSpec&) const = default;

  /// The keys of [output] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("duration_s", &OutputSpec::duration).unit("s").positive(1e6).required().text("Simulated time");
    table.add("stop_when_steady", &OutputSpec::stop_when_steady)
        .range(0.0, 0.2)
        .only_with_table("conveyor")
        .text(
            "The run ends before duration_s once the means of run-up, pressure height and force on the obstacle are known to this relative "
            "standard error and no longer drift (docs/cases.md); 0: it does not");
    table.add("series_per_second", &OutputSpec::series_per_second)
        .unit("1/s")
        .positive(1e6)
        .text("Rows of series.csv per simulated second");
    table.add("frames_per_second", &OutputSpec::frames_per_second)
        .unit("1/s")
        .range(0.0, 1e4)
        .text("Stored particle frames per simulated second; 0: none");
    table.add("checkpoint_minutes", &OutputSpec::checkpoint_minutes)
        .unit("min")
        .positive(1e5)
        .no_effect_on_results()
        .text("Wall-clock time between checkpoints");
  }
};

/// The keys above the first table, of a case file and of a point path.
template <class Table, class Base>
void declare_heading(Table& table, std::string Base::*title) {
  table.add("title", title).no_effect_on_results().text("Describes the case; heading of results and pictures");
  table.add_constant("format_version", case_format_version).text("Version of the format of this file");
}

/// One simulation. read_case (case_file.hpp) returns it checked and complete.
struct Case {
  std::string title;                     ///< heading of results and pictures; not part of the hash
  MaterialParameters material;           ///< [material]
  std::vector<BodySpec> bodies;          ///< [[body]]
  std::vector<WallSpec> walls;           ///< [[wall]]
  std::optional<ConveyorSpec> conveyor;  ///< [conveyor], with its [[inflow]]
  std::optional<ObstacleSpec> obstacle;  ///< [obstacle]
  DomainSpec domain;                     ///< [domain]
  NumericsSpec numerics;                 ///< [numerics]
  MeasurementSpec measurement;           ///< [measurement]
  OutputSpec output;                     ///< [output]
  bool operator==(const Case&) const = default;

  /// The keys above the first table.
  template <class Table>
  static void declare(Table& table) {
    declare_heading(table, &Case::title);
  }
};

}  // namespace mpm
