#include "mpm/impact/study.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "mpm/error.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

/// A run of the paper's set-up whose heights obey the published equations.
StudyRun run(double froude, double slope, double beta, double xi) {
  StudyRun r;
  r.froude = froude;
  r.critical_state_slope = slope;
  r.cohesion_beta = beta;
  r.effective_friction = effective_friction(slope, beta);
  r.hardening_xi = xi;
  r.flow_height = r.obstacle_width = 1.75;
  r.gravity = standard_gravity;
  r.velocity = flow_velocity(froude, r.flow_height);
  r.runup = relative_height({r.effective_friction, froude, 1.0}, runup_coefficients);
  r.pressure_height = relative_height({r.effective_friction, froude, 1.0}, pressure_height_coefficients);
  r.runup_error = r.pressure_height_error = 0.02;
  return r;
}

std::vector<StudyRun> grid(std::initializer_list<double> xis = {0.5, 5.0}) {
  std::vector<StudyRun> runs;
  for (const double xi : xis) {
    for (const double froude : {0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0}) {
      for (const double slope : {0.0, 0.4, 0.8, 1.2}) {
        for (const double beta : {0.0, 0.15, 0.3, 0.45}) runs.push_back(run(froude, slope, beta, xi));
      }
    }
  }
  return runs;
}

TEST(FittingSets, AreThoseOfThePaper) {
  const auto sets = paper_fitting_sets();
  ASSERT_EQ(sets.size(), 2u);
  const auto held = [](const FittingSet& set) {
    std::vector<double> xis;
    for (const double xi : {0.05, 0.15, 0.5, 1.5, 5.0, 15.0}) {
      if (set.holds(run(1.0, 0.4, 0.0, xi))) xis.push_back(xi);
    }
    return xis;
  };
  EXPECT_EQ(held(sets[0]), (std::vector<double>{0.5, 1.5, 5.0}));
  EXPECT_EQ(held(sets[1]), (std::vector<double>{0.15, 0.5, 1.5, 5.0, 15.0}));
}

TEST(SetFits, RecoverTheEquationFromItsOwnSetAndScoreTheOthers) {
  auto runs = grid({0.05, 0.5, 5.0});
  for (StudyRun& r : runs) {
    if (r.hardening_xi == 0.05) r.runup *= 1.2;  // outside the set: must not touch the fit
  }
  runs.push_back(run(3.0, 0.4, 0.0, 5.0));
  runs.back().obstacle_width = 3.5;
  runs.back().runup = 50.0;  // nor a mast of another width
  runs.push_back(run(3.0, 0.4, 0.0, 5.0));
  runs.back().pressure_height = std::nan("");
  const SetFit runup = fit_set(HeightEquation::runup, paper_fitting_sets()[0], runs);
  ASSERT_TRUE(runup.fit);
  EXPECT_NEAR(runup.fit->coefficients.k, runup_coefficients.k, 1e-9);
  EXPECT_EQ(runup.runs, 2u * 112u + 1u);
  EXPECT_EQ(runup.other_width, 1u);
  EXPECT_EQ(runup.without_height, 0u);
  const SetFit pressure = fit_set(HeightEquation::pressure_height, paper_fitting_sets()[0], runs);
  EXPECT_EQ(pressure.runs, 2u * 112u);
  EXPECT_EQ(pressure.without_height, 1u);

  const auto row = [&](bool published, std::optional<double> xi, const std::string& group, double at) {
    for (const ScoreRow& r : runup.scores) {
      if (r.published == published && r.xi == xi && r.group == group && (group.empty() || r.at == at)) return r;
    }
    throw std::runtime_error("no such row");
  };
  for (const bool published : {false, true}) {
    EXPECT_NEAR(row(published, {}, "", 0.0).scores.rmsle, 0.0, 1e-8);
    EXPECT_EQ(row(published, {}, "froude_number", 3.0).runs, 33u);
    EXPECT_NEAR(row(published, 0.05, "", 0.0).scores.rmsle, std::log(1.2), 1e-8);
    EXPECT_NEAR(row(published, 0.05, "froude_number", 3.0).scores.bias, 1.2, 1e-8);
    EXPECT_EQ(row(published, 5.0, "effective_friction", 0.0).runs, 28u);
    EXPECT_EQ(row(published, {}, "hardening_xi", 0.5).runs, 112u);
  }
}

