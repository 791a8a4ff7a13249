#pragma once
/// The timed problems: compact blocks, variants of the reference problem in any regime, an avalanche with a tall thin jet, and blocks of
/// material points for the laws.

#include <cstdint>
#include <vector>

#include "libmpm/driver/scene.hpp"

namespace mpm::benchmarks {

struct Problem {
  CaseScene scene;
  State state;
};

/// Numerics of all timed problems, unchanged since the first measurements (APIC, contact on nodes).
void use_tracked_numerics(Case& c);

/// Density of the law, kg/m^3.
double density(const Scene& scene);

/// The paper's snow with the reference problem's hardening.
CamClay::Parameters reference_snow();

/// A cube of about `particles` particles, `per_cell` (1, 8, 27) in each cell of dx = 0.05 m, moving in a smooth field with its velocity
/// gradient, and with a smooth stress field: all inputs of the transfers are set.
/// @param jitter moves each particle by up to half the lattice spacing along every axis, by a fixed pseudo-random sequence
Problem make_block(std::size_t particles, int per_cell, bool jitter, Precision precision = Precision::double_precision);

/// Regime of the law.
enum class LawRegime : std::uint8_t {
  elastic,     ///< stays inside the yield surface
  yielding,    ///< returns to its interior part
  apexes,      ///< isotropic: half at p = p_c in compression, half at p = -beta p_c in extension
  zero_slope,  ///< M = 0: q vanishes, p is bounded
};
/// A block whose stresses and velocity gradients put every particle into `regime` over one step of size law_step.
Problem make_law_points(std::size_t particles, LawRegime regime, Precision precision = Precision::double_precision);
inline constexpr double law_step = 2e-4;  ///< s

/// A plug of snow, 12 m x 10 m x 1.75 m, that has just met a mast, and a jet 25 m tall and 0.5 m thick on the mast's front; floor and mast.
/// Cells are sized so that there are about `particles` particles, 8 a cell.
Problem make_avalanche(std::size_t particles, Precision precision = Precision::double_precision);

/// Reads all particles in storage order, and writes them back into a problem with the same blocks.
std::vector<Particle> copy_particles(const Grid& grid);
void put_back(const std::vector<Particle>& particles, Grid& grid);

}  // namespace mpm::benchmarks
