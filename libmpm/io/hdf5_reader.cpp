#include <algorithm>
#include <cerrno>
#include <fstream>
#include <utility>

#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5_library.hpp"

namespace mpm::hdf5 {

bool usable_by_threads() {
  hbool_t safe = 0;
  return H5is_library_threadsafe(&safe) >= 0 && safe != 0;
}

struct Reader::File {
  std::filesystem::path path;
  std::uintmax_t bytes = 0;  ///< of the HDF5 part
  hid_t id = -1;

  ~File() {
    if (id >= 0) H5Fclose(id);
  }

  [[noreturn]] void fail(const std::string& what) const { throw IoError(fmt::format("cannot read '{}': {}", path.string(), what)); }
  /// For failures inside the HDF5 library, which a file with a correct checksum should never cause.
  void require(bool ok, const std::string& what) const {
    if (!ok) fail(fmt::format("{}: {}; the file is damaged or of another version", what, innermost_message()));
  }

  static constexpr const char* damaged = "delete it and let the run write it again";

  void find_size() {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    if (error) throw file_error("cannot read", path, error.value());
    if (size <= seal_size) fail(fmt::format("it has only {} bytes, it was cut off; {}", size, damaged));
    bytes = size - seal_size;
  }
  /// Reads the file once, in pieces.
  void check_seal() {
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw file_error("cannot read", path, errno);
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
      fail(fmt::format("it does not end as files of this program do: it was cut off or written by another program; {}", damaged));
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
  template <Element T>
  [[nodiscard]] T number(const std::string& name, H5T_class_t kind) const {
    const QuietErrors quiet;
    T value{};
    require(H5Aread(open_attribute(name, kind), element_type<T>().native, &value) >= 0, fmt::format("attribute '{}'", name));
    return value;
  }
};

Reader::Reader(std::filesystem::path path, Seal seal) : file_(std::make_unique<File>()) {
  file_->path = std::move(path);
  file_->find_size();
  if (seal == Seal::check) file_->check_seal();
  require_library_memory();  // before the first call of the library, which allocates its tables
  const QuietErrors quiet;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access, false, true);  // network file systems often refuse locks, and the files never change
  file_->id = H5Fopen(file_->path.c_str(), H5F_ACC_RDONLY, access);
  file_->require(file_->id >= 0, "open");
}

Reader::~Reader() {
  const QuietErrors quiet;
  file_.reset();
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
std::vector<T> Reader::rows(const std::string& name, const Shape& expected, std::size_t first, std::size_t count) const {
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
  std::uintmax_t all = 1;
  for (const std::size_t n : shape) {
    if (n > 0 && all > file_->bytes / n)
      file_->fail(fmt::format("dataset '{}' of shape {} is larger than the file", name, describe(shape)));
    all *= n;
  }
  if (all > file_->bytes / width) file_->fail(fmt::format("dataset '{}' of shape {} is larger than the file", name, describe(shape)));
  const std::size_t length = shape.empty() ? 1 : shape.front();
  if (count == any_extent) count = length - std::min(first, length);
  if (first > length || count > length - first)
    file_->fail(fmt::format("dataset '{}' of shape {} has no {} rows from row {} on", name, describe(shape), count, first));
  std::vector<T> values(length == 0 ? 0 : all / length * count);
  if (values.empty()) return values;
  const Handle place(H5Dget_space(set), H5Sclose);
  if (count < length) {
    std::vector<hsize_t> start(shape.size(), 0), extent(shape.begin(), shape.end());
    start[0] = first;
    extent[0] = count;
    file_->require(H5Sselect_hyperslab(place, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr) >= 0,
                   fmt::format("rows of dataset '{}'", name));
  }
  const hsize_t size = values.size();
  const Handle here(H5Screate_simple(1, &size, nullptr), H5Sclose);
  file_->require(H5Dread(set, wanted, here, place, H5P_DEFAULT, values.data()) >= 0, fmt::format("dataset '{}'", name));
  return values;
}

template std::vector<double> Reader::rows(const std::string&, const Shape&, std::size_t, std::size_t) const;
template std::vector<float> Reader::rows(const std::string&, const Shape&, std::size_t, std::size_t) const;
template std::vector<std::uint64_t> Reader::rows(const std::string&, const Shape&, std::size_t, std::size_t) const;
template std::vector<std::int64_t> Reader::rows(const std::string&, const Shape&, std::size_t, std::size_t) const;
template std::vector<std::int32_t> Reader::rows(const std::string&, const Shape&, std::size_t, std::size_t) const;
template std::vector<std::uint8_t> Reader::rows(const std::string&, const Shape&, std::size_t, std::size_t) const;

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

double Reader::real(const std::string& name) const { return file_->number<double>(name, H5T_FLOAT); }
std::int64_t Reader::integer(const std::string& name) const { return file_->number<std::int64_t>(name, H5T_INTEGER); }

}  // namespace mpm::hdf5
