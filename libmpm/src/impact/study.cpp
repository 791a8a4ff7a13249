#include "mpm/impact/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "mpm/build_info.hpp"
#include "mpm/error.hpp"
#include "mpm/impact/steady.hpp"
#include "mpm/io/table.hpp"

namespace mpm {
namespace {

constexpr double none = Coefficient::none;

double height_of(HeightEquation equation, const StudyRun& run) {
  return equation == HeightEquation::runup ? run.runup : run.pressure_height;
}

/// Values of an input over the runs, rising, each once.
template <class Projection>
std::vector<double> distinct(std::span<const StudyRun> runs, Projection input) {
  std::vector<double> values;
  for (const StudyRun& run : runs) values.push_back(std::invoke(input, run));
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end(), same_input), values.end());
  return values;
}

template <class Predicate>
std::vector<StudyRun> those(std::span<const StudyRun> runs, Predicate wanted) {
  std::vector<StudyRun> kept;
  std::ranges::copy_if(runs, std::back_inserter(kept), wanted);
  return kept;
}

void add_scores(std::vector<ScoreRow>& rows, HeightEquation equation, std::span<const StudyRun> runs,
                const HeightCoefficients& coefficients, bool published, std::optional<double> xi) {
  const auto samples = height_samples(equation, runs);
  if (samples.empty()) return;
  std::vector<double> simulated, predicted, froude, friction;
  for (const HeightSample& s : samples) {
    simulated.push_back(s.relative_height);
    predicted.push_back(relative_height(s, coefficients));
    froude.push_back(s.froude);
    friction.push_back(s.effective_friction);
  }
  rows.push_back({published, xi, "", none, samples.size(), compute_scores(simulated, predicted)});
  const auto add_groups = [&](const char* group, const std::vector<double>& keys) {
    for (const GroupScores& g : scores_by_group(keys, simulated, predicted)) rows.push_back({published, xi, group, g.at, g.rows, g.scores});
  };
  add_groups("froude_number", froude);
  add_groups("effective_friction", friction);
  if (xi) return;
  for (const double value : distinct(runs, &StudyRun::hardening_xi)) {
    const auto of_xi = height_samples(equation, those(runs, [&](const StudyRun& r) { return same_input(r.hardening_xi, value); }));
    if (!of_xi.empty()) rows.push_back({published, {}, "hardening_xi", value, of_xi.size(), score_heights(of_xi, coefficients)});
  }
}

/// A row of the coefficients' table.
struct CoefficientRow {
  std::string name;
  Coefficient estimate;
  double from, to;  ///< interval of 95 %
  PublishedEstimate published;
};

std::vector<CoefficientRow> coefficient_rows(const SetFit& s) {
  if (!s.fit) return {};
  const PublishedFit published = published_fit(s.equation);
  const double t = two_sided_quantile(0.05, static_cast<double>(s.fit->degrees_of_freedom));
  const auto row = [&](std::string name, const Coefficient& e, const PublishedEstimate& p) {
    return CoefficientRow{std::move(name), e, e.value - t * e.standard_error, e.value + t * e.standard_error, p};
  };
  if (s.equation == HeightEquation::runup) return {row("k_r", s.fit->k, published.k), row("kappa_r", s.fit->kappa, published.kappa)};
  return {row("k_p", s.fit->k, published.k),
          {"Fr_sat", s.fit->saturation_froude, s.fit->saturation_from, s.fit->saturation_to, published.saturation_froude},
          row("kappa_p", s.fit->kappa, published.kappa)};
}