TEST(SetFits, SayWhyASetCannotBeFitted) {
  const std::vector<StudyRun> runs{run(1.0, 0.4, 0.0, 5.0), run(3.0, 0.4, 0.0, 5.0)};
  const SetFit s = fit_set(HeightEquation::runup, paper_fitting_sets()[0], runs);
  EXPECT_FALSE(s.fit);
  EXPECT_NE(s.why_not.find("2 runs are left"), std::string::npos) << s.why_not;
  EXPECT_FALSE(s.scores.empty());  // the published equation can be judged all the same
}

TEST(SetFits, AreWrittenAsTablesAndAsJson) {
  const auto runs = grid();
  std::vector<SetFit> fits;
  for (const auto equation : {HeightEquation::runup, HeightEquation::pressure_height}) {
    fits.push_back(fit_set(equation, paper_fitting_sets()[0], runs));
  }
  const std::string coefficients = coefficients_csv(fits);
  EXPECT_EQ(std::ranges::count(coefficients, '\n'), 1 + 2 + 3);
  EXPECT_NE(coefficients.find("pressure_height,narrow,Fr_sat,1.53"), std::string::npos) << coefficients;
  const std::string scores = scores_csv(fits);
  EXPECT_NE(scores.find("runup,narrow,published,,froude_number,0.1,32,"), std::string::npos) << scores.substr(0, 1000);
  StudyTable table;
  table.runs = runs;
  table.left_out = {{"no steady span", 3}};
  const auto json = nlohmann::json::parse(fits_json(fits, table));
  EXPECT_EQ(json["left_out"][0]["rows"], 3);
  EXPECT_NEAR(json["fits"][1]["coefficients"][1]["value"].get<double>(), 1.538, 1e-6);
  EXPECT_EQ(json["fits"][0]["published_scores_on_its_own_data"]["rmsle"], 0.130);
  EXPECT_EQ(json["aims"].size(), 9u);  // two scores each, and five coefficients
  for (const auto& aim : json["aims"]) EXPECT_TRUE(aim["met"].get<bool>()) << aim;
}

TEST(Aims, AreMissedWhereTheDataDiffer) {
  auto runs = grid();
  for (StudyRun& r : runs) r.runup *= 1.4;
  const std::vector<SetFit> fits{fit_set(HeightEquation::runup, paper_fitting_sets()[0], runs)};
  const auto aims = paper_aims(fits);
  ASSERT_EQ(aims.size(), 4u);
  EXPECT_NEAR(aims[0].value, std::log(1.4), 1e-12);
  EXPECT_FALSE(aims[0].met);
  EXPECT_EQ(aims[1].value, 0.0);  // 0.4/1.4 = 29 % off
  EXPECT_FALSE(aims[1].met);
}

TEST(Guideline, IsMetByTheRheologyThatDissipatesAsMuch) {
  // h/H = 1 + Fr^2/2 f / lambda(M') with lambda = exp(1.2 M') f: at M' = ln(1.5/f)/1.2 it is the guideline of lambda = 1.5, without error.
  const double f = width_factor(1.0);
  std::vector<StudyRun> runs;
  std::vector<double> frictions;
  for (int i = 0; i <= 12; ++i) frictions.push_back(0.15 * i);
  for (const double friction : frictions) {
    for (const double froude : {2.0, 3.0, 5.0, 7.0}) {
      StudyRun r = run(froude, friction, 0.0, 5.0);
      r.runup = 1.0 + 0.5 * froude * froude * std::exp(-1.2 * friction);
      if (froude == 2.0) r.runup = 100.0;  // below the range: must not matter
      runs.push_back(r);
    }
  }
  runs.push_back(run(3.0, 5.0, 0.0, 5.0));  // a rheology without Fr 5 and 7
  const auto g = guideline_correspondence(runs);
  ASSERT_EQ(g.minima.size(), 2u);
  ASSERT_EQ(g.deviations.size(), 26u);
  ASSERT_EQ(g.notes.size(), 1u);
  EXPECT_NE(g.notes[0].find("1 values of M' lack a run"), std::string::npos);
  const auto& loose = g.minima[0];
  const double exact = std::log(1.5 / f) / 1.2;  // 0.659
  EXPECT_EQ(loose.lambda, 1.5);
  EXPECT_LT(loose.below, exact);
  EXPECT_GT(loose.above, exact);
  EXPECT_NEAR(loose.at, exact, 0.075 + 1e-12);  // half the spacing
  EXPECT_NEAR(loose.parabola, exact, 0.04);     // |x| near its kink is no parabola: a quarter of the spacing
  // The vertex of Lagrange's parabola through the three lowest points.
  const auto lowest = std::ranges::find(g.deviations, loose.at, &GuidelineDeviation::effective_friction);
  const double x0 = loose.below, x1 = loose.at, x2 = loose.above, y0 = (lowest - 1)->rmsle, y1 = lowest->rmsle, y2 = (lowest + 1)->rmsle;
  const double vertex = 0.5 * (y0 * (x1 * x1 - x2 * x2) + y1 * (x2 * x2 - x0 * x0) + y2 * (x0 * x0 - x1 * x1)) /
                        (y0 * (x1 - x2) + y1 * (x2 - x0) + y2 * (x0 - x1));
  EXPECT_NEAR(loose.parabola, vertex, 1e-12);
  EXPECT_EQ(loose.inside, loose.parabola >= 0.45 && loose.parabola <= 0.65);
  EXPECT_NEAR(g.minima[1].parabola, std::log(3.0 / f) / 1.2, 0.04);
  EXPECT_TRUE(g.minima[1].inside);
  const auto [low, high] = std::ranges::minmax(g.deviations, {}, &GuidelineDeviation::normalised);
  EXPECT_EQ(low.normalised, 0.0);
  EXPECT_EQ(high.normalised, 1.0);
  // The distance itself, by hand, at M' = 0 and lambda = 1.5.
  double sum = 0.0;
  for (const double froude : {3.0, 5.0, 7.0}) {
    const double d = std::log((1.0 + 0.5 * froude * froude) / (1.0 + 0.5 * froude * froude * f / 1.5));
    sum += d * d;
  }
  EXPECT_NEAR(g.deviations[0].rmsle, std::sqrt(sum / 3.0), 1e-12);
}

