#pragma once
/// HDF5 files (hdfgroup.org) of plain arrays and attributes in the root group: readable with h5py, h5dump and ParaView.
///
/// The HDF5 library writes the structure of the file. The content of the arrays is written directly to its place, piece by piece, also by
/// several processes, so that memory need not hold an array. The file appears complete or not at all (atomic_file.hpp), the library never
/// sees a write error (Target in hdf5_writer.cpp), and equal content gives equal bytes (no time stamps). After the end of the HDF5 part,
/// which other readers ignore, there are 16 bytes: `MPMCRC32` + the CRC-32 of all bytes before as eight hexadecimal digits. The Reader
/// checks them before it hands the file to the HDF5 library, so that a truncated or altered file gives a message instead of a crash.
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

#include "libmpm/io/atomic_file.hpp"

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

/// Consecutive bytes that were written into a file.
struct WrittenBytes {
  std::uint64_t offset = 0;  ///< of the first in the file
  std::uint64_t count = 0;   ///< of bytes
  std::uint64_t crc = 0;     ///< their CRC-32
};

/// Where the declared arrays of a file under construction are: what a process needs to write values of them.
struct Layout {
  /// Place of one array in the file.
  struct Array {
    std::string name;          ///< of the dataset
    std::uint64_t offset = 0;  ///< of its first byte
    std::uint64_t bytes = 0;   ///< all that it takes
  };
  std::filesystem::path target;     ///< name that the file will have
  std::filesystem::path temporary;  ///< where it is now
  std::vector<Array> arrays;        ///< in the order of their declaration
};

/// Writes values of declared arrays, on any process that sees the file.
class ArrayWriter {
 public:
  /// @throws IoError if the file is not there
  explicit ArrayWriter(Layout layout);
  /// @param first  place of the first of these values in the array. @throws IoError also if they reach beyond the array
  template <Element T>
  void write(const std::string& name, std::uint64_t first, std::span<const T> values);
  /// Forces all to the disk. Call once, last. @returns what was written, for Writer::add. @throws IoError
  std::vector<WrittenBytes> finish();

 private:
  void write_bytes(const std::string& name, std::uint64_t first, std::span<const std::byte> bytes);

  Layout layout_;
  FileShare file_;
  std::vector<std::vector<WrittenBytes>> written_;  ///< by array
};

/// Writes a file. Arrays are written at once, or declared and then written piece by piece by one or several ArrayWriter.
class Writer {
 public:
  /// Begins the file under a temporary name. @throws IoError
  explicit Writer(const std::filesystem::path& path);
  /// Removes the file if it was not committed.
  ~Writer();

  /// Writes an array. @param shape product = number of values; left out: one-dimensional. @throws IoError
  template <Element T>
  void dataset(const std::string& name, std::span<const T> values, const Shape& shape = {});
  /// Declares an array whose values an ArrayWriter writes. @throws IoError
  template <Element T>
  void declare(const std::string& name, const Shape& shape);
  [[nodiscard]] Layout layout() const;  ///< for ArrayWriter
  /// What an ArrayWriter has written, in any order.
  void add(std::span<const WrittenBytes> written);

  /// Attributes of the root group.
  void attribute(const std::string& name, const std::string& value);
  /// A number, as float64.
  void attribute(const std::string& name, double value);
  /// A whole number, as int64.
  void attribute(const std::string& name, std::int64_t value);

  /// Gives the file its name. Call once, last. @throws IoError also if a value of an array was not written, or twice: the file is then
  /// removed
  /// @param keep_as  new name of an existing file (AtomicFile::commit); empty: it is replaced
  void commit(const std::filesystem::path& keep_as = {});

 private:
  struct File;
  std::unique_ptr<File> file_;
};

/// Whether a Reader checks the end of a file.
enum class Seal : std::uint8_t { check, known_good };

/// Reads a file that Writer wrote. Existence, type and shape of each array are checked before memory is allocated.
class Reader {
 public:
  /// @param seal  known_good: another process has just checked it, which reads the whole file
  /// @throws IoError if the file is missing, truncated, altered or of another program
  explicit Reader(std::filesystem::path path, Seal seal = Seal::check);
  ~Reader();

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
