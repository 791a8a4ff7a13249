#include <H5FDpublic.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <numeric>

#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5_library.hpp"

namespace mpm::hdf5 {

ArrayWriter::ArrayWriter(Layout layout)
    : layout_(std::move(layout)), file_(layout_.target, layout_.temporary), written_(layout_.arrays.size()) {}

void ArrayWriter::write_bytes(const std::string& name, std::uint64_t first, std::span<const std::byte> bytes) {
  const auto array = std::ranges::find(layout_.arrays, name, &Layout::Array::name);
  const auto refuse = [&](const char* what) {
    throw IoError(fmt::format("cannot write '{}': dataset '{}' {}", layout_.target.string(), name, what));
  };
  if (array == layout_.arrays.end()) refuse("was not declared");
  if (first > array->bytes || bytes.size() > array->bytes - first) refuse("is given more values than its shape has");
  file_.write_at(array->offset + first, bytes);
  std::vector<WrittenBytes>& written = written_[static_cast<std::size_t>(array - layout_.arrays.begin())];
  const std::uint64_t offset = array->offset + first;
  if (written.empty() || written.back().offset + written.back().count != offset) written.push_back({.offset = offset});
  written.back().crc = crc_of(written.back().crc, bytes);
  written.back().count += bytes.size();
}

template <Element T>
void ArrayWriter::write(const std::string& name, std::uint64_t first, std::span<const T> values) {
  static_assert(std::endian::native == std::endian::little, "arrays are written as they are in memory; files are little-endian");
  write_bytes(name, first * sizeof(T), std::as_bytes(values));
}

std::vector<WrittenBytes> ArrayWriter::finish() {
  file_.sync();
  std::vector<WrittenBytes> all;
  for (const auto& of_array : written_) all.insert(all.end(), of_array.begin(), of_array.end());
  return all;
}

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

/// Functions called by the library.
struct Driver {
  struct OpenFile : H5FD_t {
    Target* target;
  };
  // The library hands out what open() made. NOLINTBEGIN(cppcoreguidelines-pro-type-static-cast-downcast)
  static Target& target(const H5FD_t* file) { return *static_cast<const OpenFile*>(file)->target; }
  // NOLINTEND(cppcoreguidelines-pro-type-static-cast-downcast)

  static H5FD_t* open(const char*, unsigned, hid_t access, haddr_t) {
    auto* file = new (std::nothrow) OpenFile{};
    if (file != nullptr) file->target = *static_cast<Target* const*>(H5Pget_driver_info(access));
    return file;
  }
  static herr_t close(H5FD_t* file) {
    delete static_cast<OpenFile*>(file);  // NOLINT(cppcoreguidelines-pro-type-static-cast-downcast): likewise
    return 0;
  }
  static herr_t query(const H5FD_t*, unsigned long* flags) {  // as in the library's own drivers; they determine the layout of files
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
  }
  static haddr_t get_end(const H5FD_t* file, H5FD_mem_t) { return target(file).end_; }
  static herr_t set_end(H5FD_t* file, H5FD_mem_t, haddr_t end) {
    target(file).end_ = end;
    return 0;
  }

  static herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* to) {
    Target& t = target(file);
    t.failure_.attempt([&] { t.file_.read_at(at, {static_cast<std::byte*>(to), size}); });
    return 0;
  }
  static herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, const void* from) {
    Target& t = target(file);
    t.failure_.attempt([&] { t.file_.write_at(at, {static_cast<const std::byte*>(from), size}); });
    return 0;
  }

  static hid_t made() {
    H5FD_class_t functions{};
    functions.name = "libmpm";
    functions.maxaddr = (haddr_t{1} << 63) - 1;
    functions.fc_degree = H5F_CLOSE_WEAK;
    functions.fapl_size = sizeof(Target*);  // NOLINT(bugprone-sizeof-expression): a pointer is what it holds
    functions.open = open;
    functions.close = close;
    functions.query = query;
    functions.get_eoa = get_end;
    functions.set_eoa = set_end;
    functions.get_eof = get_end;
    functions.read = read;
    functions.write = write;
    constexpr H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
    std::ranges::copy(map, functions.fl_map);
    return H5FDregister(&functions);
  }
};

std::int64_t Target::create() {
  static const hid_t driver = Driver::made();
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  Target* const self = this;
  if (driver < 0 || H5Pset_driver(access, driver, &self) < 0) return -1;
  return H5Fcreate("libmpm", H5F_ACC_TRUNC, H5P_DEFAULT, access);
}

struct Writer::File {
  AtomicFile file;
  Target target{file};
  hid_t id = -1;
  std::vector<Layout::Array> arrays;
  std::vector<WrittenBytes> written;

