#include "validation/harness/history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/check_text.hpp"
#include "validation/harness/summary.hpp"

namespace mpm::validation {
namespace {

const std::vector<std::string> history_columns{"date", "commit", "version",  "machine", "threads", "level",
                                               "case", "kind",   "quantity", "value",   "error",   "verdict"};

std::string digits(double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : fmt::format("{}", value); }

/// Every registered case has a result.
bool complete(const std::vector<CaseResult>& results) {
  return std::ranges::all_of(registered_cases(), [&](const CaseEntry& entry) {
    return std::ranges::any_of(results, [&](const CaseResult& r) { return r.name == entry.name; });
  });
}

}  // namespace

void append_history(const std::filesystem::path& directory, const std::vector<CaseResult>& results, const RunInfo& info) {
  const std::filesystem::path file = directory / "history.csv";
  std::string text = csv_line(history_columns);
  if (std::filesystem::exists(file)) {
    const std::string before = read_file(file);
    if (!before.starts_with(text)) throw IoError(fmt::format("cannot add to '{}': it has other columns; remove the file", file.string()));
    text = before;
  }
  const BuildInfo build = build_info();
  const auto add = [&](const std::string& name, const char* kind, const std::string& quantity, double value, const std::string& error,
                       const std::string& verdict) {
    text += csv_line(std::vector<std::string>{info.started, std::string(build.commit), std::string(build.version), info.machine,
                                              std::to_string(info.threads), to_string(info.level), name, kind, quantity, digits(value),
                                              error, verdict});
  };
  for (const CaseResult& r : results) {
    add(r.name, "time", "wall time", r.wall_time_s, "", r.passed() ? "ok" : "FAILED");
    for (const Check& c : r.checks) {
      add(r.name, "check", c.quantity, tolerance_used(c), digits(c.error), to_string(c.verdict()));
      if (c.observed_order) add(r.name, "order", c.quantity, *c.observed_order, "", "");
    }
  }
  if (complete(results)) {
    for (const SummaryRow& row : summary_rows(summary_points(results))) {
      const std::string quantity = text_of(row.quantity).name + ", " + to_string(row.label);
      add("", "bias", quantity, row.bias, "", "");
      if (!std::isnan(row.spread)) add("", "spread", quantity, row.spread, "", "");
    }
  }
  write_file(file, text);
}

}  // namespace mpm::validation
