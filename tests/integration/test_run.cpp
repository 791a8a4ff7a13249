#include "libmpm/driver/run.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/replay.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/snapshot.hpp"
#include "libmpm/observe/observer_list.hpp"
#include "libmpm/observe/runup.hpp"
#include "support/solver_states.hpp"
#include "support/temporary_directory.hpp"
#include "support/trial_observer.hpp"

namespace mpm {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

Case short_avalanche(double duration = 0.2) {
  Case c = testing::small_avalanche(6.0);
  c.output.duration = duration;
  c.output.series_per_second = 50.0;
  c.output.frames_per_second = 25.0;
  return c;
}

class RunCase : public ::testing::Test {
 protected:
  RunOptions into(const std::string& name, bool resume = false, int threads = 1) const {
    RunOptions o;
    o.out = directory / name;
    o.threads = threads;
    o.resume = resume;
    return o;
  }
  /// Asks for a stop after so many samples.
  static std::function<Request()> stop_after(int samples) {
    return [left = samples]() mutable { return --left <= 0 ? Request::stop : Request::none; };
  }
  /// Messages of a run that goes on to its end.
  std::vector<std::string> messages_of_resuming(const Case& c, const std::string& name) const {
    std::vector<std::string> messages;
    RunOptions options = into(name, true);
    options.on_progress = [&](const Progress& p) {
      if (!p.message.empty()) messages.push_back(p.message);
    };
    EXPECT_TRUE(run_case(c, options).finished);
    return messages;
  }
  /// The same run, whatever interrupted it. final.h5 has no time stamp; series.csv is written with all digits.
  void expect_same_run(const std::string& a, const std::string& b) const {
    EXPECT_EQ(content(directory / a / "final.h5"), content(directory / b / "final.h5"));
    EXPECT_EQ(content(directory / a / "series.csv"), content(directory / b / "series.csv"));
    EXPECT_EQ(content(directory / a / "profile.csv"), content(directory / b / "profile.csv"));
    EXPECT_EQ(content(directory / a / "profiles.h5"), content(directory / b / "profiles.h5"));
    EXPECT_EQ(content(directory / a / "case.toml"), content(directory / b / "case.toml"));
    const auto frames = frame_numbers(directory / a);
    ASSERT_EQ(frames, frame_numbers(directory / b));
    for (const int n : frames) EXPECT_EQ(content(frame_path(directory / a, n)), content(frame_path(directory / b, n))) << n;
    EXPECT_EQ(content(directory / a / "frames.xdmf"), content(directory / b / "frames.xdmf"));
    auto x = nlohmann::json::parse(content(directory / a / "results.json")),
         y = nlohmann::json::parse(content(directory / b / "results.json"));
    for (const char* of_the_machine :
         {"wall_time_s", "solver_time_s", "million_particle_steps_per_s", "peak_memory_bytes", "threads", "ranks", "crc32"}) {
      x.erase(of_the_machine);
      y.erase(of_the_machine);
    }
    EXPECT_EQ(x, y);
  }
  testing::TemporaryDirectory directory;
};

TEST_F(RunCase, LeavesTheFilesItPromises) {
  const Case c = short_avalanche();
  int samples = 0;
  RunOptions options = into("a");
  options.on_progress = [&](const Progress& p) { samples += p.message.empty(); };
  const RunResult result = run_case(c, options);
  EXPECT_TRUE(result.finished);
  EXPECT_EQ(result.time, 0.2);
  EXPECT_EQ(samples, 10);
  for (const char* name :
       {"case.toml", "series.csv", "profile.csv", "profiles.h5", "results.json", "final.h5", "checkpoint.h5", "run.log", "frames.xdmf"}) {
    EXPECT_TRUE(fs::exists(directory / "a" / name)) << name;
  }
  EXPECT_EQ(read_case(directory / "a/case.toml"), c);

  const Table series = Table::read(directory / "a/series.csv");
  for (const char* column : {"time_s", "runup_m", "runup_p99_m", "pressure_height_m", "impact_pressure_pa", "force_x_n", "force_y_n",
                             "force_z_n", "mass_kg", "momentum_x_kg_m_s", "kinetic_energy_j", "elastic_energy_j", "potential_energy_j"}) {
    EXPECT_TRUE(series.has(column)) << column;
  }
  ASSERT_EQ(series.rows(), 11U);
  for (std::size_t k = 0; k < 11; ++k) EXPECT_EQ(series.numbers("time_s")[k], static_cast<double>(k) / 50.0);
  EXPECT_TRUE(std::isnan(series.numbers("force_x_n")[0]));  // an average over no time
  EXPECT_GT(series.numbers("force_x_n")[10], 0.0);
  EXPECT_EQ(series.numbers("force_y_n")[10], 0.0);  // of the whole: the halves cancel

  EXPECT_EQ(frame_numbers(directory / "a").size(), 6U);  // every second sample, both ends
  const Snapshot final_state = read_snapshot(directory / "a/final.h5", SnapshotKind::final);
  EXPECT_EQ(final_state.info.time, 0.2);
  EXPECT_EQ(final_state.particles.size(), result.particles);
  EXPECT_TRUE(std::is_sorted(final_state.particles.id.begin(), final_state.particles.id.end()));

  EXPECT_EQ(result.results.to_json(), content(directory / "a/results.json"));
  const auto json = nlohmann::json::parse(result.results.to_json());
  for (const char* key : {"title",
                          "case_hash",
                          "version",
                          "commit",
                          "ranks",
                          "threads",
                          "wall_time_s",
                          "steps",
                          "particle_steps",
                          "million_particle_steps_per_s",
                          "peak_memory_bytes",
                          "particles_final",
                          "particles_lost",
                          "runup_mean_m",
                          "runup_p99_mean_m",
                          "runup_standard_error_m",
                          "runup_peak_m",
                          "pressure_height_mean_m",
                          "impact_pressure_mean_pa",
                          "force_mean_n",
                          "moment_mean_n_m",
                          "compaction_mean",
                          "predicted_runup_m",
                          "predicted_pressure_height_m",
                          "steady"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["title"], "small avalanche");
  EXPECT_EQ(json["case_hash"], case_hash_text(c));
  EXPECT_EQ(json["particles_initial"].get<std::uint64_t>() + json["particles_entered"].get<std::uint64_t>(),
            json["particles_final"].get<std::uint64_t>() + json["particles_lost"].get<std::uint64_t>() +
                json["particles_left_downstream"].get<std::uint64_t>());
}

TEST_F(RunCase, StoppedAndResumedEndsAsIfNothingHadHappened) {
  const Case c = short_avalanche();
  run_case(c, into("whole"));
  RunOptions first = into("parts");
  first.poll = stop_after(3);
  const RunResult stopped = run_case(c, first);
  EXPECT_FALSE(stopped.finished);
  EXPECT_EQ(stopped.time, 3.0 / 50.0);
  EXPECT_FALSE(fs::exists(directory / "parts/results.json"));
  RunOptions second = into("parts", true, 3);  // other threads
  second.poll = stop_after(4);
  EXPECT_FALSE(run_case(c, second).finished);
  EXPECT_TRUE(run_case(c, into("parts", true)).finished);
  expect_same_run("whole", "parts");
  EXPECT_THAT(content(directory / "parts/run.log"), HasSubstr("resumed"));
}

TEST_F(RunCase, WithFlipResumesAsWell) {
  Case c = short_avalanche(0.1);
  c.numerics.transfer = Transfer::flip;
  run_case(c, into("whole"));
  RunOptions first = into("parts");
  first.poll = stop_after(2);
  run_case(c, first);
  EXPECT_TRUE(run_case(c, into("parts", true)).finished);
  expect_same_run("whole", "parts");
}

TEST_F(RunCase, InSinglePrecisionResumesAsWellAndSaysSo) {
  for (const Transfer transfer : {Transfer::apic, Transfer::aflip}) {
    Case c = short_avalanche(0.1);
    c.numerics.precision = Precision::single_precision;
    c.numerics.transfer = transfer;
    const std::string whole = transfer == Transfer::apic ? "whole" : "whole_aflip",
                      parts = transfer == Transfer::apic ? "parts" : "parts_aflip";
    run_case(c, into(whole));
    RunOptions first = into(parts);
    first.poll = stop_after(2);
    run_case(c, first);
    EXPECT_TRUE(run_case(c, into(parts, true)).finished);
    expect_same_run(whole, parts);
  }
  EXPECT_EQ(nlohmann::json::parse(content(directory / "whole/results.json"))["precision"], "single");
  EXPECT_EQ(read_snapshot(directory / "whole/final.h5", SnapshotKind::final).info.precision, Precision::single_precision);
  EXPECT_EQ(read_snapshot(frame_path(directory / "whole", 0), SnapshotKind::frame).info.precision, Precision::single_precision);
  EXPECT_EQ(hdf5::Reader(directory / "whole/checkpoint.h5").text("precision"), "single");
  EXPECT_THAT(content(directory / "whole/run.log"), HasSubstr("single precision"));
}

TEST_F(RunCase, InOnePrecisionIsNotResumedInTheOther) {
  for (const bool from_single : {false, true}) {
    Case c = short_avalanche(0.04);
    c.numerics.precision = from_single ? Precision::single_precision : Precision::double_precision;
    const std::string name = from_single ? "single" : "double";
    run_case(c, into(name));
    c.numerics.precision = from_single ? Precision::double_precision : Precision::single_precision;
    c.output.duration = 0.08;
    try {
      run_case(c, into(name, true));
      FAIL() << "resumed";
    } catch (const ConfigError& error) {
      EXPECT_THAT(error.what(), ::testing::AllOf(HasSubstr("another case"), HasSubstr("numerics.precision was"), HasSubstr("double"),
                                                 HasSubstr("single")));
    }
  }
}

TEST_F(RunCase, ExtendedEndsAsALongerRunDoes) {
  run_case(short_avalanche(0.2), into("whole"));
  run_case(short_avalanche(0.09), into("parts"));  // ends at the sample at or after: 0.1 s
  EXPECT_EQ(read_snapshot(directory / "parts/final.h5", SnapshotKind::final).info.time, 0.1);
  EXPECT_TRUE(run_case(short_avalanche(0.2), into("parts", true)).finished);
  expect_same_run("whole", "parts");
}

TEST_F(RunCase, KilledAfterACheckpointGoesOnFromItAndDropsWhatCameAfter) {
  const Case c = short_avalanche();
  run_case(c, into("whole"));
  struct Killed {};
  RunOptions first = into("parts");
  int polls = 0;
  first.poll = [&] {
    if (++polls == 7) throw Killed{};
    return polls == 4 ? Request::checkpoint : Request::none;
  };
  EXPECT_THROW(run_case(c, first), Killed);
  EXPECT_EQ(Table::read(directory / "parts/series.csv").rows(), 8U);  // more rows than the checkpoint knows
  EXPECT_TRUE(run_case(c, into("parts", true)).finished);
  expect_same_run("whole", "parts");
}

TEST_F(RunCase, ResumedWithoutACheckpointStartsFromTheBeginning) {
  const Case c = short_avalanche(0.04);
  run_case(c, into("whole"));
  EXPECT_TRUE(run_case(c, into("parts", true)).finished);
  expect_same_run("whole", "parts");
}

TEST_F(RunCase, RefusesToResumeAnotherCaseAndLeavesEverythingAsItWas) {
  Case c = short_avalanche(0.04);
  run_case(c, into("a"));
  const std::string series = content(directory / "a/series.csv"), toml = content(directory / "a/case.toml"),
                    log = content(directory / "a/run.log");
  c.material.as<CamClay>().critical_state_slope = 0.5;
  try {
    run_case(c, into("a", true));
    ADD_FAILURE() << "not refused";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("material.critical_state_slope was 0.4, is 0.5"));
  }
  EXPECT_EQ(content(directory / "a/series.csv"), series);
  EXPECT_EQ(content(directory / "a/case.toml"), toml);
  EXPECT_EQ(content(directory / "a/run.log"), log);
  fs::resize_file(directory / "a/checkpoint.h5", 1000);
  c.material.as<CamClay>().critical_state_slope = 0.4;
  EXPECT_THROW(run_case(c, into("a", true)), IoError);
  EXPECT_EQ(content(directory / "a/series.csv"), series);
  for (const char* file : {"a/checkpoint.h5", "a/checkpoint.previous.h5", "a/results.json"}) fs::remove(directory / file);
  c.material.as<CamClay>().critical_state_slope = 0.5;
  EXPECT_THROW(run_case(c, into("a", true)), ConfigError) << "interrupted before the first checkpoint";
  EXPECT_EQ(content(directory / "a/series.csv"), series);
}

TEST_F(RunCase, DamagedCheckpointGivesWayToTheOneBefore) {
  const Case c = short_avalanche();
  run_case(c, into("whole"));
  RunOptions first = into("parts");
  int polls = 0;
  first.poll = [&] { return ++polls == 8 ? Request::stop : polls % 3 == 0 ? Request::checkpoint : Request::none; };
  EXPECT_FALSE(run_case(c, first).finished);  // checkpoints of samples 3, 6 and 8
  fs::resize_file(directory / "parts/checkpoint.h5", 5000);
  std::ofstream(frame_path(directory / "parts", 4)) << "damaged; will be written again";
  std::ofstream(directory / "parts/.checkpoint.h5.999999999.0.tmp") << "of a killed process";
  const std::vector<std::string> messages = messages_of_resuming(c, "parts");
  EXPECT_THAT(messages, ::testing::Contains(::testing::AllOf(HasSubstr("checkpoint.refused.h5"), HasSubstr("checkpoint.previous.h5"))));
  EXPECT_THAT(messages, ::testing::Contains(HasSubstr("resumed at t = 0.12 s")));
  expect_same_run("whole", "parts");
  EXPECT_FALSE(fs::exists(directory / "parts/.checkpoint.h5.999999999.0.tmp"));
}

TEST_F(RunCase, WritesADamagedSeriesAgainFromTheCheckpoint) {
  const Case c = short_avalanche();
  run_case(c, into("whole"));
  const std::string whole = content(directory / "whole/series.csv");
  const std::size_t row = whole.find("\n0.04,") + 1;
  std::string digit = whole;
  digit[whole.find(',', row) + 1] ^= 1;  // "5.2" becomes "4.2"
  for (const std::string& damaged :
       {std::string(), whole.substr(0, row + 9), digit, "x" + whole, whole.substr(0, row) + whole.substr(row + 9)}) {
    RunOptions first = into("parts");
    first.poll = stop_after(5);
    EXPECT_FALSE(run_case(c, first).finished);
    std::ofstream(directory / "parts/series.csv", std::ios::binary) << damaged;
    if (damaged.empty()) fs::remove(directory / "parts/series.csv");
    EXPECT_THAT(messages_of_resuming(c, "parts"), ::testing::Contains(HasSubstr("series.csv was missing or damaged"))) << damaged;
    expect_same_run("whole", "parts");
  }
}

TEST_F(RunCase, RefusesToResumeUpToAnEarlierTimeThanItReached) {
  run_case(short_avalanche(0.08), into("a"));
  const std::string toml = content(directory / "a/case.toml"), results = content(directory / "a/results.json");
  for (const bool checkpoint : {true, false}) {
    if (!checkpoint) fs::remove(directory / "a/checkpoint.h5");
    EXPECT_ANY_THROW(run_case(short_avalanche(0.04), into("a", true))) << checkpoint;
    EXPECT_EQ(content(directory / "a/case.toml"), toml);
    EXPECT_EQ(content(directory / "a/results.json"), results);
  }
}

TEST_F(RunCase, DoesNotCountAsFinishedOnceItsResultsWereAltered) {
  const Case c = short_avalanche(0.04);
  run_case(c, into("whole"));
  const std::string results = content(directory / "whole/results.json");
  ASSERT_TRUE(finished_results(directory / "whole", c));
  const std::size_t digit = results.find("\"particles_final\": ") + 19;
  std::string altered = results;
  altered[digit] = altered[digit] == '9' ? '8' : '9';
  for (const std::string& damaged : {altered, results.substr(0, digit), std::string("[]")}) {
    fs::copy(directory / "whole", directory / "a", fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    write_file(directory / "a/results.json", damaged);
    EXPECT_FALSE(finished_results(directory / "a", c)) << damaged;
    EXPECT_THAT(ResultsFile(directory / "a").damage(), HasSubstr("results.json"));
    fs::remove(directory / "a/checkpoint.h5");  // with it the run goes on from its end
    EXPECT_TRUE(run_case(c, into("a", true)).finished);
    expect_same_run("whole", "a");
  }
  for (const char* name : {"series.csv", "profile.csv"}) {
    SCOPED_TRACE(name);
    const std::string table = content(directory / "whole" / name);
    write_file(directory / "whole" / name, table + "9e9\n");
    EXPECT_FALSE(finished_results(directory / "whole", c));
    EXPECT_THAT(ResultsFile(directory / "whole").damage(), HasSubstr(name));
    EXPECT_THROW(ResultsFile(directory / "whole").require_undamaged(), IoError);  // mpm post, mpm compare
    fs::remove(directory / "whole" / name);
    EXPECT_THAT(ResultsFile(directory / "whole").damage(), HasSubstr(std::string(name) + " is missing"));
    write_file(directory / "whole" / name, table);
    EXPECT_EQ(ResultsFile(directory / "whole").damage(), "");
  }
  // A text without checksums, such as one written by hand.
  auto json = nlohmann::ordered_json::parse(results);
  for (const char* key : {"crc32", "series_crc32", "profile_crc32"}) json.erase(key);
  write_file(directory / "whole/results.json", json.dump());
  EXPECT_TRUE(finished_results(directory / "whole", c));
  json["measured_from"] = "frames";
  write_file(directory / "whole/results.json", json.dump());
  EXPECT_FALSE(finished_results(directory / "whole", c));
}

TEST_F(RunCase, NeverStartsFromTheBeginningOverADamagedCheckpointOrFinishedResults) {
  const Case c = short_avalanche(0.04);
  run_case(c, into("a"));
  const std::string series = content(directory / "a/series.csv");
  std::ofstream(directory / "a/checkpoint.h5") << "damaged";
  EXPECT_THROW(run_case(c, into("a", true)), IoError);
  fs::remove(directory / "a/checkpoint.h5");
  EXPECT_THROW(run_case(c, into("a", true)), IoError);
  EXPECT_EQ(content(directory / "a/series.csv"), series);
  EXPECT_TRUE(fs::exists(directory / "a/results.json"));
  Case other = short_avalanche(0.08);
  other.material.as<CamClay>().critical_state_slope = 0.8;
  EXPECT_THROW(run_case(other, into("a", true)), IoError);
  EXPECT_EQ(content(directory / "a/series.csv"), series);
  // The same case up to a later time: everything that is there comes again.
  EXPECT_TRUE(run_case(short_avalanche(0.08), into("a", true)).finished);
  EXPECT_EQ(content(directory / "a/series.csv").substr(0, series.size()), series);
}

TEST_F(RunCase, EndsWhenItsFolderIsTakenAway) {
  const Case c = short_avalanche();
  run_case(c, into("whole"));
  RunOptions options = into("a");
  int polls = 0;
  options.poll = [&] {
    if (++polls == 4) fs::rename(directory / "a", directory / "b");
    return polls == 2 ? Request::checkpoint : Request::none;
  };
  EXPECT_THROW(run_case(c, options), IoError);
  EXPECT_FALSE(fs::exists(directory / "a"));
  EXPECT_TRUE(run_case(c, into("b", true)).finished);
  expect_same_run("whole", "b");
}

TEST_F(RunCase, ANewRunLeavesNothingOfTheOldOne) {
  RunOptions old = into("a");
  old.poll = [polls = 0]() mutable { return ++polls < 4 ? Request::checkpoint : Request::none; };
  run_case(short_avalanche(0.2), old);
  ASSERT_TRUE(fs::exists(directory / "a/checkpoint.previous.h5"));
  Case other = short_avalanche(0.1);
  other.material.as<CamClay>().critical_state_slope = 0.8;
  RunOptions options = into("a");
  options.poll = stop_after(1);
  run_case(other, options);
  for (const char* of_the_end : {"results.json", "final.h5", "profile.csv", "checkpoint.previous.h5"})
    EXPECT_FALSE(fs::exists(directory / "a" / of_the_end)) << of_the_end;
  EXPECT_EQ(frame_numbers(directory / "a").size(), 1U);
}

TEST_F(RunCase, ASecondRunInTheDirectoryIsRefusedAndTheFirstGoesOn) {
  const Case c = short_avalanche(0.04);
  RunOptions options = into("a");
  bool refused = false;
  options.poll = [&] {
    try {
      run_case(c, into("a", true));
    } catch (const IoError& error) {
      refused = std::string(error.what()).find("another process") != std::string::npos;
    }
    return Request::none;
  };
  EXPECT_TRUE(run_case(c, options).finished);
  EXPECT_TRUE(refused);
  EXPECT_TRUE(run_case(c, into("a", true)).finished);  // the lock went with the run
}

TEST_F(RunCase, ThatBecomesUnstableKeepsWhatItWrote) {
  Case c = testing::empty_case();
  c.output.series_per_second = 100.0;
  c.output.frames_per_second = 100.0;
  c.output.duration = 0.2;
  c.numerics.cfl = 1.0;
  c.numerics.gravity = 0.0;
  // two blocks that meet after 0.02 s at forty times the wave speed: crushed to nothing in one step
  c.bodies = {testing::box_body(Vec3::Zero(), Vec3::Constant(0.5)),
              testing::box_body({50.0, 0.0, 0.0}, {50.5, 0.5, 0.5}, {-2300.0, 0.0, 0.0})};
  c.domain.max.x() = 60.0;
  try {
    run_case(c, into("a"));
    FAIL() << "not unstable";
  } catch (const UnstableError& error) {
    EXPECT_THAT(error.what(), HasSubstr("particle"));
    EXPECT_THAT(content(directory / "a/run.log"), HasSubstr(error.what()));
  }
  EXPECT_FALSE(fs::exists(directory / "a/results.json"));
  const Table series = Table::read(directory / "a/series.csv");
  EXPECT_GE(series.rows(), 2U);
  EXPECT_EQ(frame_numbers(directory / "a").size(), series.rows());
  EXPECT_EQ(read_snapshot(frame_path(directory / "a", frame_numbers(directory / "a").back()), SnapshotKind::frame).info.time,
            series.numbers("time_s").back());
}

TEST_F(RunCase, MeasuresTheArmByItself) {
  Case c = short_avalanche();
  c.output.duration = 0.4;
  c.arm = ArmSpec{.length = 1.5, .depth = 0.3, .base = 0.4, .height = 0.7};
  const RunResult result = run_case(c, into("a"));
  const Table series = Table::read(directory / "a/series.csv");
  const std::vector<double> arm = series.numbers("arm_force_x_n");
  EXPECT_GT(arm.back(), 0.0);
  EXPECT_NE(arm.back(), series.numbers("force_x_n").back());
  EXPECT_EQ(series.numbers("arm_force_y_n").back(), 0.0);  // of the whole: the halves cancel
  EXPECT_EQ(series.numbers("particles_inside_obstacle").back(), 0.0);
  EXPECT_TRUE(result.results.has("arm_force_filtered_peak_n"));
  EXPECT_EQ(read_case(directory / "a/case.toml"), c);
}

TEST_F(RunCase, ByHandHasNoImpactColumnsAndCountsItsLosses) {
  Case c = testing::empty_case();
  c.bodies = {testing::box_body(Vec3::Zero(), Vec3::Constant(0.5), {10.0, 0.0, 0.0})};
  c.domain.max.x() = 1.0;
  c.output.duration = 0.3;
  const RunResult result = run_case(c, into("a"));
  EXPECT_EQ(result.particles, 0U);
  EXPECT_FALSE(result.results.has("steady"));
  EXPECT_EQ(nlohmann::json::parse(result.results.to_json())["particles_lost"], 64);
  const Table series = Table::read(directory / "a/series.csv");
  EXPECT_FALSE(series.has("runup_m"));
  EXPECT_EQ(series.numbers("particles").back(), 0.0);
}

TEST_F(RunCase, ShiftedByAWholeCellIsTheSameRunInTheSameCoordinates) {
  Case c = short_avalanche(0.1);
  const RunResult plain = run_case(c, into("plain"));
  c.numerics.grid_offset = {1.0, 0.0, -1.0};
  const RunResult shifted = run_case(c, into("shifted"));
  EXPECT_EQ(plain.particle_steps, shifted.particle_steps);
  const Snapshot a = read_snapshot(directory / "plain/final.h5", SnapshotKind::final),
                 b = read_snapshot(directory / "shifted/final.h5", SnapshotKind::final);
  ASSERT_EQ(a.particles.id, b.particles.id);
  // Round-off of coordinates of some metres, 1e-15, grows with each of some 50 steps by the stiffness of the snow.
  for (std::size_t i = 0; i < a.particles.position.size(); ++i) ASSERT_NEAR(a.particles.position[i], b.particles.position[i], 1e-9);
  const Table x = Table::read(directory / "plain/series.csv"), y = Table::read(directory / "shifted/series.csv");
  for (const char* column : {"runup_m", "impact_pressure_pa", "force_x_n", "moment_y_n_m", "potential_energy_j"}) {
    const auto p = x.numbers(column), q = y.numbers(column);
    ASSERT_EQ(p.size(), q.size());
    for (std::size_t i = 1; i < p.size(); ++i) EXPECT_NEAR(p[i], q[i], 1e-6 * std::max(1.0, std::abs(p[i]))) << column << ' ' << i;
  }
}

TEST_F(RunCase, LetsTheCallerMeasureAtEverySample) {
  /// Looks at every sample of a run.
  struct Witness : Observer {
    explicit Witness(const ImpactGeometry& geometry) : own(geometry) {}
    [[nodiscard]] std::string name() const override { return "witness"; }
    [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }
    std::vector<std::string> check(const Instant& now) override {
      time.push_back(now.time);
      interval.push_back(now.interval);
      runup.push_back(measure(own, now.live->state, now.live->scene).front());
      return {};
    }
    Runup own;
    std::vector<double> time, interval, runup;
  };
  const Case c = short_avalanche(0.1);
  const auto witness = std::make_shared<Witness>(*impact_geometry(c));
  RunOptions options = into("a");
  options.observers = {witness};
  (void)run_case(c, options);
  const Table series = Table::read(directory / "a/series.csv");
  EXPECT_EQ(witness->time, series.numbers("time_s"));
  EXPECT_EQ(witness->runup, series.numbers("runup_m"));
  EXPECT_EQ(witness->interval.front(), 0.0);
  EXPECT_NEAR(witness->interval.back(), 0.02, 1e-15);
}

TEST_F(RunCase, ANewObserverReachesSeriesResultsCheckpointAndFrames) {
  const Case c = short_avalanche(0.1);
  const auto with_trial = [&](const std::string& name, bool resume = false) {
    RunOptions options = into(name, resume);
    options.observers = {std::make_shared<testing::TrialObserver>()};
    return options;
  };
  (void)run_case(c, with_trial("whole"));
  RunOptions first = with_trial("parts");
  first.poll = stop_after(2);
  (void)run_case(c, first);
  (void)run_case(c, with_trial("parts", true));
  expect_same_run("whole", "parts");

  const auto front = Table::read(directory / "whole/series.csv").numbers("trial_front_m");
  const auto json = nlohmann::json::parse(content(directory / "whole/results.json"));
  EXPECT_EQ(json["trial_front_largest_m"].get<double>(), *std::ranges::max_element(front));
  EXPECT_TRUE(json.contains("trial_front_mean_m")) << "its column asks for a mean";
  const PostResult again = post_process(directory / "whole", directory / "again", {std::make_shared<testing::TrialObserver>()});
  const auto in_frames = Table::read(directory / "again/series.csv").numbers("trial_front_m");
  ASSERT_EQ(in_frames.size(), 3U);
  for (std::size_t i = 0; i < in_frames.size(); ++i) EXPECT_EQ(in_frames[i], front[2 * i]);
  EXPECT_TRUE(again.results.has("trial_front_largest_m"));
  // a run without it does not go on from a series with its column
  EXPECT_THROW(run_case(short_avalanche(0.2), into("whole", true)), IoError);
}

/// Stiff loose snow, fast and coarse. Where single particles stayed at the face of the mast and swelled, the pressure before it fell to
/// 0.23 of that of the first second, at a steady force; now to 0.56, as some snow there opens.
TEST_F(RunCase, PressureBeforeTheMastStaysWhileTheForceDoes) {
  const Case c = parse_case(R"(
    [material]
    model = "cohesive_cam_clay"
    critical_state_slope = 1.2
    cohesion_beta = 0.0
    hardening_xi = 5.0
    [conveyor]
    froude_number = 7.0
    flow_height_m = 1.75
    feed = "window"
    mirror_y = true
    width_m = 7.0
    upstream_length_m = 5.25
    downstream_length_m = 1.75
    [obstacle]
    width_m = 1.75
    depth_m = 1.75
    friction = 0.29
    [numerics]
    cell_size_m = 0.4375
    precision = "single"
    [output]
    duration_s = 4.0
    series_per_second = 50)",
                            "fast.toml");
  (void)run_case(c, into("fast"));
  const Table series = Table::read(directory / "fast/series.csv");
  const auto mean_over = [&](const char* column, std::size_t first_second) {  // of one second
    const std::vector<double> values = series.numbers(column);
    double sum = 0.0;
    for (std::size_t i = 0; i < 50; ++i) sum += values.at(50 * first_second + 1 + i);
    return sum / 50.0;
  };
  EXPECT_NEAR(mean_over("force_x_n", 3) / mean_over("force_x_n", 0), 1.0, 0.1);
  EXPECT_GT(mean_over("impact_pressure_pa", 3) / mean_over("impact_pressure_pa", 0), 0.4);
}

TEST_F(RunCase, WithoutParticlesIsAConfigError) { EXPECT_THROW(run_case(testing::empty_case(), into("a")), ConfigError); }

TEST_F(RunCase, WhereNothingCanBeWrittenIsAnIoError) {
  std::ofstream(directory / "file") << "not a directory";
  EXPECT_THROW(run_case(short_avalanche(0.04), into("file")), IoError);
  EXPECT_THROW(run_case(short_avalanche(0.04), into("file/below")), IoError);
}

}  // namespace
}  // namespace mpm
