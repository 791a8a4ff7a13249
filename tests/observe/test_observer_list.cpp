#include "libmpm/observe/observer_list.hpp"

#include <gmock/gmock.h>

#include <map>
#include <numeric>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/io/snapshot.hpp"
#include "support/solver_states.hpp"
#include "support/trial_observer.hpp"

namespace mpm {
namespace {

using ::testing::ElementsAre;
using testing::TrialObserver;

/// A small avalanche with all its observers, sampled from time to time.
struct Observed {
  Case c = testing::small_avalanche(6.0);
  CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  ObserverList observers = fresh();
  RunProgress progress;

  Observed() { observers.begin(state, scene); }
  [[nodiscard]] ObserverList fresh() const {
    auto all = make_observers(c, scene);
    all.push_back(std::make_shared<TrialObserver>());
    return ObserverList(std::move(all));
  }
  void sample_at(double time) {
    const double before = state.time;
    advance(state, scene, time, [&](const StepReport& report) { observers.after_step(report, state); });
    const LiveState live{state, scene, totals(state, scene)};
    (void)observers.sample({state.time, state.time - before, &live});
    ++progress.samples;
  }
  [[nodiscard]] std::vector<Result> results(const ObserverList& list) const {
    return list.results(list.summary(&state, &progress)).entries();
  }
};

void expect_same(const Arrays& a, const Arrays& b) {
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, values] : a) {
    ASSERT_EQ(values.size(), b.at(name).size()) << name;
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_TRUE(values[i] == b.at(name)[i] || (std::isnan(values[i]) && std::isnan(b.at(name)[i]))) << name << ' ' << i;
  }
}

/// An entry with all digits, where unknown equals unknown.
std::string text_of(const Result& result) {
  Results one;
  one.add(result);
  return one.to_json();
}

TEST(ColumnNames, EndInTheUnit) {
  const Column force{.quantity = "force", .axis = 'x', .unit = "N"}, compaction{.quantity = "compaction"},
      momentum{.quantity = "momentum", .axis = 'z', .unit = "kg m/s"};
  EXPECT_EQ(force.name(), "force_x_n");
  EXPECT_EQ(force.statistic("mean"), "force_mean_n");
  EXPECT_EQ(force.statistic("effective_samples", false), "force_effective_samples");
  EXPECT_EQ(compaction.name(), "compaction");
  EXPECT_EQ(momentum.name(), "momentum_z_kg_m_s");
}

TEST(TimeSeriesOfColumns, RefusesWhatDoesNotFit) {
  const std::vector<Column> twice = {{.quantity = "a"}, {.quantity = "a"}};
  EXPECT_THROW((void)TimeSeries(twice), Error);
  TimeSeries series(std::vector<Column>{{.quantity = "a", .unit = "m"}});
  EXPECT_THROW(series.append(std::vector{1.0}), Error);
  EXPECT_THROW((void)series["b"], Error);
  series.append(std::vector{0.0, 1.5});
  EXPECT_THAT(series["a_m"], ElementsAre(1.5));
  EXPECT_THROW(series.load({{"time_s", {0.0}}}, 1), IoError) << "a column is missing";
  EXPECT_THROW(series.load({{"time_s", {0.0}}, {"a_m", {1.0, 2.0}}}, 1), IoError) << "a column is too long";
  EXPECT_EQ(series.size(), 1U) << "unchanged";
}

TEST(ResultsOfRuns, AreFoundByName) {
  Results results;
  results.add(Result{"steps", std::uint64_t{7}, "", ""});
  results.add(Result{"force_mean_n", std::array{1.0, 2.0, 3.0}, "N", ""});
  results.add(Result{"title", std::string("t"), "", ""});
  results.add(Result{"steady", true, "", ""});
  EXPECT_EQ(results.number("steps"), 7.0);
  EXPECT_EQ(results.number("force_mean_n", 2), 3.0);
  EXPECT_EQ(results.number("steady"), 1.0);
  EXPECT_FALSE(results.has("runup_mean_m"));
  EXPECT_THROW((void)results.number("runup_mean_m"), Error);
  EXPECT_THROW((void)results.number("title"), Error);
}

TEST(ResultsOfRuns, ComeBackFromTheirText) {
  Results results;
  results.add({{"steps", std::uint64_t{7}, "", ""}, {"share", 0.1, "", ""}, {"whole", 3.0, "", ""}, {"title", std::string("t"), "", ""}});
  results.add({{"force_mean_n", std::array{1.0, 2.5e-7, std::nan("")}, "N", ""}, {"steady", true, "", ""}, {"gone", std::nan(""), "", ""}});
  results.add({"crc32", std::string("00000000"), "", ""});
  const std::string text = results.to_json();
  const auto again = Results::from_json(text);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->to_json(), text) << "the same types, digits and checksum";
  EXPECT_EQ(again->text("title"), "t");
  EXPECT_TRUE(std::isnan(again->number("gone")));
  EXPECT_TRUE(std::isnan(again->number_or_nan("of another program")));
  const std::vector<Result> single = again->components();
  ASSERT_EQ(single.size(), 10U);
  EXPECT_EQ(single[5].name, "force_mean_n.y");
  EXPECT_EQ(as_number(single[5].value), 2.5e-7);
  EXPECT_EQ(as_number(single[6].value), std::nullopt);
  Results changed = *again;
  changed.replace({{"share", 0.2, "", ""}, {"new", 1.0, "", ""}});
  EXPECT_EQ(changed.entries()[1].name, "share");
  EXPECT_EQ(changed.number("share"), 0.2);
  EXPECT_EQ(changed.entries().back().name, "new");
  for (const char* other : {"", "{", "[1, 2]", "3", R"({"a": {"b": 1}})", R"({"a": [1, 2]})", R"({"a": [1, 2, "x"]})"})
    EXPECT_FALSE(Results::from_json(other)) << other;
}