  explicit File(const std::filesystem::path& path) : file(path) {}
  ~File() {
    if (id >= 0) H5Fclose(id);
  }
  /// Not a disk error (see Target): lack of memory or an invalid argument.
  void require(bool ok, const std::string& what) const {
    if (!ok) {
      throw IoError(fmt::format("cannot write '{}': {}: {}; if memory is short, raise its limit or take a smaller case",
                                file.path().string(), what, innermost_message()));
    }
  }
  void write_attribute(const std::string& name, hid_t type, hid_t memory_type, const void* value) const {
    const QuietErrors quiet;
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle attribute(H5Acreate2(id, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    require(attribute >= 0, fmt::format("attribute '{}'", name));
    require(H5Awrite(attribute, memory_type, value) >= 0, fmt::format("attribute '{}'", name));
  }
  [[noreturn]] void refuse(const std::string& name, const std::string& what) const {
    throw IoError(fmt::format("cannot write '{}': dataset '{}' {}", file.path().string(), name, what));
  }
  void declare(const std::string& name, const Shape& shape, const ElementType& type, std::size_t size_of_element);
  [[nodiscard]] uLong crc_of_all();
};

/// The library allocates an array's place when its first value is written, and does not write the others.
void Writer::File::declare(const std::string& name, const Shape& shape, const ElementType& type, std::size_t size_of_element) {
  const QuietErrors quiet;
  require_library_memory();
  const std::vector<hsize_t> extents(shape.begin(), shape.end());
  const Handle space(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), H5Sclose);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);  // equal content, equal bytes
  const Handle set(H5Dcreate2(id, name.c_str(), type.stored, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose);
  require(set >= 0, fmt::format("dataset '{}'", name));
  Layout::Array array{.name = name};
  array.bytes = std::accumulate(shape.begin(), shape.end(), size_of_element, std::multiplies<>());
  if (array.bytes > 0) {
    const std::vector<hsize_t> first(extents.size(), 0), one(extents.size(), 1);
    const Handle value(H5Screate(H5S_SCALAR), H5Sclose);
    const std::uint64_t nothing = 0;
    require(H5Sselect_hyperslab(space, H5S_SELECT_SET, first.data(), nullptr, one.data(), nullptr) >= 0 &&
                H5Dwrite(set, type.native, value, space, H5P_DEFAULT, &nothing) >= 0,
            fmt::format("dataset '{}'", name));
    array.offset = H5Dget_offset(set);
    require(array.offset != HADDR_UNDEF, fmt::format("place of dataset '{}'", name));
  }
  target.rethrow();
  arrays.push_back(std::move(array));
}

/// The checksums of the arrays are known; the few bytes between them are read back.
uLong Writer::File::crc_of_all() {
  std::erase_if(arrays, [](const Layout::Array& array) { return array.bytes == 0; });
  std::ranges::sort(arrays, {}, &Layout::Array::offset);
  std::erase_if(written, [](const WrittenBytes& part) { return part.count == 0; });
  std::ranges::sort(written, {}, &WrittenBytes::offset);
  auto part = written.begin();
  uLong crc = 0;
  std::uint64_t at = 0;
  std::vector<std::byte> between;
  const auto read_up_to = [&](std::uint64_t end) {
    between.resize(end - at);
    file.read_at(at, between);
    crc = crc_of(crc, between);
  };
  for (const Layout::Array& array : arrays) {
    read_up_to(array.offset);
    for (at = array.offset; part != written.end() && part->offset == at && at < array.offset + array.bytes; ++part) {
      crc = crc32_combine(crc, part->crc, static_cast<z_off_t>(part->count));
      at += part->count;
    }
    if (at < array.offset + array.bytes) refuse(array.name, "is given fewer values than its shape has");
    if (part != written.end() && part->offset < at) refuse(array.name, "is given values twice");
  }
  read_up_to(target.size());
  return crc;
}

Writer::Writer(const std::filesystem::path& path) : file_(std::make_unique<File>(path)) {
  require_library_memory();  // before the first call of the library, which allocates its tables
  const QuietErrors quiet;
  file_->id = file_->target.create();
  file_->require(file_->id >= 0, "create");
  file_->target.rethrow();
}

Writer::~Writer() {
  const QuietErrors quiet;
  file_.reset();
}

template <Element T>
void Writer::declare(const std::string& name, const Shape& shape) {
  file_->declare(name, shape, element_type<T>(), sizeof(T));
}

Layout Writer::layout() const { return {file_->file.path(), std::filesystem::absolute(file_->file.temporary()), file_->arrays}; }

void Writer::add(std::span<const WrittenBytes> written) { file_->written.insert(file_->written.end(), written.begin(), written.end()); }

template <Element T>
void Writer::dataset(const std::string& name, std::span<const T> values, const Shape& shape) {
  const Shape extents = shape.empty() ? Shape{values.size()} : shape;
  if (std::accumulate(extents.begin(), extents.end(), std::size_t{1}, std::multiplies<>()) != values.size())
    file_->refuse(name, fmt::format("of shape {} is given {} values", describe(extents), values.size()));
  declare<T>(name, extents);
  const std::uint64_t offset = file_->arrays.back().offset;
  file_->file.write_at(offset, std::as_bytes(values));
  file_->written.push_back({offset, values.size_bytes(), crc_of(0, std::as_bytes(values))});
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

void Writer::commit(const std::filesystem::path& keep_as) {
  const QuietErrors quiet;
  require_library_memory();
  file_->require(H5Fclose(std::exchange(file_->id, -1)) >= 0, "close");
  file_->target.rethrow();
  const std::string end = seal(file_->crc_of_all());
  file_->file.write_at(file_->target.size(), std::as_bytes(std::span(end)));
  file_->file.commit(keep_as);
}

#define MPM_ELEMENT(T)                                                                     \
  template void Writer::declare<T>(const std::string&, const Shape&);                      \
  template void ArrayWriter::write(const std::string&, std::uint64_t, std::span<const T>); \
  template void Writer::dataset(const std::string&, std::span<const T>, const Shape&)
MPM_ELEMENT(double);
MPM_ELEMENT(float);
MPM_ELEMENT(std::uint64_t);
MPM_ELEMENT(std::int64_t);
MPM_ELEMENT(std::int32_t);
MPM_ELEMENT(std::uint8_t);
#undef MPM_ELEMENT

}  // namespace mpm::hdf5
