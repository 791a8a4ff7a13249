#include "validation/harness/case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <sstream>
#include <stdexcept>

#include "libmpm/base/process.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "validation/harness/norms.hpp"

namespace mpm::validation {
namespace {

std::vector<CaseEntry>& cases() {
  static std::vector<CaseEntry> all;
  return all;
}

bool finite(const Check& c) {
  return std::isfinite(c.value) && std::isfinite(c.reference) && std::isfinite(c.error) && std::isfinite(c.tolerance) &&
         (!c.observed_order || std::isfinite(*c.observed_order));
}

Check& add(CaseResult& result, Check check) {
  switch (check.measure) {
    case Measure::relative: check.error = relative_error(check.value, check.reference); break;
    case Measure::absolute: check.error = std::abs(check.value - check.reference); break;
    case Measure::at_most: check.error = check.value - check.reference; break;
  }
  check.passed = finite(check) && check.error <= check.tolerance;
  return result.checks.emplace_back(std::move(check));
}

}  // namespace

std::string to_string(Label label) {
  switch (label) {
    case Label::verification: return "verification";
    case Label::validation: return "validation";
    case Label::regression: return "regression";
  }
  return "unknown";
}

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::ok: return "ok";
    case Verdict::not_met: return "not met";
    case Verdict::failed: return "FAILED";
  }
  return "unknown";
}

std::string to_string(Level level) {
  switch (level) {
    case Level::quick: return "quick";
    case Level::standard: return "standard";
    case Level::full: return "full";
  }
  return "unknown";
}

Series slope_line(std::string name, const std::vector<double>& size, double at_finest, double order) {
  return {std::move(name),
          {size.front(), size.back()},
          {at_finest * std::pow(size.front() / size.back(), order), at_finest},
          Series::Style::bound};
}

Series reference_curve(std::string name, double from, double to, int parts, const std::function<double(double)>& y) {
  Series curve{std::move(name), {}, {}, Series::Style::reference};
  for (int i = 0; i <= parts; ++i) {
    curve.x.push_back(from + (to - from) * i / parts);
    curve.y.push_back(y(curve.x.back()));
  }
  return curve;
}

Verdict Check::verdict() const {
  if (passed) return Verdict::ok;
  if (!miss || !finite(*this)) return Verdict::failed;
  const bool as_known = miss->bound > reference ? value > reference && value <= miss->bound : value < reference && value >= miss->bound;
  return as_known ? Verdict::not_met : Verdict::failed;
}

Check& Check::known_miss(double bound, std::string cause) {
  if (!std::isfinite(bound) || bound == reference)
    throw std::invalid_argument(fmt::format("known miss of '{}': its bound is {}; it must be a number above or below the reference {}",
                                            quantity, bound, reference));
  miss = KnownMiss{bound, std::move(cause)};
  return *this;
}

namespace {

/// The summary compares with references; what an earlier version of this program gave is none.
void require_reference(const Check& check) {
  if (check.label == Label::regression)
    throw std::logic_error(fmt::format("'{}': a regression check cannot be in the summary", check.quantity));
}

}  // namespace

Check& Check::in_summary(Quantity kind, double reference_uncertainty) {
  require_reference(*this);
  comparison = make_comparison(kind, value, reference, unit, reference_uncertainty);
  return *this;
}

Check& Check::in_summary(Quantity kind, double reference_uncertainty, double unit_value) {
  require_reference(*this);
  comparison = make_comparison(kind, unit_value * value, unit_value * reference, text_of(kind).unit, reference_uncertainty);
  return *this;
}

bool CaseResult::passed() const {
  return fault.empty() && !checks.empty() &&
         std::all_of(checks.begin(), checks.end(), [](const Check& c) { return c.verdict() != Verdict::failed; });
}

Check& CaseResult::check_relative(Label label, std::string quantity, double value, double reference, std::string unit, double tolerance,
                                  std::string reason) {
  return add(
      *this,
      {std::move(quantity), value, reference, std::move(unit), Measure::relative, 0.0, tolerance, std::move(reason), {}, false, label});
}

Check& CaseResult::check_absolute(Label label, std::string quantity, double value, double reference, std::string unit, double tolerance,
                                  std::string reason) {
  return add(
      *this,
      {std::move(quantity), value, reference, std::move(unit), Measure::absolute, 0.0, tolerance, std::move(reason), {}, false, label});
}

Check& CaseResult::check_at_most(Label label, std::string quantity, double value, double bound, std::string unit, double slack,
                                 std::string reason) {
  return add(*this,
             {std::move(quantity), value, bound, std::move(unit), Measure::at_most, 0.0, slack, std::move(reason), {}, false, label});
}

Check& CaseResult::check_order(Label label, std::string quantity, double order, double low, double high, std::string reason) {
  return add(*this, {std::move(quantity), order, 0.5 * (low + high), "", Measure::absolute, 0.0, 0.5 * (high - low), std::move(reason),
                     order, false, label});
}

void CaseResult::compare(Label label, std::string what, Quantity quantity, double predicted, double reference, const std::string& unit,
                         double reference_uncertainty) {
  if (label == Label::regression) throw std::logic_error(fmt::format("'{}': a regression cannot be in the summary", what));
  comparisons.push_back({label, std::move(what), make_comparison(quantity, predicted, reference, unit, reference_uncertainty)});
}

const std::vector<CaseEntry>& registered_cases() { return cases(); }

Registration::Registration(CaseEntry entry, const char* source) {
  entry.name = std::filesystem::path(source).parent_path().filename().string();
  entry.directory = std::filesystem::path(MPM_CASES_DIRECTORY) / entry.name;
  auto& all = cases();
  const auto rank = [](const CaseEntry& e) { return std::pair<bool, const std::string&>(!e.experiment, e.name); };
  all.insert(std::ranges::lower_bound(all, rank(entry), {}, rank), std::move(entry));
}

Case CaseContext::read_case(const std::string& file) const {
  Case c = mpm::read_case(case_directory_ / file);
  c.numerics.precision = precision_;
  return c;
}

CaseResult run_case_entry(const CaseEntry& entry, const CaseContext& context) {
  CaseResult result;
  result.name = entry.name;
  result.title = entry.title;
  const auto start = std::chrono::steady_clock::now();
  try {
    result.physics = first_paragraph(read_file(entry.directory / "README.md"));
    entry.run(context, result);
    if (context.source() != nullptr) {  // a miss is known of this program, not of the solver that is judged
      for (Check& check : result.checks) check.miss.reset();
    }
    if (result.checks.empty()) result.fault = "the case asserted nothing";
  } catch (const std::exception& e) {
    result.fault = e.what();
  }
  result.wall_time_s = seconds_since(start);
  return result;
}

std::string first_paragraph(const std::string& markdown) {
  std::istringstream lines(markdown);
  std::string line, text;
  while (std::getline(lines, line)) {
    const bool blank = line.find_first_not_of(" \t\r") == std::string::npos;
    if (text.empty() && (blank || line.front() == '#')) continue;
    if (blank) break;
    text += (text.empty() ? "" : " ") + line;
  }
  return text;
}

}  // namespace mpm::validation
