#include "validation/harness/check_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace mpm::validation {

std::string format_value(double value) {
  if (value == 0.0) return "0";
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : fmt::format("{}", value);
}

std::string format_error(const Check& check, double error) {
  const auto digits = [](double v) { return v == 0.0 ? std::string("0") : fmt::format("{:.2g}", v); };
  if (check.measure == Measure::relative) {
    if (!std::isfinite(error)) return fmt::format("{}", error);
    return std::abs(error) >= 1e-5 && std::abs(error) < 1e3 ? fmt::format("{:.3g} %", 100.0 * error) : digits(error);
  }
  return check.unit.empty() ? digits(error) : fmt::format("{} {}", digits(error), check.unit);
}

std::string format_miss_bound(const Check& check) {
  if (!check.miss) return "";
  return fmt::format("{} {}", check.miss->bound > check.reference ? "at most" : "at least", format_value(check.miss->bound));
}

std::string format_order(const std::optional<double>& order) {
  if (!order) return "";
  const std::string text = fmt::format("{:.2f}", *order);
  return text == "-0.00" ? "0.00" : text;
}

double tolerance_used(const Check& c) {
  if (!std::isfinite(c.value) || !std::isfinite(c.error) || !std::isfinite(c.tolerance)) return std::numeric_limits<double>::infinity();
  const bool bound_without_slack = c.measure == Measure::at_most && c.tolerance == 0.0 && c.reference > 0.0;
  const double used = bound_without_slack ? c.value : c.measure == Measure::at_most ? std::max(c.error, 0.0) : c.error;
  const double permitted = bound_without_slack ? c.reference : c.tolerance;
  if (used <= 0.0) return 0.0;
  return permitted > 0.0 ? used / permitted : std::numeric_limits<double>::infinity();
}

const Check* tightest_check(const CaseResult& result) {
  const auto tightest = std::max_element(result.checks.begin(), result.checks.end(), [](const Check& a, const Check& b) {
    return a.verdict() != b.verdict() ? a.verdict() < b.verdict() : tolerance_used(a) < tolerance_used(b);  // one that fails before others
  });
  return tightest == result.checks.end() ? nullptr : &*tightest;
}

std::string format_used(double used) {
  if (std::isnan(used)) return "";
  if (used > 0.0 && used < 1e-3) return "< 0.1 %";
  if (used < 0.1) return fmt::format("{:.2g} %", 100.0 * used);
  return used < 10.0 ? fmt::format("{:.0f} %", 100.0 * used) : fmt::format("{:.3g} x", used);
}

const char* measure_name(Measure m) {
  switch (m) {
    case Measure::relative: return "relative";
    case Measure::absolute: return "absolute";
    case Measure::at_most: return "at_most";
  }
  return "relative";
}

Count count_checks(const CaseResult& r) {
  Count c;
  for (const Check& k : r.checks) {
    const Verdict verdict = k.verdict();
    ++(verdict == Verdict::ok ? c.passed : verdict == Verdict::not_met ? c.not_met : c.failed);
  }
  if (!r.fault.empty()) ++c.failed;
  return c;
}
Count count_checks(const std::vector<CaseResult>& results) {
  Count total;
  for (const CaseResult& r : results) {
    const Count c = count_checks(r);
    total.passed += c.passed;
    total.failed += c.failed;
    total.not_met += c.not_met;
  }
  return total;
}

std::string format_verdict(const CaseResult& r) {
  const std::size_t not_met = count_checks(r).not_met;
  return !r.passed() ? "FAILED" : not_met > 0 ? fmt::format("ok, {} not met", not_met) : "ok";
}

std::string labels_of(const CaseResult& r) {
  std::string text;
  for (const Label label : {Label::verification, Label::validation, Label::regression})
    if (std::any_of(r.checks.begin(), r.checks.end(), [label](const Check& c) { return c.label == label; }))
      text += (text.empty() ? "" : ", ") + to_string(label);
  return text;
}

std::vector<const CaseResult*> failing_first(const std::vector<CaseResult>& results) {
  std::vector<const CaseResult*> order;
  for (const CaseResult& r : results) order.push_back(&r);
  std::stable_partition(order.begin(), order.end(), [](const CaseResult* r) { return !r->passed(); });
  return order;
}

}  // namespace mpm::validation
