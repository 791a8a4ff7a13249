#pragma once
/// checkpoint.h5: everything from which a run continues to the same bits, on any number of threads; and checkpoint.previous.h5, the one
/// before it, in case the newest is damaged.

#include <filesystem>
#include <functional>
#include <string>

#include "libmpm/core/step.hpp"
#include "libmpm/driver/case.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

class BlockExchange;

/// Attribute format_version; other versions are refused.
inline constexpr int checkpoint_format_version = 5;

/// Name of the newest checkpoint in the folder of a run.
inline constexpr const char* checkpoint_file = "checkpoint.h5";
/// Name of the checkpoint before it.
inline constexpr const char* previous_checkpoint_file = "checkpoint.previous.h5";
/// Name that a refused checkpoint gets when an older one is used.
inline constexpr const char* refused_checkpoint_file = "checkpoint.refused.h5";

/// Written at the instant of a sample, so that no sum over steps is under way.
/// Holds the blocks in the order of their coordinates with their particles in slot order: the order of every later sum follows from it.
/// With several ranks each writes its own blocks into the one file, which has the bytes that one rank would write.
/// @param observed  state of the observers (ObserverList::save): arrays named "observer.array"
/// @param keep_as  new name of an existing checkpoint; empty: it is replaced. @throws IoError
void write_checkpoint(const std::filesystem::path& path, const Case& c, const State& state, const RunProgress& progress,
                      const Arrays& observed, const std::filesystem::path& keep_as = {});
/// What the other ranks do in write_checkpoint() of the first.
void write_own_blocks(const State& state);

/// @param state fresh state of the same cell size, without particles. The three are unchanged if this throws.
/// @param ranks  not null: each takes its own blocks from the file, evenly divided, and no rank holds those of another
/// @throws IoError if the file is missing, damaged, or of another version. @throws ConfigError if it is of another case; names the keys
void read_checkpoint(const std::filesystem::path& path, const Case& c, State& state, RunProgress& progress, Arrays& observed,
                     BlockExchange* ranks = nullptr);
/// What the other ranks do in read_checkpoint() of the first. @param state  of this rank; it stays as it is if any rank fails
void read_own_blocks(const Case& c, const Scene& scene, State& state, BlockExchange& ranks);

/// Whether a folder holds a checkpoint, good or bad.
bool has_checkpoint(const std::filesystem::path& directory);

/// Takes over the observed values of a checkpoint. Throws IoError if the observers do not match it.
using AcceptCheckpoint = std::function<void(const State&, const RunProgress&, const Arrays& observed)>;

/// Reads the newest checkpoint of a folder from which the run can resume: checkpoint.h5, else checkpoint.previous.h5.
/// @return empty if it was the newest; else the reason why the newest was refused; checkpoint.h5 has then become checkpoint.refused.h5
/// @throws ConfigError if the newest is of another case, IoError with every reason if it is not, and there is no other
std::string resume_from_checkpoint(const std::filesystem::path& directory, const Case& c, State& state, RunProgress& progress,
                                   const AcceptCheckpoint& acceptable, BlockExchange* ranks = nullptr);

}  // namespace mpm
