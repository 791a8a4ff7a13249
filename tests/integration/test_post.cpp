/// `mpm post` against the run that it measures again.
#include "libmpm/driver/replay.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/run.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/snapshot.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using testing::TemporaryDirectory;

/// A short, narrow, coarse avalanche: ten frames, every one at the time of a row of series.csv.
constexpr const char* small_avalanche = R"(
title = "small"
[material]
model = "cohesive_cam_clay"
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 5.0
[conveyor]
froude_number = 1.0
flow_height_m = 1.75
width_m = 3.5
upstream_length_m = 2.0
downstream_length_m = 2.0
[obstacle]
width_m = 1.75
depth_m = 1.75
[numerics]
cell_size_m = 0.4375
[output]
duration_s = 0.4
series_per_second = 50
frames_per_second = 25
)";

class PostOfARun : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    directory_ = new TemporaryDirectory;
    RunOptions options;
    options.out = run();
    run_case(parse_case(small_avalanche, "small.toml"), options);
  }
  static void TearDownTestSuite() {
    delete directory_;
    directory_ = nullptr;
  }
  static std::filesystem::path run() { return *directory_ / "run"; }

  static TemporaryDirectory* directory_;
};
TemporaryDirectory* PostOfARun::directory_ = nullptr;

TEST_F(PostOfARun, MeasuresWhatTheRunMeasuredAtTheTimesOfTheFrames) {
  const std::filesystem::path out = *directory_ / "again";
  const PostResult result = post_process(run(), out);
  EXPECT_EQ(result.frames, 11u);
  const Table own = Table::read(run() / "series.csv"), again = Table::read(out / "series.csv");
  EXPECT_EQ(again.columns(), own.columns());
  ASSERT_EQ(again.rows(), 11u);
  for (const char* name :
       {"time_s", "runup_m", "runup_p99_m", "pressure_height_m", "impact_pressure_pa", "compaction", "mass_kg", "momentum_x_kg_m_s"}) {
    const std::vector<double> a = own.numbers(name), b = again.numbers(name);
    for (std::size_t frame = 0; frame < b.size(); ++frame) {
      const double expected = a[2 * frame];
      if (std::isnan(expected)) {
        EXPECT_TRUE(std::isnan(b[frame])) << name << " " << frame;
      } else {
        // The same numbers are summed in another order: round-off of some thousand terms.
        EXPECT_NEAR(b[frame], expected, 1e-11 * std::abs(expected)) << name << " " << frame;
      }
    }
  }
  // A frame comes every second row: its force is the mean of two rows, the impulse since the frame before.
  const std::vector<double> a = own.numbers("force_x_n"), b = again.numbers("force_x_n");
  EXPECT_TRUE(std::isnan(b[0]));
  for (std::size_t frame = 1; frame < b.size(); ++frame) {
    EXPECT_NEAR(b[frame], 0.5 * (a[2 * frame - 1] + a[2 * frame]), 1e-14 * (std::abs(a[2 * frame - 1]) + std::abs(a[2 * frame]))) << frame;
  }
}

TEST_F(PostOfARun, ProfilesOverTimeAreThoseOfTheRun) {
  const std::filesystem::path out = *directory_ / "profiles";
  post_process(run(), out);
  const hdf5::Reader own(run() / "profiles.h5"), again(out / "profiles.h5");
  const auto z = own.dataset<double>("z_m", {hdf5::any_extent});
  const auto a = own.dataset<double>("pressure_pa", {21, z.size()}), b = again.dataset<double>("pressure_pa", {11, z.size()});
  EXPECT_EQ(again.dataset<double>("z_m", {z.size()}), z);
  EXPECT_EQ(own.dataset<double>("time_s", {21})[20], 0.4);
  double largest = 0.0;
  for (const double p : a) largest = std::max(largest, std::abs(p));
  EXPECT_GT(largest, 0.0);
  for (std::size_t frame = 0; frame < 11; ++frame) {
    for (std::size_t bin = 0; bin < z.size(); ++bin)
      EXPECT_NEAR(b[frame * z.size() + bin], a[2 * frame * z.size() + bin], 1e-11 * largest) << frame << ' ' << bin;
  }
  EXPECT_EQ(std::ranges::count(own.datasets(), "force_x_per_height_n_m"), 1);
  EXPECT_EQ(std::ranges::count(again.datasets(), "force_x_per_height_n_m"), 0) << "no frame holds it";
}