TEST(Guideline, HasNoParabolaAtAnEndOfTheCurve) {
  std::vector<StudyRun> runs;
  for (const double friction : {0.0, 0.1, 0.2}) {
    for (const double froude : {3.0, 5.0}) runs.push_back(run(froude, friction, 0.0, 5.0));
  }
  const auto g = guideline_correspondence(runs);
  ASSERT_EQ(g.minima.size(), 2u);
  EXPECT_EQ(g.minima[0].at, 0.2);
  EXPECT_TRUE(std::isnan(g.minima[0].parabola));
  EXPECT_TRUE(std::isnan(g.minima[0].above));
  EXPECT_FALSE(g.minima[0].inside);
}

TEST(Guideline, SaysWhatIsMissing) {
  const std::vector<StudyRun> slow{run(1.0, 0.4, 0.0, 5.0)};
  const auto g = guideline_correspondence(slow);
  EXPECT_TRUE(g.minima.empty());
  EXPECT_EQ(g.notes.size(), 1u);
}

TEST(DecompositionChain, AddsOnePropertyAtATime) {
  const auto chain = decomposition_chain({0.8, 0.3, 0.5});
  ASSERT_EQ(chain.size(), 4u);
  auto runs = grid();
  std::erase_if(runs, [](const StudyRun& r) { return r.froude == 5.0 && r.critical_state_slope == 0.8 && r.cohesion_beta == 0.0; });
  const auto links = decompose(runs, chain);
  ASSERT_EQ(links.size(), 7u);
  for (const Decomposition& d : links) {
    EXPECT_EQ(d.bernoulli, 1.0 + 0.5 * d.froude * d.froude);
    for (std::size_t i = 0; i < chain.size(); ++i) {
      if (d.froude == 5.0 && i == 1) {
        EXPECT_TRUE(std::isnan(d.runup[i]));
        continue;
      }
      const StudyRun r = run(d.froude, chain[i].critical_state_slope, chain[i].cohesion_beta, chain[i].hardening_xi);
      EXPECT_EQ(d.runup[i], r.runup);
      EXPECT_EQ(d.pressure_height[i], r.pressure_height);
    }
  }
  EXPECT_EQ(chain[0].hardening_xi, 5.0);
  EXPECT_EQ(chain[0].critical_state_slope, 0.0);
  EXPECT_EQ(chain[3].hardening_xi, 0.5);
}

