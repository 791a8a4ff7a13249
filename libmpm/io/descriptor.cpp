#include "libmpm/io/descriptor.hpp"

#include <sys/types.h>

#include <cerrno>

namespace mpm {
namespace {

/// Calls put(rest), which returns as ::write does, until all bytes are written. @returns 0, or an errno value
template <class Put>
int write_all(std::span<const std::byte> bytes, Put&& put) {
  while (!bytes.empty()) {
    const ssize_t n = put(bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return 0;
}

}  // namespace

int Descriptor::write(std::span<const std::byte> bytes) const {
  return write_all(bytes, [&](std::span<const std::byte> rest) { return ::write(number_, rest.data(), rest.size()); });
}

int Descriptor::write(std::string_view text) const { return write(std::as_bytes(std::span(text.data(), text.size()))); }

int Descriptor::write_at(std::uint64_t offset, std::span<const std::byte> bytes) const {
  return write_all(bytes, [&](std::span<const std::byte> rest) {
    return ::pwrite(number_, rest.data(), rest.size(), static_cast<off_t>(offset + (bytes.size() - rest.size())));
  });
}

}  // namespace mpm
