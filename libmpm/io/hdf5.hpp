#pragma once
/// HDF5 files (hdfgroup.org) of plain arrays and attributes in the root group: readable with h5py, h5dump and ParaView.
///
/// The HDF5 library writes the structure of the file. The content of the arrays is written directly to its place, piece by piece, so that
/// memory need not hold an array. The file appears complete or not at all (atomic_file.hpp), the library never sees a write error
/// (hdf5_target.hpp), and equal content gives equal bytes (no time stamps). After the end of the HDF5 part, which other readers
/// ignore, there are 16 bytes: `MPMCRC32` + the CRC-32 of all bytes before as eight hexadecimal digits. The Reader checks them before it
/// hands the file to the HDF5 library, so that a truncated or altered file gives a message instead of a crash.
///
/// Arrays are stored contiguous and uncompressed. Measured on synthetic frames of 376,000 particles (47 MB) in memory:
/// written in 0.28 s, fsync included; shuffle and deflate take 0.4 to 0.5 s more on one core and save 46 % (noisy) to 64 % (clean).

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "libmpm/base/error.hpp"

namespace mpm::hdf5 {

/// Extents of an array, slowest first, as in C and numpy.
using Shape = std::vector<std::size_t>;

/// In an expected shape: any extent.
inline constexpr std::size_t any_extent = static_cast<std::size_t>(-1);

/// Types of numbers that an array may hold.
template <class T>
concept Element = std::same_as<T, double> || std::same_as<T, float> || std::same_as<T, std::uint64_t> || std::same_as<T, std::int64_t> ||
    std::same_as<T, std::int32_t> || std::same_as<T, std::uint8_t>;

/// Whether several threads may use files at once: true if the HDF5 library is built thread-safe, as Debian's is.
[[nodiscard]] bool usable_by_threads();

/// Writes a file. Arrays are written at once, or declared and then written piece by piece.
class Writer {
 public:
  /// Begins the file under a temporary name. @throws IoError
  explicit Writer(const std::filesystem::path& path);
  /// Removes the file if it was not committed.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Writes an array. @param shape product = number of values; left out: one-dimensional. @throws IoError
  template <Element T>
  void dataset(const std::string& name, std::span<const T> values, const Shape& shape = {});
  /// Declares an array whose values follow by append(). @throws IoError
  template <Element T>
  void declare(const std::string& name, const Shape& shape);
  /// The next values of a declared array, in its order. @throws IoError also if there are more than its shape has
  template <Element T>
  void append(const std::string& name, std::span<const T> values);

  /// Attributes of the root group.
  void attribute(const std::string& name, const std::string& value);
  /// A number, as float64.
  void attribute(const std::string& name, double value);
  /// A whole number, as int64.
  void attribute(const std::string& name, std::int64_t value);

  /// Gives the file its name. Call once, last. @throws IoError also if an array lacks values: the file is then removed
  /// @param keep_as  new name of an existing file (AtomicFile::commit); empty: it is replaced
  void commit(const std::filesystem::path& keep_as = {});

 private:
  struct File;
  std::unique_ptr<File> file_;
};

/// Reads a file that Writer wrote. Existence, type and shape of each array are checked before memory is allocated.
class Reader {
 public:
  /// @throws IoError if the file is missing, truncated, altered or of another program
  explicit Reader(std::filesystem::path path);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  [[nodiscard]] bool has_dataset(const std::string& name) const;  ///< whether there is an array of this name
  /// Names of all datasets, in the order of the alphabet.
  [[nodiscard]] std::vector<std::string> datasets() const;
  [[nodiscard]] Shape shape(const std::string& name) const;  ///< of an array; IoError if there is none

  /// @param expected shape that the array must have, with any_extent for any length. Narrower numbers of the same kind are
  ///        widened (float to double); no conversion loses anything.
  template <Element T>
  [[nodiscard]] std::vector<T> dataset(const std::string& name, const Shape& expected) const {
    return rows<T>(name, expected, 0, any_extent);
  }
  /// Some rows of an array, i.e. places along its first extent. @param count  any_extent: up to the last
  template <Element T>
  [[nodiscard]] std::vector<T> rows(const std::string& name, const Shape& expected, std::size_t first, std::size_t count) const;

  [[nodiscard]] bool has_attribute(const std::string& name) const;     ///< whether the root group has it
  [[nodiscard]] std::string text(const std::string& attribute) const;  ///< of an attribute; IoError if it is missing or not text
  [[nodiscard]] double real(
      const std::string& attribute) const;  ///< of an attribute; IoError if it is missing or not a floating-point number
  [[nodiscard]] std::int64_t integer(
      const std::string& attribute) const;  ///< of an attribute; IoError if it is missing or not a whole number

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace mpm::hdf5
