#pragma once
/// Lets the HDF5 library write to a file that is whole or absent: a file driver of the library.

#include <cstdint>

#include "libmpm/base/first_error.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm::hdf5 {

/// Where the HDF5 library writes. To the library nothing ever fails: it does not survive a full disk. The first failure is kept for
/// rethrow(), and nothing is written after it.
class Target {
 public:
  /// @param file  outlives this
  explicit Target(AtomicFile& file) : file_(file) {}
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  /// Creates the HDF5 file. @returns its identifier; below 0 where the library fails. Close it before this is destroyed
  std::int64_t create();
  [[nodiscard]] std::uint64_t size() const { return end_; }  ///< of the file as the library has laid it out, bytes
  /// @throws IoError if writing has failed
  void rethrow() const { failure_.rethrow(); }

 private:
  friend struct Driver;
  AtomicFile& file_;
  std::uint64_t end_ = 0;
  FirstError failure_;
};

}  // namespace mpm::hdf5