TEST_F(PostOfARun, LeavesTheRunsOwnFilesAloneAndKeepsItsFacts) {
  std::string before;
  for (const char* name : {"results.json", "series.csv", "profile.csv"}) before += read_file(run() / name);
  const PostResult result = post_process(run(), run() / "post");
  std::string after;
  for (const char* name : {"results.json", "series.csv", "profile.csv"}) after += read_file(run() / name);
  EXPECT_EQ(after, before);
  EXPECT_EQ(result.written.size(), 5u) << "series.csv, profile.csv, profiles.h5, results.json, obstacle.json";
  const auto own = nlohmann::json::parse(read_file(run() / "results.json")),
             again = nlohmann::json::parse(read_file(run() / "post/results.json"));
  for (const char* key : {"case_hash", "steps", "wall_time_s", "particles_final"}) EXPECT_EQ(again[key], own[key]) << key;
  EXPECT_EQ(again["measured_from"], "frames");
  EXPECT_EQ(again["frames"], 11);
}

TEST_F(PostOfARun, WritesIntoNoFolderOfARun) {
  const std::filesystem::path other = *directory_ / "of_another_run";
  std::filesystem::copy(run(), other, std::filesystem::copy_options::recursive);
  const std::string before = read_file(other / "results.json") + read_file(other / "series.csv");
  EXPECT_THROW(post_process(run(), run()), ConfigError);
  EXPECT_THROW(post_process(run(), other), ConfigError);
  EXPECT_EQ(read_file(other / "results.json") + read_file(other / "series.csv"), before);
}

TEST_F(PostOfARun, MeasuresARunThatWasKilledAndDoesNotMakeItCountAsFinished) {
  const std::filesystem::path killed = *directory_ / "killed";
  std::filesystem::copy(run(), killed, std::filesystem::copy_options::recursive);
  std::filesystem::remove(killed / "results.json");
  std::filesystem::remove(killed / "profile.csv");
  std::filesystem::remove(killed / "frames.xdmf");
  std::filesystem::remove(frame_path(killed, 10));
  const std::string series = read_file(killed / "series.csv");
  post_process(killed, killed / "post");
  EXPECT_FALSE(std::filesystem::exists(killed / "results.json"));
  EXPECT_FALSE(std::filesystem::exists(killed / "profile.csv"));
  EXPECT_EQ(read_file(killed / "series.csv"), series);
  EXPECT_TRUE(std::filesystem::exists(killed / "post/profile.csv"));
  const auto json = nlohmann::json::parse(read_file(killed / "post/results.json"));
  EXPECT_EQ(json["title"], "small");
  EXPECT_EQ(json["frames"], 10);
  EXPECT_EQ(json["steady"], false);
  EXPECT_TRUE(json["runup_mean_m"].is_null());  // 0.36 s are no steady state: no means
  EXPECT_GT(json["runup_peak_m"].get<double>(), 1.75);
  const ResultsFile results(killed / "post");
  EXPECT_EQ(results.damage(), "");
  EXPECT_FALSE(is_whole_run(*results.results(), parse_case(small_avalanche, "small.toml", {"output.duration_s=0.36"})));
}

TEST_F(PostOfARun, IsOutOfDateWhenTheRunGoesOnAndTheRunSaysSo) {
  RunOptions longer;
  longer.out = *directory_ / "longer";
  std::filesystem::copy(run(), longer.out, std::filesystem::copy_options::recursive);
  post_process(longer.out, longer.out / "post");
  longer.resume = true;
  EXPECT_TRUE(run_case(parse_case(small_avalanche, "small.toml", {"output.duration_s=0.44"}), longer).finished);
  EXPECT_NE(read_file(longer.out / "run.log").find("make it again with mpm post"), std::string::npos);
  EXPECT_EQ(read_file(run() / "run.log").find("mpm post"), std::string::npos);
}

