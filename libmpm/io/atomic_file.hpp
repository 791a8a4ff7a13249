#pragma once
/// Files that are either complete or absent. A reader never sees half a file, even if the writer is killed: the content
/// goes to a temporary name in the same directory, is forced to the disk, and is then renamed over the target, which
/// POSIX makes one indivisible step. Exceptions are series.csv (csv.hpp) and the logs, which grow row by row.

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libmpm/base/error.hpp"

namespace mpm {

/// A file descriptor that closes itself. Its destructor ignores errors of close(): what must reach the disk is forced to it before.
class Descriptor {
 public:
  Descriptor() = default;
  /// @param number  as open() returns it; below 0: no file
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}  ///< takes over the file
  /// Closes the own file and takes over another.
  Descriptor& operator=(Descriptor other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }

  explicit operator bool() const { return number_ >= 0; }             ///< whether there is a file
  [[nodiscard]] int get() const { return number_; }                   ///< for calls of the system
  [[nodiscard]] int release() { return std::exchange(number_, -1); }  ///< the number; the caller closes it
  [[nodiscard]] int write(std::string_view text) const;               ///< appends a text; 0, or an errno value
  /// Writes all bytes at an offset. @returns 0, or an errno value
  [[nodiscard]] int write_at(std::uint64_t offset, std::span<const std::byte> bytes) const;

 private:
  int number_ = -1;
};

/// A file that is being written. The target does not exist before commit(); without commit() the temporary is removed.
///
/// Every failure is an IoError that names the file, the system's reason and the remedy.
class AtomicFile {
 public:
  /// Creates the temporary `.<name>.<process id>.<counter>.tmp` beside the target. The directory must exist.
  explicit AtomicFile(std::filesystem::path target);
  /// Removes the temporary, unless it was committed.
  ~AtomicFile();

  /// Appends to the temporary. @throws IoError
  void write(std::string_view text);
  /// Writes at an offset of the temporary; bytes before it may be written later. @throws IoError
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Reads back; zeros where nothing was written. @throws IoError
  void read_at(std::uint64_t offset, std::span<std::byte> bytes) const;

  [[nodiscard]] const std::filesystem::path& path() const { return target_; }          ///< the target
  [[nodiscard]] const std::filesystem::path& temporary() const { return temporary_; }  ///< where the content is until commit()

  /// Forces the content to the disk and renames it to the target, replacing what was there. Call once, last.
  /// @param keep_as  the old file gets this name instead; one of the two is complete at every instant. Empty: it is removed
  void commit(const std::filesystem::path& keep_as = {});

 private:
  void discard() noexcept;
  [[noreturn]] void fail(int reason);

  std::filesystem::path target_, temporary_;
  Descriptor file_;
};

/// Writes a share of the content of an AtomicFile, often one of another process: all of them see the same file system.
class FileShare {
 public:
  /// @param target  for messages. @param temporary  of the AtomicFile. @throws IoError if there is no such file
  FileShare(std::filesystem::path target, const std::filesystem::path& temporary);

  /// @throws IoError
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Forces what was written to the disk. @throws IoError
  void sync();

 private:
  std::filesystem::path target_;
  Descriptor file_;
};

/// The common case: the whole content at once.
void write_file(const std::filesystem::path& target, std::string_view content);

/// Removes the temporaries that killed processes left in a directory. Those of running processes stay. Does nothing if the directory does
/// not exist.
void remove_leftovers(const std::filesystem::path& directory);

/// Removes a file; no error if there is none.
void remove_file(const std::filesystem::path& path);

/// Renames a file or a directory. @throws IoError
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Names in a directory, sorted; none if it does not exist. @throws IoError
std::vector<std::string> names_in(const std::filesystem::path& directory);

/// Creates a directory and its parents; no error if it exists.
void make_directory(const std::filesystem::path& directory);

/// Largest file that is read as a whole. The series of a run of a week has some 100 MB.
inline constexpr std::uintmax_t most_file_bytes = std::uintmax_t{1} << 30;

/// The whole content of a file. @throws IoError if it cannot be read, or has more bytes (also a device without end)
std::string read_file(const std::filesystem::path& path, std::uintmax_t most_bytes = most_file_bytes);

/// The content of a text that a user wrote: read_file(), if it is UTF-8. @throws IoError also if it is not, with the line
std::string read_text_file(const std::filesystem::path& path, std::uintmax_t most_bytes = most_file_bytes);

/// Message of every file error: the operation ("cannot write"), on which file, the system's reason (an errno value), the remedy.
IoError file_error(std::string_view action, const std::filesystem::path& path, int error_number);

/// Keeps the first exception and skips all calls after it, while work continues: because other processes wait, or a library written in C
/// is on the call stack.
class FirstError {
 public:
  /// Calls f unless an earlier call has thrown.
  template <class F>
  void attempt(F&& f) {
    if (error_) return;
    try {
      std::forward<F>(f)();
    } catch (...) {
      error_ = std::current_exception();
    }
  }
  /// Rethrows the exception, if there is one.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::exception_ptr error_;
};

}  // namespace mpm
