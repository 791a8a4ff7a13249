#include "libmpm/io/hdf5_target.hpp"

#include <H5FDpublic.h>
#include <hdf5.h>

#include <algorithm>
#include <new>
#include <span>

#include "libmpm/io/hdf5_library.hpp"

namespace mpm::hdf5 {

/// Functions called by the library.
struct Driver {
  struct OpenFile : H5FD_t {
    Target* target;
  };
  // The library hands out what open() made. NOLINTBEGIN(cppcoreguidelines-pro-type-static-cast-downcast)
  static OpenFile* made_by_open(H5FD_t* file) { return static_cast<OpenFile*>(file); }
  static const OpenFile* made_by_open(const H5FD_t* file) { return static_cast<const OpenFile*>(file); }
  // NOLINTEND(cppcoreguidelines-pro-type-static-cast-downcast)
  static Target& target(H5FD_t* file) { return *made_by_open(file)->target; }
  static const Target& target(const H5FD_t* file) { return *made_by_open(file)->target; }

  static H5FD_t* open(const char*, unsigned, hid_t access, haddr_t) {
    auto* file = new (std::nothrow) OpenFile{};
    if (file != nullptr) file->target = *static_cast<Target* const*>(H5Pget_driver_info(access));
    return file;
  }
  static herr_t close(H5FD_t* file) {
    delete made_by_open(file);
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

}  // namespace mpm::hdf5
