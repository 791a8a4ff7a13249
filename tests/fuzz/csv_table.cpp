#include <bit>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/io/csv.hpp"
#include "memory_file.hpp"
#include "targets.hpp"

namespace mpm::fuzz {

namespace {

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

/// The lines that write_table would write.
std::string text_of(const Table& table, const std::vector<std::vector<double>>& values) {
  std::string text;
  for (const std::string& name : table.columns()) text += (text.empty() ? "" : ",") + name;
  text += '\n';
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (std::size_t c = 0; c < values.size(); ++c) text += (c > 0 ? "," : "") + format_number(values[c][row]);
    text += '\n';
  }
  return text;
}

void read(const std::filesystem::path& path, Table::LastLine last_line) {
  std::vector<std::vector<double>> values;
  std::optional<Table> table;
  try {
    table = Table::read(path, last_line);
    for (const std::string& name : table->columns()) {
      require(table->text(name).size() == table->rows(), "as many cells as rows");
      values.push_back(table->numbers(name));
    }
  } catch (const IoError&) {
    return;
  }
  // Names that need quotes are not written by this program.
  for (const std::string& name : table->columns()) {
    if (name.find_first_of(",\"#\r\n\t ") != std::string::npos) return;
  }
  const std::string text = text_of(*table, values);
  const MemoryFile copy({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  const Table again = Table::read(copy.path());
  require(again.columns() == table->columns() && again.rows() == table->rows(), "a written table reads back");
  for (std::size_t c = 0; c < values.size(); ++c) {
    const auto numbers = again.numbers(again.columns()[c]);
    for (std::size_t row = 0; row < numbers.size(); ++row) require(same(numbers[row], values[c][row]), "to the same numbers");
  }
}

}  // namespace

void csv_table(Bytes input) {
  const MemoryFile file(input);
  read(file.path(), Table::LastLine::whole);
  read(file.path(), Table::LastLine::may_be_torn);
}

}  // namespace mpm::fuzz
