#include "libmpm/io/hdf5_library.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>
#include <zlib.h>

#include <new>
#include <utility>
#include <vector>

namespace mpm::hdf5 {

static_assert(std::same_as<hid_t, std::int64_t> && std::same_as<herr_t, int>);

QuietErrors::QuietErrors() {
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
QuietErrors::~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }

std::string innermost_message() {
  std::string message;
  const auto take_first = [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
    auto& text = *static_cast<std::string*>(out);
    if (text.empty() && error->desc != nullptr) text = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &message);
  return message.empty() ? "no reason given" : message;
}

Handle::~Handle() {
  if (id_ >= 0) close_(id_);
}
Handle::Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, std::int64_t{-1})), close_(other.close_) {}

template <>
ElementType element_type<double>() {
  return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE};
}
template <>
ElementType element_type<float>() {
  return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE};
}
template <>
ElementType element_type<std::uint64_t>() {
  return {H5T_NATIVE_UINT64, H5T_STD_U64LE};
}
template <>
ElementType element_type<std::int64_t>() {
  return {H5T_NATIVE_INT64, H5T_STD_I64LE};
}
template <>
ElementType element_type<std::int32_t>() {
  return {H5T_NATIVE_INT32, H5T_STD_I32LE};
}
template <>
ElementType element_type<std::uint8_t>() {
  return {H5T_NATIVE_UINT8, H5T_STD_U8LE};
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

std::string describe(const Shape& shape) {
  std::vector<std::string> extents;
  for (const std::size_t n : shape) extents.push_back(n == any_extent ? "any" : std::to_string(n));
  return fmt::format("({})", fmt::join(extents, ", "));
}

unsigned long crc_of(unsigned long before, std::span<const std::byte> bytes) {
  if (bytes.empty()) return before;  // crc32_z begins anew where there is no address
  return crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
}

std::string seal(unsigned long crc) { return fmt::format("{}{:08x}", seal_mark, static_cast<std::uint32_t>(crc)); }

void require_memory(std::size_t bytes) {
  void* volatile memory = ::operator new(bytes);  // volatile: a pair of new and delete may be left out by the compiler
  ::operator delete(memory);
}

bool usable_by_threads() {
  hbool_t safe = 0;
  return H5is_library_threadsafe(&safe) >= 0 && safe != 0;
}

}  // namespace mpm::hdf5
