#pragma once
/// Tables as CSV: a header line of column names that end in their unit (`runup_m`), then one line a row. Numbers are written
/// with the fewest digits that read back to the same double; unknown values are written as `nan`. Lines that begin with
/// `#` are comments; text that holds a comma is in double quotes.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/io/atomic_file.hpp"

namespace mpm {

/// A table read from a file. Errors are IoErrors of the form `file:line: what, the value; the remedy`.
class Table {
 public:
  /// Last line of a file without a newline at its end.
  enum class LastLine {
    whole,        ///< a complete line
    may_be_torn,  ///< dropped: the writer may have been killed inside it (series.csv)
  };

  /// @throws IoError if the file cannot be read, has no header, or a row with another number of cells
  static Table read(const std::filesystem::path& path, LastLine last_line = LastLine::whole);

  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }  ///< names in the order of the file
  [[nodiscard]] std::size_t rows() const { return cells_.size(); }                    ///< without the header
  [[nodiscard]] bool has(std::string_view column) const;                              ///< whether there is a column of this name

  /// Numbers of a column; an empty cell is NaN. @throws IoError for an unknown column or a cell that is not a number
  [[nodiscard]] std::vector<double> numbers(std::string_view column) const;
  /// The cells of a column as text. @throws IoError for an unknown column
  [[nodiscard]] std::vector<std::string> text(std::string_view column) const;

 private:
  [[nodiscard]] std::size_t index(std::string_view column) const;

  std::filesystem::path path_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> cells_;  ///< row by row
  std::vector<std::size_t> lines_;               ///< line number of each row
};

/// Shortest decimal text that reads back to the same double.
std::string format_number(double value);

/// One line of a table of text: cells that need it are in double quotes, a line break becomes a blank.
std::string csv_line(std::span<const std::string> cells);
/// One line of a table of numbers.
std::string csv_line(std::span<const double> values);

/// A table of numbers. @param values column by column, all of one length
[[nodiscard]] std::string table_text(std::span<const std::string> columns, std::span<const std::vector<double>> values);
/// Writes a table of numbers as an atomic file (atomic_file.hpp). @param values column by column, all of one length
void write_table(const std::filesystem::path& path, std::span<const std::string> columns, std::span<const std::vector<double>> values);

/// A table that grows during a run. append() writes each row with one system call: a kill loses at most the row that is being written, a
/// power cut at most the rows since sync(). The destructor closes the file without sync().
class SeriesWriter {
 public:
  /// Starts the file anew. @param content  table_text() of the rows before those that append() adds, of the same number of columns
  SeriesWriter(std::filesystem::path path, std::size_t columns, const std::string& content);

  /// @param values one number a column
  /// @throws IoError also if the file is not the one under its name any more: deleted, moved or replaced meanwhile
  void append(std::span<const double> values);

  /// Forces the rows to the disk. @throws IoError as append()
  void sync();

 private:
  void require_in_place() const;

  std::filesystem::path path_;
  std::size_t columns_;
  Descriptor file_;
};

}  // namespace mpm
