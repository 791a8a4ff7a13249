#pragma once
/// An HDF5 file that all ranks write together: the first lays it out and gives it its name, each writes its own values to their places, and
/// no values pass through another rank. One rank alone does the same. All ranks need to see the file: a file system that they share.

#include <functional>
#include <memory>
#include <optional>

#include "libmpm/core/ranks.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5.hpp"

namespace mpm {

/// All ranks learn whether one of them has failed.
/// @returns whether none has. @throws on the first rank what it caught itself, else the error of the rank with the lowest number, with the
/// rank's number and machine; the task of all ranks has ended then
bool agree_on_errors(const FirstError& own, Ranks& ranks);

/// One file. All ranks call the same functions, in the order in which they are here. Nothing is thrown before commit(): the others wait.
class JointFile {
 public:
  /// @param ranks  those that write
  explicit JointFile(Ranks& ranks) : ranks_(ranks) {}

  /// @param make  called on the first rank: the file, with its arrays declared
  /// @param about  given by the first rank, to all: what the others need to know besides
  void begin(const std::function<std::unique_ptr<hdf5::Writer>()>& make, Message& about);
  /// Calls f(file), which writes values of this rank, unless something has failed; commit() throws what it throws.
  template <class F>
  void attempt(F&& f) {
    error_.attempt([&] {
      if (values_) f(*values_);
    });
  }
  /// The file is complete and has its name. Ends the task that the first rank started. @param keep_as  as in AtomicFile::commit
  /// @throws on the first rank as agree_on_errors; IoError. There is no new file then
  void commit(const std::filesystem::path& keep_as = {});

 private:
  Ranks& ranks_;
  std::unique_ptr<hdf5::Writer> file_;       ///< on the first rank
  std::optional<hdf5::ArrayWriter> values_;  ///< of this rank; empty after a failure
  FirstError error_;
};

}  // namespace mpm
