#include "libmpm/io/csv.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "libmpm/base/text.hpp"

namespace mpm {
namespace {

constexpr std::string_view blanks = " \t\r";

/// Cells of one line; a cell in double quotes may hold commas, and "" for a quote. False if a quote stays open.
bool split_line(std::string_view line, std::vector<std::string>& cells) {
  cells.clear();
  std::size_t at = 0;
  for (;;) {
    while (at < line.size() && (line[at] == ' ' || line[at] == '\t')) ++at;
    std::string cell;
    if (at < line.size() && line[at] == '"') {
      for (++at;; ++at) {
        if (at >= line.size()) return false;
        if (line[at] != '"') {
          cell += line[at];
        } else if (at + 1 < line.size() && line[at + 1] == '"') {
          cell += '"';
          ++at;
        } else {
          break;
        }
      }
      at = line.find(',', at);
    } else {
      const std::size_t comma = line.find(',', at);
      cell = trimmed(line.substr(at, comma == std::string_view::npos ? comma : comma - at), blanks);
      at = comma;
    }
    cells.push_back(std::move(cell));
    if (at == std::string_view::npos) return true;
    ++at;
  }
}

/// The number in a cell, NaN if it is empty; nothing if it is not one number.
std::optional<double> cell_number(std::string_view cell) {
  return cell.empty() ? std::numeric_limits<double>::quiet_NaN() : parse_number(cell);
}

}  // namespace

Table Table::read(const std::filesystem::path& path, LastLine last_line) {
  constexpr std::uintmax_t most_bytes = std::uintmax_t{256} << 20;  // in memory the cells take up to 16 times as much
  constexpr std::size_t most_columns = 10'000;
  const std::string content = read_text_file(path, most_bytes);
  std::string_view rest = without_byte_order_mark(content);
  if (last_line == LastLine::may_be_torn) rest = rest.substr(0, rest.rfind('\n') + 1);  // npos + 1 = 0: no complete line

  Table table;
  table.path_ = path;
  std::vector<std::string> cells;
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::size_t newline = rest.find('\n');
    const std::string_view line = trimmed(rest.substr(0, newline), blanks);
    rest = newline == std::string_view::npos ? std::string_view() : rest.substr(newline + 1);
    if (line.empty() || line.front() == '#') continue;
    if (!split_line(line, cells))
      throw IoError(fmt::format("{}:{}: a double quote is not closed; add the closing quote", path.string(), number));
    if (table.columns_.empty()) {
      if (cells.size() > most_columns)
        throw IoError(fmt::format("{}:{}: {} columns; at most {} are possible", path.string(), number, cells.size(), most_columns));
      for (std::size_t i = 0; i < cells.size(); ++i) {
        if (cells[i].empty()) {
          throw IoError(fmt::format("{}:{}: column {} has no name; the first line must name every column", path.string(), number, i + 1));
        }
        if (std::find(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(i), cells[i]) !=
            cells.begin() + static_cast<std::ptrdiff_t>(i)) {
          throw IoError(fmt::format("{}:{}: column '{}' is named twice; names must differ", path.string(), number, cells[i]));
        }
      }
      table.columns_ = cells;
      continue;
    }
    if (cells.size() != table.columns_.size()) {
      throw IoError(fmt::format("{}:{}: {} where the header names {}; the line is damaged or the header is not its own", path.string(),
                                number, counted(cells.size(), "cell"), counted(table.columns_.size(), "column")));
    }
    table.cells_.push_back(cells);
    table.lines_.push_back(number);
  }
  if (table.columns_.empty()) throw IoError(fmt::format("{}: no header line; the file is empty or was cut off", path.string()));
  return table;
}

bool Table::has(std::string_view column) const { return std::find(columns_.begin(), columns_.end(), column) != columns_.end(); }

std::size_t Table::index(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end())
    throw IoError(fmt::format("{}: no column '{}'; there are: {}", path_.string(), column, fmt::join(columns_, ", ")));
  return static_cast<std::size_t>(found - columns_.begin());
}