TEST(Observers, ComeBackWholeFromWhatTheySave) {
  Observed run;
  for (const double time : {0.0, 0.05, 0.1, 0.15}) run.sample_at(time);
  const Arrays saved = run.observers.save();
  EXPECT_TRUE(saved.contains("pressure_profile.pressure_pa"));
  EXPECT_TRUE(saved.contains("force_by_height.force_n"));
  EXPECT_TRUE(saved.contains("trial.largest_x_m"));
  ObserverList again = run.fresh();
  again.load(saved, run.progress.samples);
  expect_same(again.save(), saved);
  const auto a = run.results(run.observers), b = run.results(again);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].name == "peak_memory_bytes") continue;
    EXPECT_EQ(text_of(a[i]), text_of(b[i]));
  }
}

TEST(Observers, RefuseArraysOfAnotherLength) {
  Observed run;
  for (const double time : {0.0, 0.05}) run.sample_at(time);
  const Arrays saved = run.observers.save();
  ObserverList again = run.fresh();
  EXPECT_THROW(again.load(saved, 3), IoError) << "two samples, not three";
  for (const auto& [name, values] : saved) {
    Arrays hostile = saved;
    hostile[name].push_back(1.0);
    EXPECT_THROW(again.load(hostile, 2), IoError) << name << " too long";
    hostile.erase(name);
    EXPECT_THROW(again.load(hostile, 2), IoError) << name << " missing";
  }
}

TEST(Observers, MeasureAStoredFrameAsTheStateItself) {
  Observed run;
  for (const double time : {0.0, 0.1, 0.2}) run.sample_at(time);
  Snapshot frame;
  frame.info.time = run.state.time;
  frame.info.reference_density = run.c.material.density();
  frame.particles = particle_table(run.state, run.scene);
  ObserverList of_frames = run.fresh();
  const auto row = of_frames.sample(frame, [](const Column& column) { return column.kind == Column::Kind::instant ? 1.0 : 2.0; });
  const auto& names = run.observers.series().names();
  ASSERT_EQ(row.size(), names.size());
  std::map<std::string, Column::Kind> carried_over;  // columns that a frame does not give
  for (const ObserverDescription& d : describe_observers()) {
    if (d.measured_from == MeasuredFrom::frames) continue;
    for (const Column& column : d.columns) carried_over[column.name()] = column.kind;
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double expected = run.observers.series().values()[i].back();
    if (const auto copied = carried_over.find(names[i]); copied != carried_over.end()) {
      EXPECT_EQ(row[i], copied->second == Column::Kind::instant ? 1.0 : 2.0) << names[i] << ": carried over";
    } else if (std::isnan(expected)) {
      EXPECT_TRUE(std::isnan(row[i])) << names[i];
    } else {
      EXPECT_NEAR(row[i], expected, 1e-11 * std::abs(expected)) << names[i];  // sums of some thousand terms in another order
    }
  }
}

TEST(Observers, AreAllDescribedWithUnitAndMeaning) {
  std::vector<std::string> keys;
  for (const ObserverDescription& d : describe_observers()) {
    EXPECT_FALSE(d.cases.empty());
    for (const Column& column : d.columns) EXPECT_FALSE(column.meaning.empty()) << column.name();
    for (const Column& column : d.profiles) EXPECT_FALSE(column.meaning.empty()) << column.name();
    for (const Result& r : d.results) {
      EXPECT_FALSE(r.meaning.empty()) << r.name;
      if (r.name != "peak_memory_bytes" && !r.name.ends_with("_per_s")) {
        EXPECT_TRUE(r.name.ends_with(unit_suffix(r.unit))) << r.name;
      }
      keys.push_back(r.name);
    }
  }
  std::ranges::sort(keys);
  EXPECT_EQ(std::ranges::adjacent_find(keys), keys.end()) << "two entries of one name";
  const std::string tables = observers_markdown(), json = observers_json();
  for (const std::string& key : keys) {
    const bool in_a_shared_row = key.find("_standard_error") != std::string::npos || key.find("_effective_samples") != std::string::npos;
    EXPECT_EQ(tables.find("`" + key + "`") != std::string::npos, !in_a_shared_row) << key;
    EXPECT_NE(json.find('"' + key + '"'), std::string::npos) << key;
  }
}

TEST(Observers, SayWhatAComparisonLeavesOut) {
  for (const char* key : {"wall_time_s", "solver_time_s", "threads", "commit", "title", "peak_memory_bytes", "frames"})
    EXPECT_EQ(nature_of(key), Nature::execution) << key;
  for (const char* key : {"runup_standard_error_m", "force_effective_samples.z"}) EXPECT_EQ(nature_of(key), Nature::uncertainty) << key;
  for (const char* key : {"steps", "runup_mean_m", "force_mean_n.x", "what_no_observer_has"})
    EXPECT_EQ(nature_of(key), Nature::physics) << key;
}

}  // namespace
}  // namespace mpm
