#include "validation/harness/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "validation/harness/check_text.hpp"

namespace mpm::validation {
namespace {

/// Lines of columns that are as wide as their widest entry of a row that counts; a rule below the first.
std::string aligned(const std::vector<std::vector<std::string>>& rows, const std::vector<bool>& counts) {
  std::vector<std::size_t> width(rows.front().size(), 0);
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (std::size_t i = 0; i < rows[k].size(); ++i)
      if (counts[k]) width[i] = std::max(width[i], rows[k][i].size());
  std::string text;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::string line;
    for (std::size_t i = 0; i < rows[k].size(); ++i) line += fmt::format("{}{:<{}}", i == 0 ? "" : " | ", rows[k][i], width[i]);
    while (!line.empty() && line.back() == ' ') line.pop_back();
    text += line + '\n';
    if (k == 0) text += std::string(line.size(), '-') + '\n';
  }
  return text;
}

}  // namespace

std::string check_table(const std::vector<CaseResult>& results) {
  std::vector<std::vector<std::string>> rows{
      {"case", "label", "quantity", "reference", "result", "error", "order", "tolerance", "verdict", "time"}};
  std::vector<bool> counts{true};
  for (const CaseResult* r : failing_first(results)) {
    const std::string time = fmt::format("{:.1f} s", r->wall_time_s);
    if (!r->fault.empty()) {
      rows.push_back({r->name, "", r->fault, "", "", "", "", "", "FAILED", time});
      counts.push_back(false);  // a long message widens nothing
    }
    for (const bool failed : {true, false})
      for (const Check& c : r->checks) {
        if (c.passed == failed) continue;
        rows.push_back({r->name, to_string(c.label), c.quantity, format_value(c.reference) + (c.unit.empty() ? "" : " " + c.unit),
                        format_value(c.value), format_error(c, c.error), format_order(c.observed_order), format_error(c, c.tolerance),
                        to_string(c.verdict()) + (c.passed || !c.miss ? "" : ", known: " + format_miss_bound(c)), time});
        counts.push_back(true);
      }
  }
  return aligned(rows, counts);
}

std::string case_table(const std::vector<CaseResult>& results, const RunInfo& info) {
  std::vector<std::vector<std::string>> rows{
      {"case", "label", "checks", "closest to its tolerance", "error", "tolerance", "used", "verdict", "time", "share"}};
  double total = 0.0;
  for (const CaseResult& r : results) total += r.wall_time_s;
  std::string failing;
  for (const CaseResult* r : failing_first(results)) {
    const Count c = count_checks(*r);
    const Check* k = tightest_check(*r);
    const bool crashed = !r->fault.empty();
    rows.push_back({r->name, labels_of(*r), fmt::format("{}/{}", c.passed, c.all()),
                    crashed        ? "(see its message)"
                    : k != nullptr ? k->quantity
                                   : "",
                    crashed || k == nullptr ? "" : format_error(*k, k->error),
                    crashed || k == nullptr ? "" : format_error(*k, k->tolerance),
                    crashed || k == nullptr ? "" : format_used(tolerance_used(*k)), format_verdict(*r),
                    fmt::format("{:.1f} s", r->wall_time_s), fmt::format("{:.0f} %", total > 0.0 ? 100.0 * r->wall_time_s / total : 0.0)});
    if (!r->passed()) failing += (failing.empty() ? "" : ", ") + r->name;
  }
  std::string text = aligned(rows, std::vector<bool>(rows.size(), true));
  const std::optional<double> budget = time_budget(info.level);
  text += budget ? fmt::format("time: {:.0f} s with {} threads; level {} may take {:.0f} s on two idle cores\n", info.wall_time_s,
                               info.threads, to_string(info.level), *budget)
                 : fmt::format("time: {:.0f} s with {} threads\n", info.wall_time_s, info.threads);
  if (!failing.empty()) text += fmt::format("failing cases: {}\n", failing);
  const Count c = count_checks(results);
  return text +
         fmt::format("{} passed, {} failed{}\n", c.passed, c.failed, c.not_met > 0 ? fmt::format(", {} not met as known", c.not_met) : "");
}

}  // namespace mpm::validation
