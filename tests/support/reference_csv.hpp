#pragma once
/// Reads reference_data/<name>/data.csv for tests: lines that start with '#' are comments, the first other line holds the column names.

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace mpm::testing {

using CsvRow = std::map<std::string, std::string>;

inline std::vector<CsvRow> read_reference(const std::string& name) {
  const auto path = std::filesystem::path(MPM_SOURCE_DIR) / "reference_data" / name / "data.csv";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("no reference data in " + path.string());
  const auto split = [](const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    return fields;
  };
  std::vector<CsvRow> rows;
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    const auto fields = split(line);
    if (names.empty()) {
      names = fields;
      continue;
    }
    if (fields.size() != names.size()) throw std::runtime_error("row with another number of fields than the header in " + path.string());
    CsvRow row;
    for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = fields[i];
    rows.push_back(row);
  }
  if (rows.empty()) throw std::runtime_error("no rows in " + path.string());
  return rows;
}

inline double number(const CsvRow& row, const std::string& column) { return std::stod(row.at(column)); }

}  // namespace mpm::testing
