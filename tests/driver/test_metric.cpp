#include "libmpm/driver/metric_convergence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/run.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

TEST(MetricOf, FindsNumbersComponentsAndStandardErrors) {
  const Results results = *Results::from_json(R"({"title": "t", "steady": true, "runup_mean_m": 3.5, "runup_standard_error_m": 0.25,
    "force_mean_n": [1.0, 2.0, 3.0], "force_standard_error_n": [0.1, 0.2, null], "pressure_height_mean_m": null, "steps": 7})");
  EXPECT_EQ(metric_of(results, "runup_mean_m").value, 3.5);
  EXPECT_EQ(metric_of(results, "runup_mean_m").standard_error, 0.25);
  EXPECT_EQ(metric_of(results, "force_mean_n[1]").value, 2.0);
  EXPECT_EQ(metric_of(results, "force_mean_n[1]").standard_error, 0.2);
  EXPECT_EQ(metric_of(results, "force_mean_n.y").value, 2.0);
  EXPECT_EQ(metric_of(results, "force_mean_n.y").standard_error, 0.2);
  EXPECT_TRUE(std::isnan(metric_of(results, "force_mean_n.z").standard_error));
  EXPECT_EQ(metric_of(results, "steps").value, 7.0);
  EXPECT_TRUE(std::isnan(metric_of(results, "pressure_height_mean_m").value));
  const auto message = [&](const char* name) {
    try {
      (void)metric_of(results, name);
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(message("runup_meen_m").find("did you mean runup_mean_m?"), std::string::npos);
  EXPECT_NE(message("force_mean_n").find("it is a vector: give force_mean_n.x"), std::string::npos);
  EXPECT_NE(message("force_mean_n[3]").find("no such number"), std::string::npos);
  EXPECT_NE(message("title").find("is not a number"), std::string::npos);
  EXPECT_NE(message("steady").find("is not a number"), std::string::npos);
}

TEST(KnownMetrics, AreTheNumbersThatARunReports) {
  Case c = testing::small_avalanche();
  c.output.duration = 0.02;
  const testing::TemporaryDirectory directory;
  RunOptions options;
  options.out = directory.path();
  options.threads = 1;
  const auto results = nlohmann::ordered_json::parse(run_case(c, options).results.to_json());
  std::vector<std::string> reported;
  for (const auto& [key, value] : results.items()) {
    if (value.is_string() || value.is_boolean()) continue;
    if (!value.is_array()) reported.push_back(key);
    for (std::size_t i = 0; value.is_array() && i < value.size(); ++i) reported.push_back(key + "." + "xyz"[i]);
  }
  std::vector<std::string> known = known_metrics(c);
  std::ranges::sort(reported);
  std::ranges::sort(known);
  EXPECT_EQ(known, reported);
}

TEST(KnownMetrics, OfAnImpactAreNotThoseOfABlock) {
  const Case impact = testing::small_avalanche();
  Case block = impact;
  block.conveyor.reset();
  block.obstacle.reset();
  EXPECT_NO_THROW(require_known_metrics(impact, {"steps", "runup_mean_m", "force_mean_n.x", "force_mean_n[2]"}));
  EXPECT_NO_THROW(require_known_metrics(block, {"steps"}));
  EXPECT_THROW(require_known_metrics(block, {"steps", "runup_mean_m"}), ConfigError);
  EXPECT_THROW(require_known_metrics(impact, {"runup_meen_m"}), ConfigError);
}

}  // namespace
}  // namespace mpm
