#pragma once
/// Parameters of the computation, in one place: what a case gives, and of these what a scene carries.

#include <cmath>
#include <cstdint>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/contact.hpp"

namespace mpm {

/// How velocities pass between grid and particles.
enum class Transfer : std::uint8_t {
  apic,   ///< affine (Jiang et al. 2015): a particle takes the grid's velocity and gradient, and forgets its own
  flip,   ///< a blend of PIC and FLIP, without the affine part
  aflip,  ///< affine, and a particle keeps the part of its velocity that is not representable on the grid (Fei et al. 2021); that part
          ///< decays in the time in which a wave travels relaxation_cells cells: a shorter step removes less
};

/// What a step reads.
struct StepNumerics {
  Transfer transfer = Transfer::aflip;  ///< velocities between grid and particles
  double flip_ratio = 0.95;             ///< fraction of FLIP in the PIC/FLIP blend
  double relaxation_cells = 5.0;        ///< AFLIP: relaxation time of what the grid cannot represent, in dx/(c_P + |v|max)
  double cfl = 0.4;                     ///< dt <= cfl dx / (c_P + |v|max)
  double shock_viscosity = 10.0;        ///< c_2 of the viscosity of shocks (core/transfer.hpp)
  bool operator==(const StepNumerics&) const = default;
};

/// [numerics]: of a step; and of the grid, the particles and the boundaries, when these are made.
struct Numerics : StepNumerics {
  double cell_size = 0.25;                            ///< dx, m
  int particles_per_cell = 8;                         ///< a cube number: 1, 8, 27, 64
  ContactRule contact = ContactRule::surface;         ///< where walls and obstacle act (boundary/contact.hpp)
  Precision precision = Precision::double_precision;  ///< of particles and of computations on them (base/types.hpp)
  double gravity = 9.81;                              ///< m/s^2
  double slope = 0.0;                                 ///< rad; gravity = g (sin, 0, -cos)
  Vec3 grid_offset = Vec3::Zero();  ///< shift of the whole scene against the grid, in cells; for studies of where surfaces cut cells
  bool operator==(const Numerics&) const = default;

  /// The keys of [numerics] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("cell_size_m", &Numerics::cell_size).unit("m").range(1e-4, 1e2).text("Grid spacing dx");
    table.add("particles_per_cell", &Numerics::particles_per_cell)
        .one_of({"1", "8", "27", "64"})
        .text("Particles in a full cell; a cube number");
    table.add("transfer", &Numerics::transfer, {"apic", "flip", "aflip"})
        .text(
            "Velocities between grid and particles: affine (APIC); a blend of PIC and FLIP; affine, and particles keep for some time the "
            "part of their velocity that the grid cannot represent (AFLIP)");
    table.add("flip_ratio", &Numerics::flip_ratio)
        .range(0.0, 1.0)
        .only_with("transfer", {"flip"})
        .text("Fraction of FLIP in the blend; 0 is pure PIC");
    table.add("relaxation_cells", &Numerics::relaxation_cells)
        .unit("cells")
        .range(1e-3, 1e6)
        .only_with("transfer", {"aflip"})
        .text(
            "Time scale in which particles lose the part of their velocity that the grid cannot represent: the time in which the fastest "
            "wave travels this number of cells. A time step removes the fraction cfl / relaxation_cells of that part");
    table.add("contact", &Numerics::contact, {"nodal", "surface"})
        .text(
            "Where walls and obstacle act: on every node on or behind them (first order), or at their surface (second order; walls normal "
            "to an axis and upright obstacles)");
    table.add("precision", &Numerics::precision, {"double", "single"})
        .left_out("single for a flow that a conveyor feeds against an obstacle, else double")
        .text(
            "Precision of particles and of computations on them: double is the reference; single takes half the memory and less time "
            "(docs/precision.md gives the errors)");
    table.add("cfl", &Numerics::cfl)
        .positive(1.0)
        .left_out("1 for a flow of cohesive_cam_clay that a conveyor feeds against an obstacle, with transfer = \"aflip\"; else 0.4")
        .text("Safety factor: dt = cfl dx / (c_P + largest speed)");
    table.add("shock_viscosity", &Numerics::shock_viscosity)
        .range(0.0, 1e3)
        .hide_default()
        .text(
            "Coefficient c_2 of the viscous pressure rho_0 c_2 dx^2 (div v)^2 where snow is compressed (von Neumann and Richtmyer 1950): "
            "it gives compaction shocks their exact state. Only for a law that keeps compaction, cohesive_cam_clay; 0: none");
    table.add("gravity_m_s2", &Numerics::gravity).unit("m/s^2").range(0.0, 1e3).text("Acceleration g of gravity");
    table.add("slope_deg", &Numerics::slope).degrees().range(-90.0, 90.0).text("Inclination: gravity acts along g (sin, 0, -cos)");
    table.add("grid_offset_cells", &Numerics::grid_offset)
        .unit("cells")
        .range(-1.0, 1.0)
        .text(
            "Shift of the whole scene relative to the grid; results keep the coordinates of the case. 0 along an axis with a mirror plane");
  }

  /// Edge of the cube of one particle, m: dx over the cube root of the particles per cell.
  [[nodiscard]] double particle_spacing() const { return cell_size / std::cbrt(static_cast<double>(particles_per_cell)); }
  /// Acceleration of gravity, m/s^2.
  [[nodiscard]] Vec3 gravity_vector() const { return gravity * Vec3(std::sin(slope), 0.0, -std::cos(slope)); }
  /// Shift of the whole scene against the grid, m.
  [[nodiscard]] Vec3 offset() const { return cell_size * grid_offset; }
};

}  // namespace mpm
