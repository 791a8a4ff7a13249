/// `mpm fit`: the paper's two regressions over a table of runs, in the layout of its Tables A1 and A2.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "commands.hpp"
#include "study_arguments.hpp"

namespace mpm::app {

namespace {

struct FitArguments {
  StudyArguments input;
  bool breakdown = false, json = false;
  std::string csv;
};

std::string short_number(double x, int digits = 4) { return std::isnan(x) ? "-" : fmt::format("{:.{}f}", x, digits); }

void print_coefficients(const SetFit& s) {
  const HeightFit& f = *s.fit;
  const PublishedFit p = published_fit(s.equation);
  fmt::print("  {:<12} {:>9} {:>16} {:>12} {:>9}   {:>9} {:>16} {:>11}\n", "parameter", "value", "rel. std. error", "t-statistic",
             "p-value", "published", "rel. std. error", "difference");
  const auto line = [](const char* name, const Coefficient& e, const PublishedEstimate& published) {
    fmt::print("  {:<12} {:>9} {:>16} {:>12} {:>9}   {:>9} {:>16} {:>10.1f}%\n", name, short_number(e.value),
               short_number(e.relative_error()), short_number(e.t_statistic, 3),
               std::isnan(e.p_value) ? "-" : fmt::format("{:.1e}", e.p_value), short_number(published.value),
               short_number(published.relative_error), 100.0 * (e.value / published.value - 1.0));
  };
  const bool runup = s.equation == HeightEquation::runup;
  line(runup ? "k_r (-)" : "k_p (-)", f.k, p.k);
  if (!runup) line("Fr_sat (-)", f.saturation_froude, p.saturation_froude);
  line(runup ? "kappa_r (-)" : "kappa_p (-)", f.kappa, p.kappa);
  if (!runup)
    fmt::print("  Fr_sat, interval of 95 % by the profile of the sum of squares: {:.3f} to {:.3f}\n", f.saturation_from, f.saturation_to);
  for (const std::string& caution : f.cautions) fmt::print("  note: {}\n", caution);
}

void print_scores(const SetFit& s) {
  const Scores *ours = s.whole(false), *theirs = s.whole(true);
  if (theirs == nullptr) return;
  const Scores paper = published_fit(s.equation).scores;
  fmt::print("  {:<10} {:>22} {:>22} {:>24}\n", "metric", "our data, our fit", "our data, published", "published on its own data");
  const auto line = [&](const char* name, double Scores::*member, bool percent) {
    const auto text = [&](double x) {
      return std::isnan(x) ? std::string("-") : percent ? fmt::format("{:.1f} %", 100.0 * x) : fmt::format("{:.3f}", x);
    };
    fmt::print("  {:<10} {:>22} {:>22} {:>24}\n", name, ours != nullptr ? text(ours->*member) : "-", text(theirs->*member),
               text(paper.*member));
  };
  line("R2", &Scores::r2, false);
  line("R2_log", &Scores::r2_log, false);
  line("NRMSE", &Scores::nrmse, false);
  line("RMSLE", &Scores::rmsle, false);
  line("Bias_x", &Scores::bias, false);
  line("Frac_10", &Scores::fraction_10, true);
  line("Frac_25", &Scores::fraction_25, true);
}

/// RMSLE or NRMSE of both sets of coefficients, by each input.
void print_breakdown(const SetFit& s) {
  const bool runup = s.equation == HeightEquation::runup;
  const auto score = [&](const Scores& scores) { return runup ? scores.rmsle : scores.nrmse; };
  fmt::print("  {} by input{:>28} {:>10} {:>6} {:>10} {:>10}\n", runup ? "RMSLE" : "NRMSE", "input", "value", "runs", "our fit",
             "published");
  for (const ScoreRow& theirs : s.scores) {
    if (!theirs.published || theirs.group.empty()) continue;
    const auto ours = std::ranges::find_if(
        s.scores, [&](const ScoreRow& r) { return !r.published && r.xi == theirs.xi && r.group == theirs.group && r.at == theirs.at; });
    const std::string which = theirs.xi ? fmt::format("xi = {:g}", *theirs.xi) : "set";
    fmt::print("  {:<16}{:>28} {:>10.4g} {:>6} {:>9}% {:>9.1f}%\n", which, theirs.group, theirs.at, theirs.runs,
               ours == s.scores.end() ? "-" : fmt::format("{:.1f}", 100.0 * score(ours->scores)), 100.0 * score(theirs.scores));
  }
}

void print_fit(const SetFit& s, bool breakdown) {
  const bool runup = s.equation == HeightEquation::runup;
  fmt::print("\n{}\n  set '{}': {}; {} runs{}{}\n",
             runup ? "Run-up height, h_r/H = 1 + k_r M' + Fr^2/2 exp(-kappa_r M'), residuals of log(h_r)"
                   : "Pressure height, h_p/H = 1 + k_p M' + min(Fr, Fr_sat)^2/2 exp(-kappa_p M'), residuals of h_p/H",
             s.set.name, s.set.description, s.runs,
             s.other_width > 0 ? fmt::format("; left out: {} of another width than H", s.other_width) : "",
             s.without_height > 0 ? fmt::format("; left out: {} without a steady pressure height", s.without_height) : "");
  if (s.fit) {
    print_coefficients(s);
  } else {
    fmt::print("  not fitted: {}\n", s.why_not);
  }
  print_scores(s);
  if (breakdown) print_breakdown(s);
}

void fit(const FitArguments& arguments) {
  const StudyTable table = read_study(arguments.input);
  const std::vector<SetFit> fits = fit_paper_sets(table);
  if (std::ranges::none_of(fits, [](const SetFit& s) { return s.fit.has_value(); })) throw ConfigError(fits.front().why_not);
  for (const std::string& caution : table.cautions) fmt::print(stderr, "note: {}\n", caution);
  if (arguments.json) {
    fmt::print("{}", fits_json(fits, table));
  } else if (arguments.csv == "coefficients") {
    fmt::print("{}", coefficients_csv(fits));
  } else if (arguments.csv == "scores") {
    fmt::print("{}", scores_csv(fits));
  } else {
    fmt::print("{} rows, {} runs with a steady run-up\n", table.rows, table.runs.size());
    for (const auto& [reason, rows] : table.left_out) fmt::print("  left out: {} ({})\n", rows, reason);
    for (const SetFit& s : fits) print_fit(s, arguments.breakdown);
  }
}

}  // namespace

void add_fit(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "fit",
      "The paper's regressions of run-up and pressure height (Eqs. 7-10) over a table of runs: coefficients with standard errors, t and p, "
      "and all scores, for both fitting sets of the paper, beside its published coefficients");
  const auto a = std::make_shared<FitArguments>();
  add_study_arguments(*command, a->input);
  command->add_flag("--breakdown", a->breakdown, "Errors by Froude number, M' and xi, too");
  CLI::Option* json = command->add_flag("--json", a->json, "Everything as JSON");
  command->add_option("--csv", a->csv, "One table as CSV: coefficients, or scores with all their groups")
      ->check(CLI::IsMember({"coefficients", "scores"}))
      ->excludes(json);
  command->callback([a] { fit(*a); });
}

}  // namespace mpm::app
