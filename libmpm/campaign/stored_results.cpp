#include "libmpm/campaign/stored_results.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "libmpm/campaign/input_columns.hpp"
#include "libmpm/config/schema.hpp"
#include "libmpm/driver/case_schema.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/json_object.hpp"

namespace mpm {

namespace {

using Json = nlohmann::ordered_json;

bool is_case_key(std::string_view column) {
  const std::size_t dot = column.find('.');
  return dot != std::string_view::npos && case_schema().find_key(column.substr(0, dot), column.substr(dot + 1)) != nullptr;
}

/// Whether a column tells of the campaign or of the case, and not of the results.
bool describes_the_run(const std::string& column) {
  constexpr std::string_view own[] = {"name", "run", "status", "cause"};
  return std::ranges::find(own, column) != std::end(own) || is_case_key(column) ||
         std::ranges::any_of(input_columns(), [&](const InputColumn& input) { return input.column == column; });
}

/// A cell of results.csv as results.json has it; numbers keep their digits.
Json value_of(const std::string& column, const std::string& cell) {
  if (column == "case_hash" || column == "version" || column == "commit") return cell;  // a hash may look like a number
  if (cell == "nan") return nullptr;
  Json number = Json::parse(cell, nullptr, false);
  return number.is_number() ? number : Json(cell);
}

}  // namespace

StoredResults::StoredResults(const std::vector<std::filesystem::path>& tables) {
  for (const std::filesystem::path& path : tables) {
    const Table table = Table::read(path);
    const std::vector<std::string> hashes = table.text("case_hash"), status = table.text("status");
    std::vector<Json> results(table.rows(), Json::object());
    for (const std::string& column : table.columns()) {
      if (describes_the_run(column)) continue;
      const std::vector<std::string> cells = table.text(column);
      for (std::size_t i = 0; i < cells.size(); ++i) {
        if (!cells[i].empty()) results[i][column] = value_of(column, cells[i]);
      }
    }
    for (std::size_t i = 0; i < table.rows(); ++i) {
      if (status[i] == "done") rows_.emplace(hashes[i], json_text(results[i], -1));
    }
  }
}

std::optional<std::string> StoredResults::of(const Case& c, const std::string& case_hash) const {
  const auto [first, last] = rows_.equal_range(case_hash);
  const auto whole = std::find_if(first, last, [&](const auto& row) { return is_whole_run(row.second, c); });
  return whole == last ? std::nullopt : std::optional(whole->second);
}

}  // namespace mpm