TEST(Envelopes, AreTheLowestAndHighestOfTheRunsThatReachSoFar) {
  const testing::TemporaryDirectory directory;
  const auto with_series = [&](const char* name, const std::string& rows) {
    std::filesystem::create_directory(directory / name);
    std::ofstream(directory / name / "series.csv") << "time_s,runup_m,pressure_height_m\n" << rows;
    StudyRun r = run(1.0, 0.4, 0.0, 5.0);
    r.flow_height = r.obstacle_width = 2.0;
    r.folder = directory / name;
    return r;
  };
  std::vector<StudyRun> runs{with_series("a", "0,2,nan\n1,4,2\n2,6,3\n3,8,4\n"), with_series("b", "0,6,2\n2,10,6\n"),
                             run(1.0, 0.4, 0.0, 5.0)};
  runs.push_back(with_series("c", "0,100,100\n"));
  runs.back().froude = 5.0;
  const Envelope e = envelope(runs, 1.0);
  EXPECT_EQ(e.runs, 2u);
  ASSERT_EQ(e.points.size(), 4u);
  EXPECT_EQ(e.points[0].runup_low, 1.0);
  EXPECT_EQ(e.points[0].runup_high, 3.0);
  EXPECT_EQ(e.points[0].pressure_low, 1.0);  // undefined in the other run
  EXPECT_EQ(e.points[1].runup_high, 4.0);    // between the samples of b
  EXPECT_EQ(e.points[1].pressure_low, 1.0);
  EXPECT_EQ(e.points[1].pressure_high, 2.0);
  EXPECT_EQ(e.points[2].runs, 2u);
  EXPECT_EQ(e.points[3].runs, 1u);
  EXPECT_EQ(e.points[3].runup_low, 4.0);
  EXPECT_TRUE(envelope(runs, 0.1).points.empty());
}

TEST(HeightChoices, TakeTheSteadySpanTheLastThirdAndThePeakOfTheSameRuns) {
  const testing::TemporaryDirectory directory;
  std::ofstream(directory / "series.csv") << "time_s,runup_m,pressure_height_m\n0,2,nan\n1,9,2\n2,4,3\n3,4,nan\n4,6,3\n5,5,4\n6,7,5\n";
  StudyRun with = run(1.0, 0.4, 0.0, 5.0);
  with.flow_height = with.obstacle_width = 2.0;
  with.folder = directory.path();
  with.runup_peak = 4.5;
  with.pressure_height_peak = 2.5;
  const std::vector<StudyRun> runs{with, run(1.0, 0.8, 0.0, 5.0)};
  const auto choices = height_choices(runs);
  ASSERT_EQ(choices.size(), 3u);
  for (const HeightChoice& c : choices) EXPECT_EQ(c.runs.size(), 1u) << c.name;
  EXPECT_EQ(choices[0].runs[0].runup, with.runup);
  EXPECT_EQ(choices[1].name, "last third");
  EXPECT_EQ(choices[1].runs[0].runup, 3.0);  // samples at 4, 5 and 6 s, over H = 2 m
  EXPECT_EQ(choices[1].runs[0].pressure_height, 2.0);
  EXPECT_EQ(choices[2].runs[0].runup, 4.5);
  EXPECT_EQ(choices[2].runs[0].pressure_height, 2.5);
  EXPECT_TRUE(height_choices(std::span(runs).subspan(1)).empty());
}

TEST(Spreads, AreTheExtremesOfTheSteadyMeans) {
  std::vector<StudyRun> runs{run(1.0, 0.4, 0.0, 5.0), run(1.0, 0.8, 0.0, 5.0), run(1.0, 1.2, 0.0, 5.0), run(3.0, 0.4, 0.0, 5.0)};
  runs[0].runup = 2.0;
  runs[1].runup = 5.0;
  runs[1].pressure_height = std::nan("");
  runs[2].runup = 9.0;
  runs[2].obstacle_width = 3.5;  // another width
  const auto s = spreads(runs);
  ASSERT_EQ(s.size(), 2u);
  EXPECT_EQ(s[0].runs, 2u);
  EXPECT_EQ(s[0].runup_low, 2.0);
  EXPECT_EQ(s[0].runup_high, 5.0);
  EXPECT_EQ(s[0].pressure_low, runs[0].pressure_height);
  EXPECT_EQ(s[0].pressure_high, runs[0].pressure_height);
}

