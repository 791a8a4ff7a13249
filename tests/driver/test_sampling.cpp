#include "libmpm/driver/sampling.hpp"

#include <gtest/gtest.h>

#include "libmpm/driver/estimate.hpp"
#include "support/case_texts.hpp"

namespace mpm {
namespace {

/// 1 s of a small case.
Case sampled(double series_per_second, double frames_per_second) {
  Case c = parse_case(testing::hand_case, "case.toml");
  c.output = {.duration = 1.0, .series_per_second = series_per_second, .frames_per_second = frames_per_second};
  return c;
}

TEST(Samples, AreMultiplesOfTheirIntervalUpToTheFirstThatIsNotBeforeTheEnd) {
  const Sampling whole(sampled(50.0, 5.0)), beyond(sampled(1.5, 0.0));
  EXPECT_EQ(whole.last(), 50U);
  EXPECT_EQ(whole.end(), 1.0);
  EXPECT_EQ(whole.time(7), 7.0 / 50.0);
  EXPECT_EQ(beyond.last(), 2U);
  EXPECT_EQ(beyond.end(), 2.0 / 1.5);
}

TEST(SampledFrames, AreTheNearestWholeNumberOfSamplesApart) {
  for (const auto& [per_second, apart] : {std::pair{5.0, 10U}, {50.0, 1U}, {30.0, 2U}, {4.7, 11U}, {1e4, 1U}}) {
    const Sampling sampling(sampled(50.0, per_second));
    for (std::uint64_t k = 0; k <= sampling.last(); ++k) EXPECT_EQ(sampling.has_frame(k), k % apart == 0) << per_second << ' ' << k;
  }
}

TEST(SampledFrames, AreCountedAndEstimatedAsTheyAreStored) {
  for (const double per_second : {0.0, 0.3, 5.0, 7.0, 50.0}) {
    const Case c = sampled(50.0, per_second);
    const Sampling sampling(c);
    std::uint64_t count = 0;
    for (std::uint64_t k = 0; k <= sampling.last(); ++k) {
      EXPECT_EQ(sampling.frames(k), count) << per_second << ' ' << k;
      count += sampling.has_frame(k);
    }
    EXPECT_EQ(estimate(c).frames, static_cast<double>(count)) << per_second;
  }
}

}  // namespace
}  // namespace mpm