std::vector<double> Table::numbers(std::string_view column) const {
  const std::size_t c = index(column);
  std::vector<double> result(rows());
  for (std::size_t r = 0; r < rows(); ++r) {
    const auto number = cell_number(cells_[r][c]);
    if (!number)
      throw IoError(fmt::format("{}:{}: column '{}' holds '{}'; a number is needed", path_.string(), lines_[r], column, cells_[r][c]));
    result[r] = *number;
  }
  return result;
}

std::vector<std::string> Table::text(std::string_view column) const {
  const std::size_t c = index(column);
  std::vector<std::string> result;
  for (const auto& row : cells_) result.push_back(row[c]);
  return result;
}

std::string format_number(double value) {
  if (std::isnan(value)) return "nan";  // never "-nan", which some readers refuse
  return fmt::format("{}", value);
}

namespace {
std::string csv_cell(const std::string& text) {
  std::string plain = text;
  std::ranges::replace(plain, '\n', ' ');
  if (plain.find_first_of(",\"#") == std::string::npos) return plain;
  std::string quoted = "\"";
  for (const char c : plain) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}
}  // namespace

std::string csv_line(std::span<const double> values) {
  std::string line;
  for (const double value : values) {
    if (!line.empty()) line += ',';
    line += format_number(value);
  }
  return line + '\n';
}

std::string csv_line(std::span<const std::string> cells) {
  std::vector<std::string> quoted;
  for (const std::string& cell : cells) quoted.push_back(csv_cell(cell));
  return fmt::format("{}\n", fmt::join(quoted, ","));
}

std::string table_text(std::span<const std::string> columns, std::span<const std::vector<double>> values) {
  std::string content = csv_line(columns);
  std::vector<double> row(values.size());
  for (std::size_t r = 0; !values.empty() && r < values.front().size(); ++r) {
    std::ranges::transform(values, row.begin(), [r](const std::vector<double>& column) { return column[r]; });
    content += csv_line(row);
  }
  return content;
}

void write_table(const std::filesystem::path& path, std::span<const std::string> columns, std::span<const std::vector<double>> values) {
  if (columns.size() != values.size())
    throw IoError(fmt::format("{}: {} columns are named but {} given", path.string(), columns.size(), values.size()));
  const std::size_t rows = values.empty() ? 0 : values.front().size();
  for (std::size_t c = 0; c < values.size(); ++c) {
    if (values[c].size() != rows) {
      throw IoError(fmt::format("{}: column '{}' has {} rows, '{}' has {}", path.string(), columns[c], values[c].size(), columns[0], rows));
    }
  }
  write_file(path, table_text(columns, values));
}

SeriesWriter::SeriesWriter(std::filesystem::path path, std::size_t columns, const std::string& content)
    : path_(std::move(path)), columns_(columns) {
  write_file(path_, content);
  file_ = Descriptor(::open(path_.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC));
  if (!file_) throw file_error("cannot append to", path_, errno);
}

void SeriesWriter::require_in_place() const {
  struct stat here {
  }, there{};
  if (::fstat(file_.get(), &here) != 0) throw file_error("cannot append to", path_, errno);
  if (::stat(path_.c_str(), &there) != 0 || here.st_dev != there.st_dev || here.st_ino != there.st_ino) {
    throw IoError(
        fmt::format("'{}' was deleted, moved or replaced while the run went on: its rows are lost; put the directory back and go "
                    "on with --resume, or run again",
                    path_.string()));
  }
}

void SeriesWriter::sync() {
  require_in_place();
  if (::fsync(file_.get()) != 0) throw file_error("cannot append to", path_, errno);
}

void SeriesWriter::append(std::span<const double> values) {
  if (values.size() != columns_) {
    throw IoError(fmt::format("{}: a row of {} numbers for {} columns", path_.string(), values.size(), columns_));
  }
  if (const int reason = file_.write(csv_line(values)); reason != 0) throw file_error("cannot append to", path_, reason);
  require_in_place();
}

}  // namespace mpm
