#include "validation/harness/summary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "libmpm/base/error.hpp"
#include "validation/harness/results_json.hpp"

namespace mpm::validation {
namespace {

CaseResult case_of(const std::string& name) {
  CaseResult r;
  r.name = name;
  return r;
}

TEST(Comparison, IsInTheUnitOfItsQuantity) {
  CaseResult r;
  const Check& c = r.check_relative(Label::verification, "stagnation", 66.0, 69.0, "kPa", 0.1, "because").in_summary(Quantity::pressure);
  ASSERT_TRUE(c.comparison);
  EXPECT_DOUBLE_EQ(c.comparison->predicted, 66e3);
  EXPECT_DOUBLE_EQ(c.comparison->reference, 69e3);
  EXPECT_EQ(c.comparison->reference_uncertainty, 0.0);
  EXPECT_DOUBLE_EQ(make_comparison(Quantity::displacement, 4.0, 5.0, "mm", 0.0).predicted, 4e-3);
}

TEST(Comparison, RefusesAUnitOfAnotherQuantity) {
  EXPECT_THROW(make_comparison(Quantity::force, 1.0, 1.0, "kN/m", 0.0), ConfigError);
  EXPECT_THROW(make_comparison(Quantity::force, 1.0, 1.0, "", 0.0), ConfigError);
  EXPECT_THROW(make_comparison(Quantity::speed, 1.0, 1.0, "c0", 0.0), ConfigError);
  EXPECT_THROW(make_comparison(Quantity::force, 1.0, 1.0, "N", -0.1), ConfigError);
}

TEST(Comparison, TakesTheValueOfAUnitOfTheFlow) {
  CaseResult r;
  const Check& c = r.check_relative(Label::verification, "front", 1.9, 2.0, "c0", 0.1, "because").in_summary(Quantity::speed, 0.0, 3.0);
  EXPECT_DOUBLE_EQ(c.comparison->predicted, 5.7);
  EXPECT_DOUBLE_EQ(c.comparison->reference, 6.0);
}

TEST(Summary, RefusesAComparisonWithThisProgramItself) {
  CaseResult r;
  EXPECT_THROW(r.check_relative(Label::regression, "z", 1.1, 1.0, "N", 1.0, "because").in_summary(Quantity::force), std::logic_error);
  EXPECT_THROW(r.check_relative(Label::regression, "z", 1.1, 1.0, "", 1.0, "because").in_summary(Quantity::force, 0.0, 2.0),
               std::logic_error);
  EXPECT_THROW(r.compare(Label::regression, "w", Quantity::force, 2.2, 2.0, "kN"), std::logic_error);
}

TEST(Summary, HasARowForEachQuantityAndKindOfReference) {
  CaseResult a = case_of("a"), b = case_of("b");
  a.check_relative(Label::verification, "x", 1.1, 1.0, "N", 1.0, "because").in_summary(Quantity::force);
  a.check_relative(Label::validation, "y", 1.1, 1.0, "N", 1.0, "because").in_summary(Quantity::force, 0.1);
  b.compare(Label::verification, "w", Quantity::force, 2.2, 2.0, "kN");
  const auto rows = summary_rows(summary_points({a, b}));
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].label, Label::verification);
  EXPECT_EQ(rows[0].values, 2u);
  EXPECT_EQ(rows[0].cases, 2u);
  EXPECT_NEAR(rows[0].bias, 1.1, 1e-12);
  EXPECT_NEAR(rows[0].farthest, 1.1, 1e-12);
  EXPECT_NEAR(rows[0].model_spread, 0.0, 1e-12);
  EXPECT_EQ(rows[1].values, 1u);
  EXPECT_TRUE(std::isnan(rows[1].model_spread));
}

TEST(Summary, TakesTheUncertaintyOfTheReferencesFromTheSpread) {
  // Ratios exp(+-s): the spread of two is s sqrt(2).
  const double s = 0.2, known = 0.12;
  CaseResult r = case_of("a");
  r.compare(Label::validation, "high", Quantity::run_up, std::exp(s), 1.0, "m", known);
  r.compare(Label::validation, "low", Quantity::run_up, std::exp(-s), 1.0, "m", known);
  const auto rows = summary_rows(summary_points({r}));
  ASSERT_EQ(rows.size(), 1u);
  const double model = std::sqrt(2.0 * s * s - known * known);
  EXPECT_NEAR(rows[0].spread, s * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(rows[0].model_spread, model, 1e-12);
  EXPECT_NEAR(rows[0].bias, std::exp(0.5 * model * model - 0.5 * known * known), 1e-12);
}

TEST(Summary, SaysWhereTheSpreadIsBelowThatOfTheReferences) {
  CaseResult r = case_of("a");
  for (const double predicted : {0.99, 1.01}) r.compare(Label::validation, "x", Quantity::run_up, predicted, 1.0, "m", 0.3);
  const auto rows = summary_rows(summary_points({r}));
  EXPECT_EQ(rows[0].model_spread, 0.0);
  EXPECT_GT(rows[0].spread, 0.0);
  EXPECT_NE(summary_table(rows).find("< references"), std::string::npos);
}

TEST(Summary, CountsValuesWithoutARatio) {
  CaseResult r = case_of("a");
  r.compare(Label::verification, "good", Quantity::force, 1.0, 1.0, "N");
  r.compare(Label::verification, "negative", Quantity::force, -1.0, 1.0, "N");
  r.compare(Label::verification, "not a number", Quantity::force, std::numeric_limits<double>::quiet_NaN(), 1.0, "N");
  const auto rows = summary_rows(summary_points({r}));
  EXPECT_EQ(rows[0].values, 1u);
  EXPECT_EQ(rows[0].without_ratio, 2u);
}

TEST(ResultsJson, HasTheSummary) {
  CaseResult r = case_of("a");
  r.check_relative(Label::verification, "x", 1.1, 1.0, "kN", 1.0, "because").in_summary(Quantity::force);
  const auto json = nlohmann::json::parse(results_json({r}, {}));
  EXPECT_EQ(json["summary"]["rows"][0]["quantity"], "force");
  EXPECT_TRUE(json["summary"]["rows"][0]["model_spread"].is_null());
  EXPECT_DOUBLE_EQ(json["summary"]["points"][0]["predicted"], 1100.0);
}

}  // namespace
}  // namespace mpm::validation
