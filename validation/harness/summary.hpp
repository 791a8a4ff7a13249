#pragma once
/// Predicted against reference values of all cases, by kind of quantity: bias and spread of the model beside the uncertainty of the
/// references.
///
/// The statistics are those of McGrattan & Toman (2011, Metrologia 48, 173), which the validation guide of FDS uses. The ratio of
/// predicted to reference value is log-normal; model and references err independently. With x = ln(predicted/reference),
///   s_M^2 + s_R^2 = 1/(n - 1) sum (x - mean x)^2,   bias = exp(mean x + s_M^2/2 - s_R^2/2),
/// where s_R is the relative standard deviation of the references and s_M that of the model. Values of one case are not independent of each
/// other, and cases were not drawn at random: the numbers describe this suite, they are no probability. The guide also takes s_R for at
/// most s_M; here references may be worse than the model, and s_M is then 0.

#include <cstddef>
#include <string>
#include <vector>

#include "validation/harness/case.hpp"

namespace mpm::validation {

/// One point, and where it comes from.
struct SummaryPoint {
  std::string case_name, name;  ///< folder of the case; quantity of the check
  Label label;
  Comparison comparison;
};

/// The points of one quantity that have references of one kind: exact solutions (verification), or experiments and the paper (validation).
struct SummaryRow {
  Quantity quantity;
  Label label;
  std::size_t values = 0, cases = 0;   ///< with a ratio; cases that they come from
  std::size_t without_ratio = 0;       ///< predicted values that are not positive or not finite: they have no logarithm
  double reference_uncertainty = 0.0;  ///< s_R, root mean square of the references
  double bias = 0.0;                   ///< above 1: the model predicts too much
  double spread = 0.0;                 ///< sqrt(s_M^2 + s_R^2); NaN for fewer than two values
  double model_spread = 0.0;           ///< s_M; 0 where the spread is below the uncertainty of the references; NaN as `spread`
  double farthest = 1.0;               ///< the ratio farthest from 1
  std::string farthest_name;           ///< case and quantity of that one
};

/// All points: cases and checks in their order. Regression checks, against earlier results of this program, have none.
std::vector<SummaryPoint> summary_points(const std::vector<CaseResult>& results);

/// A row for each quantity and label that has points; quantities in the order of the enumeration, verification before validation.
std::vector<SummaryRow> summary_rows(const std::vector<SummaryPoint>& points);

/// The rows as lines of text, for standard output; empty without rows.
std::string summary_table(const std::vector<SummaryRow>& rows);

}  // namespace mpm::validation
