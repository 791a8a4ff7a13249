#pragma once
/// Common parts of reader and writer of hdf5.hpp for the HDF5 library. Only sources include the library's header: hid_t is std::int64_t
/// and herr_t is int.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "libmpm/io/hdf5.hpp"

namespace mpm::hdf5 {

/// The HDF5 library prints its error stack to stderr by default; libmpm never prints, so it switches this off around its calls and
/// restores it, because the caller may use HDF5, too.
class QuietErrors {
 public:
  QuietErrors();   ///< off
  ~QuietErrors();  ///< as before
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  int (*function_)(std::int64_t, void*) = nullptr;
  void* data_ = nullptr;
};

/// Message of the innermost entry of HDF5's error stack: the cause, not the call.
std::string innermost_message();

/// An HDF5 identifier that closes itself.
class Handle {
 public:
  /// @param id  below 0: an error, nothing is closed
  Handle(std::int64_t id, int (*close)(std::int64_t)) : id_(id), close_(close) {}
  ~Handle();
  Handle(Handle&& other) noexcept;  ///< takes ownership
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;
  operator std::int64_t() const { return id_; }  ///< for calls of the library

 private:
  std::int64_t id_;
  int (*close_)(std::int64_t);
};

/// A type of numbers.
struct ElementType {
  std::int64_t native;  ///< in memory
  std::int64_t stored;  ///< in the file: little-endian whatever the machine
};
/// The type of T.
template <Element T>
ElementType element_type();

/// UTF-8 of any length.
Handle text_type();

/// A shape for messages: "(2, any)".
std::string describe(const Shape& shape);

/// CRC-32 of bytes that follow others. @param before  of these; 0: there are none
unsigned long crc_of(unsigned long before, std::span<const std::byte> bytes);

/// First bytes of the checksum at the end of a file.
inline constexpr std::string_view seal_mark = "MPMCRC32";
/// Length of the checksum at the end of a file, bytes.
inline constexpr std::size_t seal_size = 16;
/// The checksum at the end of a file. @param crc  CRC-32 of all bytes before
std::string seal(unsigned long crc);

/// Memory that the library allocates for its own tables, bytes.
inline constexpr std::size_t library_memory = std::size_t{16} << 20;
/// Throws std::bad_alloc unless this memory is available now. The HDF5 library itself does not survive a failed allocation: version 1.10
/// then frees blocks twice when the file is closed. The memory is not written to, so that this takes microseconds.
void require_memory(std::size_t bytes = library_memory);

}  // namespace mpm::hdf5
