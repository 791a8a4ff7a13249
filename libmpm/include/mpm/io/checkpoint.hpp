#pragma once
/// checkpoint.h5: everything from which a run continues to the same bits, on any number of threads.

#include <cstdint>
#include <filesystem>
#include <string>

#include "mpm/impact/results.hpp"
#include "mpm/solver.hpp"

namespace mpm {

/// Bookkeeping of a run that is not part of the physics.
struct RunProgress {
  std::uint64_t samples = 0;         ///< rows of series.csv written
  std::uint64_t particle_steps = 0;  ///< sum over steps of the particles moved
  std::uint64_t initial_particles = 0;
  double wall_time = 0.0;  ///< s, of all stretches
  double step_time = 0.0;  ///< s, of it in the solver
};

inline constexpr int checkpoint_format_version = 2;

/// Written at the instant of a sample, so that no sum over steps is under way.
/// Holds the blocks in the order of their coordinates with their particles in slot order: the order of every later sum follows from it.
/// @throws IoError
void write_checkpoint(const std::filesystem::path& path, const std::string& case_hash, const State& state, const RunProgress& progress,
                      const ImpactSeries& series);

/// @param state fresh state of the same cell size, without particles
/// @throws IoError if the file is missing, damaged, of another version, or of another case than case_hash
void read_checkpoint(const std::filesystem::path& path, const std::string& case_hash, State& state, RunProgress& progress,
                     ImpactSeries& series);

}  // namespace mpm
