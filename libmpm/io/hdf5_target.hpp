#pragma once
/// File driver of the HDF5 library that writes through AtomicFile.

#include <cstdint>

#include "libmpm/base/first_error.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm::hdf5 {

/// The target of the HDF5 library's writes. It reports success to the library, which does not survive a full disk. It keeps the first error
/// for rethrow() and writes nothing after it.
class Target {
 public:
  /// @param file  must outlive this object
  explicit Target(AtomicFile& file) : file_(file) {}
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  /// Creates the HDF5 file. @returns its identifier; below 0 if the library fails. Close it before this object is destroyed
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
