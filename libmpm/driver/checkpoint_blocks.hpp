#pragma once
/// The blocks of a checkpoint with their particles: written by all ranks into one file, and read by each rank for itself.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "libmpm/core/state.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/parallel/ownership.hpp"

namespace mpm {

/// Throws that a file cannot be used, with the reason.
using Refuse = std::function<void(const std::string& why)>;

/// Reads the particles of a file block by block, a piece at a time.
class StoredBlocks {
 public:
  /// @param file  must outlive this object. @throws IoError if an array is missing or has another shape
  StoredBlocks(const hdf5::Reader& file, Precision precision);

  /// All blocks, in order. Refuses counts and coordinates that no run can have written.
  [[nodiscard]] std::vector<BlockHead> heads(const Refuse& refuse) const;
  /// Puts the blocks that this rank owns into a grid; all blocks if there is one rank. heads() must have accepted them. Refuses particles
  /// that are not finite, not in their cell, or whose identity number is not below `next_id` or that of
  /// another one (of this rank), because kernels and output rely on that.
  void restore_own(Grid& grid, std::uint64_t next_id, const Refuse& refuse) const;

 private:
  [[nodiscard]] std::size_t size_of(std::size_t block) const { return static_cast<std::size_t>(counts_[block]); }
  [[nodiscard]] Index3 coordinate_of(std::size_t b) const;
  /// Blocks b .. end - 1, with `count` particles from `first` on.
  void restore_piece(std::size_t b, std::size_t end, std::size_t first, std::size_t count, Grid& grid, std::uint64_t next_id,
                     std::vector<std::uint64_t>& ids, const Refuse& refuse) const;

  const hdf5::Reader& file_;
  Precision precision_;
  std::vector<std::int32_t> counts_, coordinates_;
  std::vector<double> velocities_;
  std::size_t particles_;
};

/// Declares the arrays of some blocks, for write_blocks().
void declare_blocks(hdf5::Writer& file, Precision precision, std::span<const BlockHead> heads);

/// All ranks call this: writes a file with the blocks of each. @param make  as in JointFile::begin, given all blocks; it declares their
/// arrays. @param keep_as  as in AtomicFile::commit. @throws IoError
void write_blocks(const State& state, const std::function<std::unique_ptr<hdf5::Writer>(std::span<const BlockHead>)>& make,
                  const std::filesystem::path& keep_as);

}  // namespace mpm