TEST_F(PostOfARun, KeepsTheRunsOwnMeansOnlyOverTheSameInterval) {
  const std::filesystem::path steady = *directory_ / "steady";
  std::filesystem::copy(run(), steady, std::filesystem::copy_options::recursive);
  const auto entries_after = [&](bool was_steady) {
    Results own = *ResultsFile(run()).results();
    if (was_steady) own.replace(std::vector<Result>{{"steady_from_s", 0.1, {}, {}}, {"steady_to_s", 0.2, {}, {}}});
    write_file(steady / "results.json", own.to_json());
    (void)post_process(steady, steady / "post");
    return nlohmann::json::parse(read_file(steady / "post/results.json"));
  };
  EXPECT_TRUE(entries_after(false).contains("force_peak_n"));
  const auto others = entries_after(true);  // of an interval that the frames do not show
  EXPECT_FALSE(others.contains("overturning_moment_mean_n_m"));
  EXPECT_FALSE(others.contains("force_peak_to_mean"));
  EXPECT_TRUE(others.contains("commit"));
  EXPECT_TRUE(others.contains("runup_peak_m"));
}

TEST_F(PostOfARun, RefusesFramesWithAGap) {
  const std::filesystem::path gap = *directory_ / "gap";
  std::filesystem::copy(run(), gap, std::filesystem::copy_options::recursive);
  std::filesystem::remove(frame_path(gap, 4));
  EXPECT_THROW(post_process(gap, gap / "post"), IoError);
}

TEST_F(PostOfARun, RefusesARunWhoseSeriesWasAltered) {
  const std::filesystem::path altered = *directory_ / "altered";
  std::filesystem::copy(run(), altered, std::filesystem::copy_options::recursive);
  std::string series = read_file(altered / "series.csv");
  series[series.size() - 2] ^= 1;
  write_file(altered / "series.csv", series);
  EXPECT_THROW(post_process(altered, altered / "post"), IoError);
}

TEST_F(PostOfARun, PicturesAreDrawnFromTheFolder) {
  if (std::system("/usr/bin/python3 -c 'import matplotlib, h5py, pandas, markupsafe' 2>/dev/null") != 0) {
    GTEST_SKIP() << "a package is missing (Debian: python3-matplotlib, python3-h5py, python3-pandas, python3-jinja2)";
  }
  const std::filesystem::path pictures = *directory_ / "pictures";
  const std::string line = fmt::format("'{}/scripts/plot_run.py' '{}' --out '{}' --times 0.1,0.4 2>/dev/null", MPM_SOURCE_DIR,
                                       run().string(), pictures.string());
  ASSERT_EQ(std::system(line.c_str()), 0) << line;
  for (const char* name : {"heights.png", "forces.png", "side_view.png"}) EXPECT_EQ(read_file(pictures / name).substr(1, 3), "PNG") << name;
  EXPECT_FALSE(std::filesystem::exists(pictures / "profile.png"));  // no steady span, no mean profile
}

TEST_F(PostOfARun, RefusesFramesOfAnotherCaseAndFoldersWithoutFrames) {
  const std::filesystem::path other = *directory_ / "other";
  std::filesystem::copy(run(), other, std::filesystem::copy_options::recursive);
  Case c = parse_case(small_avalanche, "small.toml");
  c.material.as<CamClay>().critical_state_slope = 0.8;
  write_file(other / "case.toml", write_case(c));
  EXPECT_THROW(post_process(other, other / "post"), IoError);
  std::filesystem::remove_all(other / "frames");
  EXPECT_THROW(post_process(other, other / "post"), IoError);
  EXPECT_THROW(post_process(*directory_ / "none", *directory_ / "out"), IoError);
}

}  // namespace
}  // namespace mpm
