#include "validation/harness/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "validation/harness/check_text.hpp"

namespace mpm::validation {
namespace {

/// Statistics of the points of one quantity and label.
SummaryRow row_of(Quantity quantity, Label label, const std::vector<const SummaryPoint*>& points) {
  SummaryRow row{.quantity = quantity, .label = label};
  std::set<std::string> cases;
  std::vector<double> logarithms;
  double mean = 0.0, squares = 0.0;
  for (const SummaryPoint* p : points) {
    const double ratio = p->comparison.ratio();
    if (std::isnan(ratio)) {
      ++row.without_ratio;
      continue;
    }
    cases.insert(p->case_name);
    logarithms.push_back(std::log(ratio));
    mean += logarithms.back();
    squares += std::pow(p->comparison.reference_uncertainty, 2);
    if (row.farthest_name.empty() || std::abs(logarithms.back()) > std::abs(std::log(row.farthest))) {
      row.farthest = ratio;
      row.farthest_name = p->case_name + ": " + p->name;
    }
  }
  row.values = logarithms.size();
  row.cases = cases.size();
  const auto n = static_cast<double>(logarithms.size());
  mean /= n;  // NaN without values
  row.reference_uncertainty = std::sqrt(squares / n);
  double deviations = 0.0;
  for (const double x : logarithms) deviations += (x - mean) * (x - mean);
  row.spread = logarithms.size() < 2 ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(deviations / (n - 1.0));
  const double reference = std::pow(row.reference_uncertainty, 2);
  row.model_spread = std::sqrt(std::isnan(row.spread) ? row.spread : std::max(row.spread * row.spread - reference, 0.0));
  row.bias = std::isnan(row.spread) ? std::exp(mean) : std::exp(mean + 0.5 * row.model_spread * row.model_spread - 0.5 * reference);
  return row;
}

std::string percent(double share) { return std::isnan(share) ? "" : share == 0.0 ? "0" : fmt::format("{:.2g} %", 100.0 * share); }

}  // namespace

std::vector<SummaryPoint> summary_points(const std::vector<CaseResult>& results) {
  std::vector<SummaryPoint> points;
  for (const CaseResult& r : results) {
    for (const Check& c : r.checks)
      if (c.comparison) points.push_back({r.name, c.quantity, c.label, *c.comparison});
    for (const NamedComparison& c : r.comparisons) points.push_back({r.name, c.name, c.label, c.comparison});
  }
  return points;
}

std::vector<SummaryRow> summary_rows(const std::vector<SummaryPoint>& points) {
  std::map<std::pair<Quantity, Label>, std::vector<const SummaryPoint*>> groups;
  for (const SummaryPoint& p : points) groups[{p.comparison.quantity, p.label}].push_back(&p);
  std::vector<SummaryRow> rows;
  for (const auto& [key, group] : groups) rows.push_back(row_of(key.first, key.second, group));
  return rows;
}

std::string summary_table(const std::vector<SummaryRow>& rows) {
  if (rows.empty()) return "";
  std::string text = fmt::format("{:<16} {:<13} {:>6} {:>6} {:>12} {:>7} {:>12} {:>12}\n", "predicted", "compared by", "values", "cases",
                                 "references ±", "bias", "model ±", "farthest");
  for (const SummaryRow& r : rows) {
    text +=
        fmt::format("{:<16} {:<13} {:>6} {:>6} {:>12} {:>7} {:>12} {:>12}\n", text_of(r.quantity).name, to_string(r.label), r.values,
                    r.cases, percent(r.reference_uncertainty), fmt::format("{:.3f}", r.bias),
                    r.model_spread == 0.0 && r.spread > 0.0 ? "< references" : percent(r.model_spread), fmt::format("{:.3f}", r.farthest));
  }
  return text;
}

}  // namespace mpm::validation