/// Cells without commas, numbers by format_number; an unknown number is left empty.
class CsvText {
 public:
  explicit CsvText(std::string header) : text_(std::move(header)) { text_ += '\n'; }
  CsvText& cell(std::string_view value) {
    if (!first_) text_ += ',';
    text_ += value;
    first_ = false;
    return *this;
  }
  CsvText& cell(double value) { return cell(std::isnan(value) ? std::string() : format_number(value)); }
  void end_row() {
    text_ += '\n';
    first_ = true;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
  bool first_ = true;
};

nlohmann::ordered_json scores_json(const Scores& s) {
  return {{"r2", s.r2},
          {"r2_log", s.r2_log},
          {"nrmse", s.nrmse},
          {"rmsle", s.rmsle},
          {"bias", s.bias},
          {"fraction_10", s.fraction_10},
          {"fraction_25", s.fraction_25}};
}

/// Vertex of the parabola through three points, the middle one lowest. @param x rising
double vertex(const std::array<double, 3>& x, const std::array<double, 3>& y) {
  const double left = (y[1] - y[0]) / (x[1] - x[0]), right = (y[2] - y[1]) / (x[2] - x[1]);
  const double curvature = (right - left) / (x[2] - x[0]);
  return curvature > 0.0 ? 0.5 * (x[0] + x[1] - left / curvature) : x[1];
}

GuidelineMinimum lowest(std::span<const GuidelineDeviation> curve, double published_from, double published_to) {
  const auto best = std::ranges::min_element(curve, {}, &GuidelineDeviation::rmsle);
  GuidelineMinimum m{best->lambda, best->xi, best->effective_friction, none, none, none, best->rmsle, published_from, published_to, false};
  if (best != curve.begin()) m.below = (best - 1)->effective_friction;
  if (best + 1 != curve.end()) m.above = (best + 1)->effective_friction;
  if (std::isfinite(m.below) && std::isfinite(m.above)) {
    m.parabola = vertex({m.below, m.at, m.above}, {(best - 1)->rmsle, best->rmsle, (best + 1)->rmsle});
  }
  m.inside = m.parabola >= published_from && m.parabola <= published_to;  // false for NaN: no minimum was located
  return m;
}

/// Mean height of the runs with this rheology and Froude number: one, unless the table repeats it.
double mean_height(HeightEquation equation, std::span<const StudyRun> runs, double froude, const Rheology& rheology) {
  double sum = 0.0, count = 0.0;
  for (const StudyRun& r : runs) {
    if (!r.reference_width() || !same_input(r.froude, froude) || !same_input(r.critical_state_slope, rheology.critical_state_slope) ||
        !same_input(r.cohesion_beta, rheology.cohesion_beta) || !same_input(r.hardening_xi, rheology.hardening_xi)) {
      continue;
    }
    if (const double h = height_of(equation, r); std::isfinite(h)) {
      sum += h;
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : none;
}

bool same_flow_and_strength(const StudyRun& a, const StudyRun& b) {
  return same_input(a.froude, b.froude) && same_input(a.critical_state_slope, b.critical_state_slope) &&
         same_input(a.cohesion_beta, b.cohesion_beta);
}

/// Heights over H.
struct Series {
  std::vector<double> time, runup, pressure_height;
};

/// Nothing where the run's folder holds none.
std::optional<Series> series_of(const StudyRun& run) {
  const auto file = run.folder / "series.csv";
  if (run.folder.empty() || !std::filesystem::exists(file)) return {};
  const Table table = Table::read(file, Table::LastLine::may_be_torn);
  Series s{table.numbers("time_s"), table.numbers("runup_m"), table.numbers("pressure_height_m")};
  if (s.time.empty()) return {};
  for (double& h : s.runup) h /= run.flow_height;
  for (double& h : s.pressure_height) h /= run.flow_height;
  return s;
}

/// Linear between samples; NaN outside them. @param at rising from call to call, from: where to go on searching
double interpolate(const std::vector<double>& time, const std::vector<double>& value, double at, std::size_t& from) {
  if (time.empty() || at < time.front() || at > time.back()) return none;
  while (from + 1 < time.size() && time[from + 1] < at) ++from;
  if (from + 1 >= time.size()) return value[from];
  const double share = (at - time[from]) / (time[from + 1] - time[from]);
  if (share <= 0.0) return value[from];  // on a sample: its neighbour may be undefined
  if (share >= 1.0) return value[from + 1];
  return (1.0 - share) * value[from] + share * value[from + 1];
}

}  // namespace

std::string_view to_string(HeightEquation equation) { return equation == HeightEquation::runup ? "runup" : "pressure_height"; }

bool FittingSet::holds(const StudyRun& run) const {
  const bool named = std::ranges::any_of(xi, [&](double value) { return same_input(value, run.hardening_xi); });
  return named == only;
}

std::vector<FittingSet> paper_fitting_sets() {
  return {{"narrow", "xi in {0.5, 1.5, 5} (note of Table 1)", {0.5, 1.5, 5.0}, true},
          {"wide", "everything but xi = 0.05 (Sect. 4.1)", {0.05}, false}};
}

std::vector<HeightSample> height_samples(HeightEquation equation, std::span<const StudyRun> runs) {
  std::vector<HeightSample> samples;
  for (const StudyRun& r : runs) {
    const double height = height_of(equation, r);
    if (std::isfinite(height) && r.reference_width()) samples.push_back({r.effective_friction, r.froude, height});
  }
  return samples;
}

SetFit fit_set(HeightEquation equation, const FittingSet& set, std::span<const StudyRun> runs) {
  SetFit result{.equation = equation, .set = set};
  const auto members = those(runs, [&](const StudyRun& r) { return set.holds(r); });
  for (const StudyRun& r : members) {
    if (!r.reference_width()) {
      ++result.other_width;
    } else if (!std::isfinite(height_of(equation, r))) {
      ++result.without_height;
    }
  }
  const auto samples = height_samples(equation, members);
  result.runs = samples.size();
  try {
    result.fit = fit_heights(equation, samples);
  } catch (const ConfigError& error) {
    result.why_not = error.what();
  }
  const auto add_all = [&](const HeightCoefficients& coefficients, bool published) {
    add_scores(result.scores, equation, members, coefficients, published, {});
    for (const double xi : distinct(runs, &StudyRun::hardening_xi)) {
      const auto of_xi = those(runs, [&](const StudyRun& r) { return same_input(r.hardening_xi, xi); });
      add_scores(result.scores, equation, of_xi, coefficients, published, xi);
    }
  };
  if (result.fit) add_all(result.fit->coefficients, false);
  add_all(published_fit(equation).coefficients, true);
  return result;
}

const Scores* SetFit::whole(bool published) const {
  const auto row = std::ranges::find_if(scores, [&](const ScoreRow& r) { return r.published == published && !r.xi && r.group.empty(); });
  return row != scores.end() ? &row->scores : nullptr;
}

std::string coefficients_csv(std::span<const SetFit> fits) {
  CsvText csv(
      "equation,fitting_set,parameter,value,standard_error,relative_standard_error,t_statistic,p_value,interval_from,interval_to,published,"
      "published_relative_standard_error,published_t_statistic,relative_difference");
  for (const SetFit& s : fits) {
    for (const CoefficientRow& r : coefficient_rows(s)) {
      csv.cell(to_string(s.equation)).cell(s.set.name).cell(r.name).cell(r.estimate.value).cell(r.estimate.standard_error);
      csv.cell(r.estimate.relative_error()).cell(r.estimate.t_statistic).cell(r.estimate.p_value).cell(r.from).cell(r.to);
      csv.cell(r.published.value).cell(r.published.relative_error).cell(r.published.t_statistic);
      csv.cell(r.estimate.value / r.published.value - 1.0).end_row();
    }
  }
  return csv.text();
}

std::string scores_csv(std::span<const SetFit> fits) {
  CsvText csv("equation,fitting_set,coefficients,hardening_xi,group,at,runs,r2,r2_log,nrmse,rmsle,bias,fraction_10,fraction_25");
  for (const SetFit& s : fits) {
    for (const ScoreRow& r : s.scores) {
      csv.cell(to_string(s.equation)).cell(s.set.name).cell(r.published ? "published" : "fitted").cell(r.xi.value_or(none)).cell(r.group);
      csv.cell(r.at).cell(static_cast<double>(r.runs)).cell(r.scores.r2).cell(r.scores.r2_log).cell(r.scores.nrmse).cell(r.scores.rmsle);
      csv.cell(r.scores.bias).cell(r.scores.fraction_10).cell(r.scores.fraction_25).end_row();
    }
  }
  return csv.text();
}

std::string fits_json(std::span<const SetFit> fits, const StudyTable& table) {
  nlohmann::ordered_json json;
  const BuildInfo build = build_info();
  json["evaluated_by"] = fmt::format("version {}, commit {}", build.version, build.commit);
  json["files"] = table.files;
  json["rows"] = table.rows;
  json["runs"] = table.runs.size();
  json["left_out"] = nlohmann::ordered_json::array();
  for (const auto& [reason, rows] : table.left_out) json["left_out"].push_back({{"reason", reason}, {"rows", rows}});
  json["cautions"] = table.cautions;
  json["provenance"] = table.provenance;
  json["fits"] = nlohmann::ordered_json::array();
  for (const SetFit& s : fits) {
    nlohmann::ordered_json f{{"equation", to_string(s.equation)},
                             {"fitting_set", s.set.name},
                             {"fitting_set_description", s.set.description},
                             {"runs", s.runs},
                             {"without_height", s.without_height},
                             {"other_width", s.other_width},
                             {"why_not", s.why_not}};
    f["coefficients"] = nlohmann::ordered_json::array();
    for (const CoefficientRow& r : coefficient_rows(s)) {
      f["coefficients"].push_back({{"parameter", r.name},
                                   {"value", r.estimate.value},
                                   {"standard_error", r.estimate.standard_error},
                                   {"relative_standard_error", r.estimate.relative_error()},
                                   {"t_statistic", r.estimate.t_statistic},
                                   {"p_value", r.estimate.p_value},
                                   {"interval", {r.from, r.to}},
                                   {"published", r.published.value},
                                   {"published_relative_standard_error", r.published.relative_error},
                                   {"published_t_statistic", r.published.t_statistic},
                                   {"relative_difference", r.estimate.value / r.published.value - 1.0}});
    }
    f["cautions"] = s.fit ? s.fit->cautions : std::vector<std::string>{};
    f["published_scores_on_its_own_data"] = scores_json(published_fit(s.equation).scores);
    for (const ScoreRow& r : s.scores) {
      if (!r.xi && r.group.empty()) f[r.published ? "scores_of_published" : "scores_of_fitted"] = scores_json(r.scores);
    }
    if (s.fit) {
      f["saturation_profile"] = nlohmann::ordered_json::array();
      for (const ProfilePoint& p : s.fit->saturation_profile) f["saturation_profile"].push_back({p.saturation_froude, p.sum_of_squares});
    }
    json["fits"].push_back(std::move(f));
  }
  json["aims"] = nlohmann::ordered_json::array();
  for (const FittingSet& set : paper_fitting_sets()) {
    std::vector<SetFit> of_set;
    std::ranges::copy_if(fits, std::back_inserter(of_set), [&](const SetFit& s) { return s.set.name == set.name; });
    for (const Aim& a : paper_aims(of_set)) {
      json["aims"].push_back({{"fitting_set", set.name}, {"what", a.what}, {"aim", a.aim}, {"value", a.value}, {"met", a.met}});
    }
  }
  return json.dump(1) + "\n";
}

std::vector<Aim> paper_aims(std::span<const SetFit> fits) {
  constexpr double largest_rmsle = 0.15, largest_nrmse = 0.10, smallest_share = 0.90, coefficient_band = 0.15;
  std::vector<Aim> aims;
  for (const SetFit& s : fits) {
    const bool runup = s.equation == HeightEquation::runup;
    const std::string height = runup ? "run-up" : "pressure height";
    if (const Scores* total = s.whole(true)) {
      const double error = runup ? total->rmsle : total->nrmse, limit = runup ? largest_rmsle : largest_nrmse;
      aims.push_back({fmt::format("{}: {} against the published equation", height, runup ? "RMSLE" : "NRMSE"),
                      fmt::format("<= {:.0f} %", 100.0 * limit), error, error <= limit});
      aims.push_back({height + ": runs within 25 % of the published equation", fmt::format(">= {:.0f} %", 100.0 * smallest_share),
                      total->fraction_25, total->fraction_25 >= smallest_share});
    }
    for (const CoefficientRow& r : coefficient_rows(s)) {
      const double difference = r.estimate.value / r.published.value - 1.0;
      aims.push_back({fmt::format("{}: {} against the published value", height, r.name),
                      fmt::format("within {:.0f} %", 100.0 * coefficient_band), difference, std::abs(difference) <= coefficient_band});
    }
  }
  return aims;
}

std::vector<Spread> spreads(std::span<const StudyRun> runs) {
  std::vector<Spread> result;
  for (const double froude : distinct(runs, &StudyRun::froude)) {
    Spread s{froude, 0, none, none, none, none};
    for (const StudyRun& r : runs) {
      if (!r.reference_width() || !same_input(r.froude, froude)) continue;
      ++s.runs;
      s.runup_low = std::fmin(s.runup_low, r.runup);  // fmin and fmax leave out NaN
      s.runup_high = std::fmax(s.runup_high, r.runup);
      s.pressure_low = std::fmin(s.pressure_low, r.pressure_height);
      s.pressure_high = std::fmax(s.pressure_high, r.pressure_height);
    }
    if (s.runs > 0) result.push_back(s);
  }
  return result;
}

GuidelineCorrespondence guideline_correspondence(std::span<const StudyRun> runs) {
  constexpr double slowest = 3.0, fastest = 7.0;
  struct Published {
    double lambda, from, to;
  };
  constexpr std::array published{Published{guideline_lambda_loose, 0.45, 0.65}, Published{guideline_lambda_dense, 1.0, 1.5}};
  GuidelineCorrespondence result;
  const auto fast =
      those(runs, [](const StudyRun& r) { return r.reference_width() && r.froude >= slowest - 1e-6 && r.froude <= fastest + 1e-6; });
  if (fast.empty()) result.notes.emplace_back("no run with 3 <= Fr <= 7 and w = H");
  for (const double xi : distinct(fast, &StudyRun::hardening_xi)) {
    const auto of_xi = those(fast, [&](const StudyRun& r) { return same_input(r.hardening_xi, xi); });
    const std::size_t froudes = distinct(of_xi, &StudyRun::froude).size();
    std::vector<std::vector<StudyRun>> curves;
    std::size_t incomplete = 0;
    for (const double friction : distinct(of_xi, &StudyRun::effective_friction)) {
      auto group = those(of_xi, [&](const StudyRun& r) { return same_input(r.effective_friction, friction); });
      if (distinct(group, &StudyRun::froude).size() == froudes) {
        curves.push_back(std::move(group));
      } else {
        ++incomplete;
      }
    }
    if (incomplete > 0) {
      result.notes.push_back(fmt::format("xi = {}: {} values of M' lack a run at one of the {} Froude numbers and are left out",
                                         format_number(xi), incomplete, froudes));
    }
    if (curves.size() < 3) {
      result.notes.push_back(
          fmt::format("xi = {}: {} values of M' with all Froude numbers; a curve needs three", format_number(xi), curves.size()));
      continue;
    }
    for (const Published& p : published) {
      std::vector<GuidelineDeviation> curve;
      for (const auto& group : curves) {
        std::vector<double> simulated, predicted;
        for (const StudyRun& r : group) {
          simulated.push_back(r.runup * r.flow_height);
          predicted.push_back(r.flow_height + guideline_runup(r.velocity, p.lambda, width_factor(r.relative_width()), r.gravity));
        }
        curve.push_back({p.lambda, xi, group.front().effective_friction, group.size(), compute_scores(simulated, predicted).rmsle, 0.0});
      }
      const auto [low, high] = std::ranges::minmax_element(curve, {}, &GuidelineDeviation::rmsle);
      const double smallest = low->rmsle, range = high->rmsle - smallest;
      for (GuidelineDeviation& d : curve) d.normalised = (d.rmsle - smallest) / range;
      result.minima.push_back(lowest(curve, p.from, p.to));
      result.deviations.insert(result.deviations.end(), curve.begin(), curve.end());
    }
  }
  return result;
}

std::vector<Rheology> decomposition_chain(const Rheology& last) {
  constexpr double incompressible_xi = 5.0;
  return {{0.0, 0.0, incompressible_xi},
          {last.critical_state_slope, 0.0, incompressible_xi},
          {last.critical_state_slope, last.cohesion_beta, incompressible_xi},
          last};
}

std::vector<Decomposition> decompose(std::span<const StudyRun> runs, std::span<const Rheology> chain) {
  std::vector<Decomposition> result;
  for (const double froude : distinct(runs, &StudyRun::froude)) {
    Decomposition d{froude, bernoulli_height(froude, 1.0, 1.0), {}, {}};
    for (const Rheology& r : chain) {
      d.runup.push_back(mean_height(HeightEquation::runup, runs, froude, r));
      d.pressure_height.push_back(mean_height(HeightEquation::pressure_height, runs, froude, r));
    }
    result.push_back(std::move(d));
  }
  return result;
}

Envelope envelope(std::span<const StudyRun> runs, double froude) {
  Envelope result{.froude = froude};
  std::vector<Series> all;
  for (const StudyRun& r : runs) {
    if (!r.reference_width() || !same_input(r.froude, froude)) continue;
    if (auto series = series_of(r)) all.push_back(std::move(*series));
  }
  result.runs = all.size();
  if (all.empty()) return result;
  const std::vector<double> times = std::ranges::max_element(all, {}, [](const Series& s) { return s.time.back(); })->time;
  std::vector<std::size_t> runup_from(all.size(), 0), pressure_from(all.size(), 0);
  for (const double t : times) {
    EnvelopePoint p{t, 0, none, none, none, none};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double runup = interpolate(all[i].time, all[i].runup, t, runup_from[i]);
      const double pressure = interpolate(all[i].time, all[i].pressure_height, t, pressure_from[i]);
      if (std::isnan(runup)) continue;
      ++p.runs;
      p.runup_low = std::fmin(p.runup_low, runup);  // fmin and fmax leave out NaN
      p.runup_high = std::fmax(p.runup_high, runup);
      p.pressure_low = std::fmin(p.pressure_low, pressure);
      p.pressure_high = std::fmax(p.pressure_high, pressure);
    }
    result.points.push_back(p);
  }
  return result;
}

std::vector<HeightChoice> height_choices(std::span<const StudyRun> runs) {
  HeightChoice steady{"steady span", {}}, late{"last third", {}}, peak{"peak", {}};
  for (const StudyRun& r : runs) {
    const auto series = series_of(r);
    if (!series) continue;
    const double from = series->time.back() - (series->time.back() - series->time.front()) / 3.0;
    const auto first = static_cast<std::size_t>(std::ranges::lower_bound(series->time, from) - series->time.begin());
    const MeanEstimate runup = estimate_mean(std::span(series->runup).subspan(first));
    const MeanEstimate pressure = estimate_mean(std::span(series->pressure_height).subspan(first));
    steady.runs.push_back(r);
    StudyRun other = r;
    other.runup = runup.mean, other.runup_error = runup.standard_error;
    other.pressure_height = pressure.mean, other.pressure_height_error = pressure.standard_error;
    late.runs.push_back(other);
    other.runup = r.runup_peak, other.runup_error = none;
    other.pressure_height = r.pressure_height_peak, other.pressure_height_error = none;
    peak.runs.push_back(other);
  }
  if (steady.runs.empty()) return {};
  return {steady, late, peak};
}

std::vector<WidthFactor> width_factors(std::span<const StudyRun> runs) {
  std::vector<WidthFactor> factors;
  if (distinct(runs, &StudyRun::relative_width).size() < 2) return factors;
  const auto same_but_width = [](const StudyRun& a, const StudyRun& b) {
    return same_flow_and_strength(a, b) && same_input(a.hardening_xi, b.hardening_xi);
  };
  for (const StudyRun& r : runs) {
    const auto reference = std::ranges::find_if(runs, [&](const StudyRun& c) { return c.reference_width() && same_but_width(c, r); });
    const bool alone = std::ranges::none_of(runs, [&](const StudyRun& c) { return !c.reference_width() && same_but_width(c, r); });
    if (reference == runs.end() || alone) continue;
    const MeanRatio f_r = ratio_of_means(r.runup, r.runup_error, reference->runup, reference->runup_error);
    const MeanRatio f_p =
        ratio_of_means(r.pressure_height, r.pressure_height_error, reference->pressure_height, reference->pressure_height_error);
    const bool itself = &r == &*reference;
    factors.push_back({r.critical_state_slope, r.cohesion_beta, r.effective_friction, r.hardening_xi, r.froude, r.relative_width(),
                       f_r.value, itself ? 0.0 : f_r.standard_error, f_p.value, itself ? 0.0 : f_p.standard_error,
                       rescaled_width_factor(r.relative_width())});
  }
  return factors;
}

double head_behind_shock(double density_ratio) { return (2.0 * density_ratio - 1.0) / (density_ratio * density_ratio); }

std::vector<CompactionLoss> compaction_losses(std::span<const StudyRun> runs) {
  const auto usable =
      those(runs, [](const StudyRun& r) { return r.reference_width() && std::isfinite(r.runup) && std::isfinite(r.compaction); });
  std::vector<CompactionLoss> losses;
  for (const StudyRun& r : usable) {
    const StudyRun* stiff = &r;
    for (const StudyRun& c : usable) {
      if (same_flow_and_strength(c, r) && c.hardening_xi > stiff->hardening_xi) stiff = &c;
    }
    if (same_input(stiff->hardening_xi, r.hardening_xi)) continue;
    losses.push_back({r.froude, r.critical_state_slope, r.cohesion_beta, r.effective_friction, r.hardening_xi, r.compaction,
                      stiff->compaction, ratio_of_means(r.runup - 1.0, r.runup_error, stiff->runup - 1.0, stiff->runup_error),
                      head_behind_shock(r.compaction) / head_behind_shock(stiff->compaction)});
  }
  return losses;
}

std::vector<CompactionSummary> summarise(std::span<const CompactionLoss> losses) {
  constexpr double inertial = 3.0;  // below, the run-up is a pile
  std::vector<CompactionSummary> summaries;
  for (const bool cohesive : {false, true}) {
    CompactionSummary s{cohesive, 0, 0.0, 0.0, 0.0};
    for (const CompactionLoss& l : losses) {
      if (l.froude < inertial * (1.0 - 1e-6) || (l.critical_state_slope * l.cohesion_beta > 0.0) != cohesive) continue;
      ++s.runs;
      s.mean_head += l.head.value;
      s.mean_behind_shock += l.behind_shock;
      s.rms += (l.head.value - l.behind_shock) * (l.head.value - l.behind_shock);
    }
    const auto count = static_cast<double>(s.runs);
    if (s.runs > 0) summaries.push_back({cohesive, s.runs, s.mean_head / count, s.mean_behind_shock / count, std::sqrt(s.rms / count)});
  }
  return summaries;
}

}  // namespace mpm
