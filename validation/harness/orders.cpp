#include "validation/harness/orders.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>
#include <regex>
#include <sstream>

#include "libmpm/driver/build_info.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/check_text.hpp"
#include "validation/harness/history.hpp"

namespace mpm::validation {
namespace {

/// Six digits: what a reader compares; the last ones may depend on the compiler.
std::string short_number(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : fmt::format("{}", value); }

const std::vector<std::string> orders_columns{"case",      "quantity", "label",   "reference", "result", "error", "order",
                                              "tolerance", "verdict",  "measure", "unit",      "bound",  "cause"};
const std::vector<std::string> runs_columns{"level",   "case",    "labels", "checks_passed", "checks_failed", "wall_time_s",
                                            "threads", "version", "commit", "date",          "machine"};

/// The cells with another before them.
std::vector<std::string> with_first(const std::string& first, std::vector<std::string> cells) {
  cells.insert(cells.begin(), first);
  return cells;
}

constexpr const char* source_text = R"(# Orders and errors of the validation suite

Written by `mpm-validate run --record`; nothing in this directory is edited by hand.

- `data.csv`: a row a check. `level`, `case`, `quantity`, `label` (verification: exact solution or property;
  validation: experiment or the paper; regression: our own past), `reference`, `result`, `error`, `order` (observed;
  empty where there is none), `tolerance`, `verdict`, `measure` (relative: error and tolerance are fractions of the
  reference; absolute: in `unit`; at_most: `error` is how far the result lies above the reference, in `unit`),
  `unit` of reference and result; of a target that is known not to be met the `bound` within which it must stay, and the
  `cause`.
- `history.csv`: the results of all recordings in their order: `kind` check (`value`: used fraction of the tolerance),
  order, time (s), and for recordings of all cases bias and spread of a quantity. `scripts/validation_history.py`
  draws it.
- `runs.csv`: which program and machine made the rows of a case, and how long it took. Times belong to that machine.

Where each reference comes from, and the reason for each tolerance: validation/cases/<case>/README.md.

)";

constexpr const char* recording_text =
    "Last recording: level {level}, `{command}`, version {version}, commit {commit}, {compiler}, {build_type}, "
    "{instruction_set}, {machine}, {threads} threads, {started}.";

/// A paragraph in lines of at most `width` characters.
std::string wrapped(const std::string& text, std::size_t width) {
  std::string lines;
  std::size_t length = 0;
  std::istringstream words(text);
  for (std::string word; words >> word; length += word.size()) {
    const bool fits = length + 1 + word.size() <= width;
    if (!lines.empty()) lines += fits ? ' ' : '\n';
    length = fits ? length + 1 : 0;
    lines += word;
  }
  return lines + '\n';
}

/// Rows of the table of orders and errors by case; each row has the cells of `orders_columns`.
std::map<std::string, std::vector<std::vector<std::string>>> order_rows(const std::vector<CaseResult>& results) {
  std::map<std::string, std::vector<std::vector<std::string>>> rows;
  for (const CaseResult& r : results) {
    if (!r.fault.empty()) rows[r.name].push_back({r.name, r.fault, "", "", "", "", "", "", "FAILED", "", "", "", ""});
    for (const Check& c : r.checks)
      rows[r.name].push_back({r.name, c.quantity, to_string(c.label), short_number(c.reference), short_number(c.value),
                              short_number(c.error), c.observed_order ? short_number(*c.observed_order) : "", short_number(c.tolerance),
                              to_string(c.verdict()), measure_name(c.measure), c.unit, format_miss_bound(c), c.miss ? c.miss->cause : ""});
  }
  return rows;
}

/// Replaces the rows of a CSV file that begin with one of the keys 'level,case'; the rest stays, in the order of the keys.
void merge_csv(const std::filesystem::path& path, const std::vector<std::string>& columns,
               std::map<std::string, std::vector<std::string>> rows) {
  if (std::filesystem::exists(path)) {
    std::istringstream lines(read_file(path));
    std::string line;
    std::getline(lines, line);
    const std::string header = csv_line(columns);
    if (line + "\n" != header)
      throw IoError(
          fmt::format("cannot add to '{}': its columns are '{}', not '{}'; remove the file", path.string(), line, fmt::join(columns, ",")));
    std::map<std::string, std::vector<std::string>> kept;
    while (std::getline(lines, line)) {
      const std::string key = line.substr(0, line.find(',', line.find(',') + 1));
      if (!rows.contains(key)) kept[key].push_back(line + "\n");
    }
    rows.merge(kept);
  }
  std::string csv = csv_line(columns);
  for (const auto& [key, list] : rows)
    for (const std::string& row : list) csv += row;
  write_file(path, csv);
}

}  // namespace

std::string orders_csv(const std::vector<CaseResult>& results) {
  std::string csv = csv_line(orders_columns);
  for (const auto& [name, rows] : order_rows(results))
    for (const auto& row : rows) csv += csv_line(row);
  return csv;
}

void record_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, const RunInfo& info) {
  make_directory(directory);
  const std::string level = to_string(info.level);
  std::map<std::string, std::vector<std::string>> orders, runs;
  for (const auto& [name, rows] : order_rows(results))
    for (const auto& row : rows) orders[level + ',' + name].push_back(csv_line(with_first(level, row)));
  const BuildInfo build = build_info();
  for (const CaseResult& r : results) {
    const Count c = count_checks(r);
    const std::vector<std::string> cells{level,
                                         r.name,
                                         labels_of(r),
                                         std::to_string(c.passed),
                                         std::to_string(c.failed),
                                         fmt::format("{:.1f}", r.wall_time_s),
                                         std::to_string(info.threads),
                                         std::string(build.version),
                                         std::string(build.commit),
                                         info.started.substr(0, 10),
                                         info.machine};
    runs[level + ',' + r.name] = {csv_line(cells)};
    orders.try_emplace(level + ',' + r.name);  // a case without rows replaces those that it had
  }
  merge_csv(directory / "data.csv", with_first("level", orders_columns), orders);
  merge_csv(directory / "runs.csv", runs_columns, runs);
  const std::string command = std::regex_replace(info.command, std::regex(" --(out|junit)[ =][^ ]+"), "");  // folders of one machine
  const std::string recording =
      fmt::format(recording_text, fmt::arg("level", level), fmt::arg("command", command), fmt::arg("version", build.version),
                  fmt::arg("commit", build.commit), fmt::arg("compiler", build.compiler), fmt::arg("build_type", build.build_type),
                  fmt::arg("instruction_set", build.instruction_set), fmt::arg("machine", info.machine), fmt::arg("threads", info.threads),
                  fmt::arg("started", info.started));
  write_file(directory / "SOURCE.md", source_text + wrapped(recording, 116));
  append_history(directory, results, info);
}

std::vector<RecordedCase> recorded_cases(const std::filesystem::path& directory) {
  std::vector<RecordedCase> all;
  if (!std::filesystem::exists(directory / "runs.csv")) return all;
  const Table table = Table::read(directory / "runs.csv");
  const auto level = table.text("level"), name = table.text("case"), labels = table.text("labels");
  const auto time = table.numbers("wall_time_s");
  for (std::size_t i = 0; i < table.rows(); ++i) all.push_back({level[i], name[i], labels[i], time[i]});
  return all;
}

}  // namespace mpm::validation
