#pragma once
/// Checks as text: numbers, the used fraction of the tolerance, and counts.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "validation/harness/case.hpp"

namespace mpm::validation {

/// Numbers as the table prints them: four significant digits, short exponents.
std::string format_value(double value);
/// Error or tolerance of a check with its unit: '0.3 %' or '1.2e-4 m'.
std::string format_error(const Check& check, double error);

/// Bound of a target that is known not to be met: 'at most 1.2', 'at least 1.5'; empty for other checks.
std::string format_miss_bound(const Check& check);

/// An observed order with two decimals; empty without one.
std::string format_order(const std::optional<double>& order);

/// The fraction of its tolerance that a check uses: |error| / tolerance, and value / bound for a bound without slack. At most 1 for a check
/// that holds, above for one that does not; infinite if the tolerance is zero and the error is not, or if a number is NaN.
double tolerance_used(const Check& check);
/// The check that uses most of its tolerance; null if the case has none.
const Check* tightest_check(const CaseResult& result);

/// '35 %', '4.1 %', '< 0.1 %', '250 x', 'inf'; empty for NaN.
std::string format_used(double used);

/// 'ok', 'ok, 3 not met', 'FAILED'
std::string format_verdict(const CaseResult& result);

/// 'relative', 'absolute', 'at_most'
const char* measure_name(Measure m);

/// Checks by verdict; a case that threw counts as one that failed.
struct Count {
  std::size_t passed = 0, failed = 0, not_met = 0;
  [[nodiscard]] std::size_t all() const { return passed + failed + not_met; }
};
Count count_checks(const CaseResult& r);
Count count_checks(const std::vector<CaseResult>& results);

/// 'verification, validation': the labels of the case's checks.
std::string labels_of(const CaseResult& r);

/// The cases that fail, then the others, each in the given order.
std::vector<const CaseResult*> failing_first(const std::vector<CaseResult>& results);

}  // namespace mpm::validation