TEST(WidthFactors, AreRatiosToTheRunOfReferenceWidth) {
  std::vector<StudyRun> runs{run(3.0, 0.5, 0.15, 0.5), run(3.0, 0.5, 0.15, 0.5), run(5.0, 0.5, 0.15, 0.5)};
  EXPECT_TRUE(width_factors(runs).empty());
  runs[1].obstacle_width = 3.5;
  runs[1].runup = 1.1 * runs[0].runup;
  runs[1].runup_error = 0.03 * runs[1].runup;
  runs[0].runup_error = 0.04 * runs[0].runup;
  const auto factors = width_factors(runs);
  ASSERT_EQ(factors.size(), 2u);  // Fr = 5 has one width only
  EXPECT_EQ(factors[0].runup, 1.0);
  EXPECT_EQ(factors[0].runup_error, 0.0);
  EXPECT_NEAR(factors[1].runup, 1.1, 1e-14);
  EXPECT_NEAR(factors[1].runup_error, 1.1 * 0.05, 1e-14);
  EXPECT_EQ(factors[1].relative_width, 2.0);
  EXPECT_EQ(factors[1].guideline, rescaled_width_factor(2.0));
}

TEST(Compaction, HeadBehindAShockObeysTheJumpConditions) {
  EXPECT_EQ(head_behind_shock(1.0), 1.0);
  const double density = 300.0, v = 12.0;
  for (const double chi : {1.05, 1.5, 2.0, 4.0}) {
    const double behind = v / chi, pressure = density * v * v - chi * density * behind * behind;  // mass; momentum
    EXPECT_NEAR(head_behind_shock(chi), (pressure / (chi * density) + 0.5 * behind * behind) / (0.5 * v * v), 1e-14);
    EXPECT_NEAR(1.0 - head_behind_shock(chi), 0.5 * pressure * (1.0 - 1.0 / chi) / density / (0.5 * v * v), 1e-14);  // the plastic work
  }
}

TEST(Compaction, ComparesWithTheLeastCompressibleSnowOfTheSameFlowAndStrength) {
  const auto with = [](double froude, double slope, double beta, double xi, double chi, double share) {
    StudyRun r = run(froude, slope, beta, xi);
    r.compaction = chi;
    r.runup = 1.0 + share * 0.5 * froude * froude;
    return r;
  };
  std::vector<StudyRun> runs{
      with(5.0, 0.0, 0.0, 5.0, 1.1, head_behind_shock(1.1)),
      with(5.0, 0.0, 0.0, 0.05, 3.0, head_behind_shock(3.0)),
      with(5.0, 0.0, 0.0, 0.5, 1.4, head_behind_shock(1.4)),
      with(7.0, 0.8, 0.3, 5.0, 1.2, 0.4),
      with(7.0, 0.8, 0.3, 0.5, 2.0, 0.2),
      with(2.0, 0.8, 0.3, 5.0, 1.0, 0.4),
      with(2.0, 0.8, 0.3, 0.5, 1.0, 0.1),  // slow: in the table, not in the summary
      with(3.0, 0.8, 0.0, 0.5, 1.3, 0.4),  // alone
      with(5.0, 0.0, 0.0, 0.15, std::nan(""), 0.4),
  };
  runs.push_back(with(5.0, 0.0, 0.0, 15.0, 1.0, 9.0));
  runs.back().obstacle_width = 3.5;
  const auto losses = compaction_losses(runs);
  ASSERT_EQ(losses.size(), 4u);
  EXPECT_EQ(losses[0].hardening_xi, 0.05);
  EXPECT_EQ(losses[0].stiff_compaction, 1.1);
  EXPECT_NEAR(losses[0].head.value, head_behind_shock(3.0) / head_behind_shock(1.1), 1e-14);
  EXPECT_NEAR(losses[0].behind_shock, losses[0].head.value, 1e-14);
  const double low = losses[0].head.value * 12.5 * head_behind_shock(1.1), high = 12.5 * head_behind_shock(1.1);
  EXPECT_NEAR(losses[0].head.standard_error, losses[0].head.value * std::hypot(0.02 / low, 0.02 / high), 1e-14);
  EXPECT_NEAR(losses[2].head.value, 0.5, 1e-14);
  const auto summary = summarise(losses);
  ASSERT_EQ(summary.size(), 2u);
  EXPECT_FALSE(summary[0].cohesive);
  EXPECT_EQ(summary[0].runs, 2u);
  EXPECT_NEAR(summary[0].rms, 0.0, 1e-14);
  EXPECT_EQ(summary[1].runs, 1u);
  EXPECT_NEAR(summary[1].mean_head, 0.5, 1e-14);
  EXPECT_NEAR(summary[1].rms, std::abs(0.5 - head_behind_shock(2.0) / head_behind_shock(1.2)), 1e-14);
}

}  // namespace
}  // namespace mpm
