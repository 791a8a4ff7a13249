#include "libmpm/io/hdf5.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>
#include <zlib.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <new>
#include <utility>

#include "libmpm/io/atomic_file.hpp"

namespace mpm::hdf5 {
namespace {

/// The HDF5 library prints its error stack to stderr by default; a library that never prints switches this off around its calls and
/// restores it, since the caller may use HDF5 too.
class QuietErrors {
 public:
  QuietErrors() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Message of the innermost entry of HDF5's error stack: the cause, not the call.
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

/// An HDF5 identifier that closes itself.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, hid_t{-1})), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

struct ElementType {
  hid_t native, stored;  ///< in memory; in the file: little-endian whatever the machine
};

template <Element T>
ElementType element_type() {
  if constexpr (std::same_as<T, double>)
    return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE};
  else if constexpr (std::same_as<T, float>)
    return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE};
  else if constexpr (std::same_as<T, std::uint64_t>)
    return {H5T_NATIVE_UINT64, H5T_STD_U64LE};
  else if constexpr (std::same_as<T, std::int64_t>)
    return {H5T_NATIVE_INT64, H5T_STD_I64LE};
  else if constexpr (std::same_as<T, std::int32_t>)
    return {H5T_NATIVE_INT32, H5T_STD_I32LE};
  else
    return {H5T_NATIVE_UINT8, H5T_STD_U8LE};
}

std::string describe(const Shape& shape) {
  std::vector<std::string> extents;
  for (const std::size_t n : shape) extents.push_back(n == any_extent ? "any" : std::to_string(n));
  return fmt::format("({})", fmt::join(extents, ", "));
}

constexpr std::string_view seal_mark = "MPMCRC32";
constexpr std::size_t seal_size = 16;

std::string seal(uLong crc) { return fmt::format("{}{:08x}", seal_mark, static_cast<std::uint32_t>(crc)); }

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

/// What the library allocates besides the arrays: increments of the file in memory, and its own tables.
constexpr std::size_t library_memory = std::size_t{16} << 20;

/// Throws std::bad_alloc unless so much memory can be had now. The HDF5 library itself does not survive a failed allocation: version 1.10
/// then frees blocks twice when the file is closed. Nothing is touched, so that it costs microseconds.
void require_memory(std::size_t bytes) {
  void* volatile memory = ::operator new(bytes);  // volatile: a pair of new and delete may be left out by the compiler
  ::operator delete(memory);
}

}  // namespace

bool usable_by_threads() {
  hbool_t safe = 0;
  return H5is_library_threadsafe(&safe) >= 0 && safe != 0;
}

