#pragma once
/// A file that the system has opened for this process.

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

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
  [[nodiscard]] int write(std::span<const std::byte> bytes) const;    ///< appends all bytes; 0, or an errno value
  [[nodiscard]] int write(std::string_view text) const;               ///< appends a text; 0, or an errno value
  /// Writes all bytes at an offset. @returns 0, or an errno value
  [[nodiscard]] int write_at(std::uint64_t offset, std::span<const std::byte> bytes) const;

 private:
  int number_ = -1;
};

}  // namespace mpm
