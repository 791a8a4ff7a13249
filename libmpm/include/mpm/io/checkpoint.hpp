#pragma once
/// checkpoint.h5: everything from which a run continues to the same bits, on any number of threads; and checkpoint.previous.h5, the one
/// before it, for the day on which the newest is damaged.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "mpm/case.hpp"
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

inline constexpr const char* checkpoint_file = "checkpoint.h5";
inline constexpr const char* previous_checkpoint_file = "checkpoint.previous.h5";
/// What a checkpoint is called after it was refused and an older one used in its place.
inline constexpr const char* refused_checkpoint_file = "checkpoint.refused.h5";

/// Written at the instant of a sample, so that no sum over steps is under way.
/// Holds the blocks in the order of their coordinates with their particles in slot order: the order of every later sum follows from it.
/// @param keep_as  name that a checkpoint of before gets; empty: it is replaced. @throws IoError
void write_checkpoint(const std::filesystem::path& path, const Case& c, const State& state, const RunProgress& progress,
                      const ImpactSeries& series, const std::filesystem::path& keep_as = {});

/// @param state fresh state of the same cell size, without particles; unchanged if this throws
/// @throws IoError if the file is missing, damaged, or of another version. @throws ConfigError if it is of another case; names the keys
void read_checkpoint(const std::filesystem::path& path, const Case& c, State& state, RunProgress& progress, ImpactSeries& series);

/// Whether a folder holds a checkpoint, good or bad.
bool has_checkpoint(const std::filesystem::path& directory);

/// Reads the newest checkpoint of a folder that can be gone on from: checkpoint.h5, else checkpoint.previous.h5.
/// @param acceptable  throws IoError if the rest of the folder does not go with the checkpoint
/// @return empty if it was the newest; else a line that says why it was not: then checkpoint.h5 has become checkpoint.refused.h5
/// @throws ConfigError if the newest is of another case, IoError with every reason if it is not, and there is no other
std::string resume_from_checkpoint(const std::filesystem::path& directory, const Case& c, State& state, RunProgress& progress,
                                   ImpactSeries& series, const std::function<void(const State&, const RunProgress&)>& acceptable = {});

}  // namespace mpm