struct Writer::File {
  hid_t id = -1;
  std::size_t bytes = 0;  ///< of the arrays so far
  ~File() {
    if (id >= 0) H5Fclose(id);
  }
  /// The file is in memory: a failure here is lack of memory or a wrong argument.
  void require(bool ok, const std::string& what) const {
    if (!ok)
      throw IoError(fmt::format("HDF5 file in memory: {}: {}; if memory is short, raise its limit or take a smaller case", what,
                                innermost_message()));
  }
  void write_attribute(const std::string& name, hid_t type, hid_t memory_type, const void* value) const {
    const QuietErrors quiet;
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle attribute(H5Acreate2(id, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    require(attribute >= 0, fmt::format("attribute '{}'", name));
    require(H5Awrite(attribute, memory_type, value) >= 0, fmt::format("attribute '{}'", name));
  }
};

Writer::Writer() : file_(std::make_unique<File>()) {
  require_memory(library_memory);
  const QuietErrors quiet;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  constexpr std::size_t increment = std::size_t{4} << 20;  // memory is taken in steps of this size
  H5Pset_fapl_core(access, increment, false);
  // The name is never used for a file, but the library refuses to open one name twice.
  static std::atomic<unsigned> counter{0};
  file_->id = H5Fcreate(fmt::format("mpm-memory-{}", counter++).c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  file_->require(file_->id >= 0, "create");
}

Writer::~Writer() {
  const QuietErrors quiet;
  file_.reset();
}

template <Element T>
void Writer::dataset(const std::string& name, std::span<const T> values, const Shape& shape) {
  const QuietErrors quiet;
  std::vector<hsize_t> extents(shape.begin(), shape.end());
  if (extents.empty()) extents.push_back(values.size());
  hsize_t count = 1;
  for (const hsize_t n : extents) count *= n;
  if (count != values.size()) {
    throw IoError(fmt::format("HDF5 file in memory: dataset '{}' of shape {} is given {} values", name, describe(shape), values.size()));
  }
  file_->bytes += values.size_bytes();
  require_memory(2 * file_->bytes + library_memory);  // the file in memory grows by moving
  const Handle space(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), H5Sclose);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);  // equal content, equal bytes
  const Handle set(H5Dcreate2(file_->id, name.c_str(), element_type<T>().stored, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose);
  file_->require(set >= 0, fmt::format("dataset '{}'", name));
  if (count > 0) {
    file_->require(H5Dwrite(set, element_type<T>().native, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
                   fmt::format("dataset '{}'", name));
  }
}

void Writer::attribute(const std::string& name, const std::string& value) {
  const Handle type = text_type();
  const char* text = value.c_str();
  file_->write_attribute(name, type, type, &text);
}
void Writer::attribute(const std::string& name, double value) { file_->write_attribute(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value); }
void Writer::attribute(const std::string& name, std::int64_t value) {
  file_->write_attribute(name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

void Writer::save(const std::filesystem::path& path, const std::filesystem::path& keep_as) {
  const QuietErrors quiet;
  AtomicFile file(path);  // first: a wrong path fails before the work
  require_memory(file_->bytes + library_memory);
  file_->require(H5Fflush(file_->id, H5F_SCOPE_GLOBAL) >= 0, "flush");
  const ssize_t size = H5Fget_file_image(file_->id, nullptr, 0);
  file_->require(size > 0, "size");
  std::vector<std::byte> image(static_cast<std::size_t>(size));
  file_->require(H5Fget_file_image(file_->id, image.data(), image.size()) == size, "image");
  file.write(image);
  file.write(seal(crc32_z(0, reinterpret_cast<const Bytef*>(image.data()), image.size())));
  file.commit(keep_as);
}

template void Writer::dataset(const std::string&, std::span<const double>, const Shape&);
template void Writer::dataset(const std::string&, std::span<const float>, const Shape&);
template void Writer::dataset(const std::string&, std::span<const std::uint64_t>, const Shape&);
template void Writer::dataset(const std::string&, std::span<const std::int64_t>, const Shape&);
template void Writer::dataset(const std::string&, std::span<const std::int32_t>, const Shape&);
template void Writer::dataset(const std::string&, std::span<const std::uint8_t>, const Shape&);

struct Reader::File {
  std::filesystem::path path;
  std::uintmax_t bytes = 0;  ///< of the HDF5 part
  hid_t id = -1;

  ~File() {
    if (id >= 0) H5Fclose(id);
  }

  [[noreturn]] void fail(const std::string& what) const { throw IoError(fmt::format("cannot read '{}': {}", path.string(), what)); }
  /// For failures inside the HDF5 library, which a file with a right seal should never cause.
  void require(bool ok, const std::string& what) const {
    if (!ok) fail(fmt::format("{}: {}; the file is damaged or of another version", what, innermost_message()));
  }

  /// Checks the seal. Reads the file once, in pieces.
  void check_seal() {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) throw file_error("cannot read", path, error.value());
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw file_error("cannot read", path, errno);
    const std::string damaged = "delete it and let the run write it again";
    if (size <= seal_size) fail(fmt::format("it has only {} bytes, it was cut off; {}", size, damaged));
    bytes = size - seal_size;
    uLong crc = 0;
    std::vector<char> piece(std::size_t{1} << 20);
    for (std::uintmax_t rest = bytes; rest > 0;) {
      const std::size_t n = static_cast<std::size_t>(std::min<std::uintmax_t>(rest, piece.size()));
      if (!stream.read(piece.data(), static_cast<std::streamsize>(n))) throw file_error("cannot read", path, errno != 0 ? errno : EIO);
      crc = crc32_z(crc, reinterpret_cast<const Bytef*>(piece.data()), n);
      rest -= n;
    }
    std::string found(seal_size, '\0');
    if (!stream.read(found.data(), seal_size)) throw file_error("cannot read", path, errno != 0 ? errno : EIO);
    if (found.substr(0, seal_mark.size()) != seal_mark)
      fail("it does not end as files of this program do: it was cut off or written by another program; " + damaged);
    if (found != seal(crc))
      fail(fmt::format("its checksum is {}, it should be {}: it was altered or damaged; {}", seal(crc).substr(seal_mark.size()),
                       found.substr(seal_mark.size()), damaged));
  }

  [[nodiscard]] Handle open_dataset(const std::string& name) const {
    if (H5Lexists(id, name.c_str(), H5P_DEFAULT) <= 0)
      fail(fmt::format("there is no dataset '{}'; the file is of another kind or version", name));
    Handle set(H5Dopen2(id, name.c_str(), H5P_DEFAULT), H5Dclose);
    require(set >= 0, fmt::format("dataset '{}'", name));
    return set;
  }
  [[nodiscard]] Shape shape_of(hid_t set, const std::string& name) const {
    const Handle space(H5Dget_space(set), H5Sclose);
    const int rank = space >= 0 ? H5Sget_simple_extent_ndims(space) : -1;
    require(rank >= 0, fmt::format("dataset '{}'", name));
    std::vector<hsize_t> extents(static_cast<std::size_t>(rank));
    H5Sget_simple_extent_dims(space, extents.data(), nullptr);
    return Shape(extents.begin(), extents.end());
  }
  /// Reads a scalar attribute whose stored type is of the given class.
  [[nodiscard]] Handle open_attribute(const std::string& name, H5T_class_t kind) const {
    if (H5Aexists(id, name.c_str()) <= 0) fail(fmt::format("there is no attribute '{}'; the file is of another kind or version", name));
    Handle attribute(H5Aopen(id, name.c_str(), H5P_DEFAULT), H5Aclose);
    require(attribute >= 0, fmt::format("attribute '{}'", name));
    const Handle type(H5Aget_type(attribute), H5Tclose);
    const Handle space(H5Aget_space(attribute), H5Sclose);
    if (H5Tget_class(type) != kind || H5Sget_simple_extent_npoints(space) != 1) {
      fail(fmt::format("attribute '{}' is of another type; the file is of another kind or version", name));
    }
    return attribute;
  }
};

Reader::Reader(std::filesystem::path path) : file_(std::make_unique<File>()) {
  const QuietErrors quiet;
  file_->path = std::move(path);
  file_->check_seal();
  require_memory(library_memory);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access, false, true);  // network file systems often refuse locks, and the files never change
  file_->id = H5Fopen(file_->path.c_str(), H5F_ACC_RDONLY, access);
  file_->require(file_->id >= 0, "open");
}

Reader::~Reader() {
  const QuietErrors quiet;
  file_.reset();
}

bool Reader::has_dataset(const std::string& name) const {
  const QuietErrors quiet;
  return H5Lexists(file_->id, name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Reader::datasets() const {
  const QuietErrors quiet;
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  file_->require(H5Literate(file_->id, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names) >= 0, "list of datasets");
  return names;
}

Shape Reader::shape(const std::string& name) const {
  const QuietErrors quiet;
  return file_->shape_of(file_->open_dataset(name), name);
}

template <Element T>
std::vector<T> Reader::dataset(const std::string& name, const Shape& expected) const {
  const QuietErrors quiet;
  const Handle set = file_->open_dataset(name);
  const Shape shape = file_->shape_of(set, name);
  const bool fits = shape.size() == expected.size() && std::equal(shape.begin(), shape.end(), expected.begin(),
                                                                  [](std::size_t n, std::size_t e) { return e == any_extent || n == e; });
  if (!fits) file_->fail(fmt::format("dataset '{}' has shape {}, {} was expected", name, describe(shape), describe(expected)));

  const Handle type(H5Dget_type(set), H5Tclose);
  const hid_t wanted = element_type<T>().native;
  const H5T_class_t kind = H5Tget_class(type);
  const std::size_t width = H5Tget_size(type);
  const bool same_sign = kind != H5T_INTEGER || H5Tget_sign(type) == H5Tget_sign(wanted);
  if (kind != H5Tget_class(wanted) || width == 0 || width > sizeof(T) || !same_sign) {
    file_->fail(fmt::format("dataset '{}' holds numbers of another type than expected", name));
  }
  std::uintmax_t count = 1;
  for (const std::size_t n : shape) {
    if (n > 0 && count > file_->bytes / n)
      file_->fail(fmt::format("dataset '{}' of shape {} is larger than the file", name, describe(shape)));
    count *= n;
  }
  if (count > file_->bytes / width) file_->fail(fmt::format("dataset '{}' of shape {} is larger than the file", name, describe(shape)));
  std::vector<T> values(count);
  if (count > 0) {
    file_->require(H5Dread(set, wanted, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0, fmt::format("dataset '{}'", name));
  }
  return values;
}

template std::vector<double> Reader::dataset(const std::string&, const Shape&) const;
template std::vector<float> Reader::dataset(const std::string&, const Shape&) const;
template std::vector<std::uint64_t> Reader::dataset(const std::string&, const Shape&) const;
template std::vector<std::int64_t> Reader::dataset(const std::string&, const Shape&) const;
template std::vector<std::int32_t> Reader::dataset(const std::string&, const Shape&) const;
template std::vector<std::uint8_t> Reader::dataset(const std::string&, const Shape&) const;

bool Reader::has_attribute(const std::string& name) const {
  const QuietErrors quiet;
  return H5Aexists(file_->id, name.c_str()) > 0;
}

std::string Reader::text(const std::string& name) const {
  const QuietErrors quiet;
  const Handle attribute = file_->open_attribute(name, H5T_STRING);
  const Handle stored(H5Aget_type(attribute), H5Tclose);
  if (H5Tis_variable_str(stored) <= 0)
    file_->fail(fmt::format("attribute '{}' is of another type; the file is of another kind or version", name));
  char* text = nullptr;
  file_->require(H5Aread(attribute, text_type(), &text) >= 0, fmt::format("attribute '{}'", name));
  std::string result = text != nullptr ? text : "";
  H5free_memory(text);
  return result;
}

double Reader::real(const std::string& name) const {
  const QuietErrors quiet;
  double value = 0.0;
  file_->require(H5Aread(file_->open_attribute(name, H5T_FLOAT), H5T_NATIVE_DOUBLE, &value) >= 0, fmt::format("attribute '{}'", name));
  return value;
}

std::int64_t Reader::integer(const std::string& name) const {
  const QuietErrors quiet;
  std::int64_t value = 0;
  file_->require(H5Aread(file_->open_attribute(name, H5T_INTEGER), H5T_NATIVE_INT64, &value) >= 0, fmt::format("attribute '{}'", name));
  return value;
}

}  // namespace mpm::hdf5
