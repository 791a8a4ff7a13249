#pragma once
/// Common parts of reader and writer of hdf5.hpp for the HDF5 library. For sources only: with this header come the library's own, which
/// users of the other headers do not need.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>
#include <sys/mman.h>
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libmpm/io/hdf5.hpp"

namespace mpm::hdf5 {

/// The HDF5 library prints its error stack to stderr by default; libmpm never prints, so it switches this off around its calls and
/// restores it, because the caller may use HDF5, too.
class QuietErrors {
 public:
  /// Off.
  QuietErrors() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  /// As before.
  ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Message of the innermost entry of HDF5's error stack: the cause, not the call.
inline std::string innermost_message() {
  std::string message;
  const auto take_first = [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
    auto& text = *static_cast<std::string*>(out);
    if (text.empty() && error->desc != nullptr) text = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &message);
  return message.empty() ? "no reason given" : message;
}

/// An HDF5 identifier that closes itself.
class Handle {
 public:
  /// @param id  below 0: an error, nothing is closed
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, hid_t{-1})), close_(other.close_) {}  ///< takes ownership
  operator hid_t() const { return id_; }                                                               ///< for calls of the library

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// A type of numbers.
struct ElementType {
  hid_t native;  ///< in memory
  hid_t stored;  ///< in the file: little-endian whatever the machine
};
/// The type of T.
template <Element T>
ElementType element_type() {
  if constexpr (std::same_as<T, double>) return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE};
  if constexpr (std::same_as<T, float>) return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE};
  if constexpr (std::same_as<T, std::uint64_t>) return {H5T_NATIVE_UINT64, H5T_STD_U64LE};
  if constexpr (std::same_as<T, std::int64_t>) return {H5T_NATIVE_INT64, H5T_STD_I64LE};
  if constexpr (std::same_as<T, std::int32_t>) return {H5T_NATIVE_INT32, H5T_STD_I32LE};
  if constexpr (std::same_as<T, std::uint8_t>) return {H5T_NATIVE_UINT8, H5T_STD_U8LE};
}

/// UTF-8 of any length.
inline Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

/// A shape for messages: "(2, any)".
inline std::string describe(const Shape& shape) {
  std::vector<std::string> extents;
  for (const std::size_t n : shape) extents.push_back(n == any_extent ? "any" : std::to_string(n));
  return fmt::format("({})", fmt::join(extents, ", "));
}

/// CRC-32 of bytes that follow others. @param before  of these; 0: there are none
inline uLong crc_of(uLong before, std::span<const std::byte> bytes) {
  if (bytes.empty()) return before;  // crc32_z begins anew where there is no address
  return crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
}

/// First bytes of the checksum at the end of a file.
inline constexpr std::string_view seal_mark = "MPMCRC32";
/// Length of the checksum at the end of a file, bytes.
inline constexpr std::size_t seal_size = 16;
/// The checksum at the end of a file. @param crc  CRC-32 of all bytes before
inline std::string seal(uLong crc) { return fmt::format("{}{:08x}", seal_mark, static_cast<std::uint32_t>(crc)); }

/// Throws std::bad_alloc unless the memory that the library allocates for its own tables is available now. The HDF5 library itself does not
/// survive a failed allocation: version 1.10 then frees blocks twice when the file is closed. The memory is mapped and not written to, so
/// that this takes microseconds; an allocation of this size would raise the limit up to which malloc keeps what is freed (mallopt(3),
/// M_MMAP_THRESHOLD): 20 MB more for most runs.
inline void require_library_memory() {
  constexpr std::size_t bytes = std::size_t{16} << 20;
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  munmap(memory, bytes);
}

}  // namespace mpm::hdf5
