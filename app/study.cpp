/// `mpm study`: the numbers behind every figure of the paper's study, from tables of runs. validation/study draws them.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "commands.hpp"
#include "mpm/impact/sensitivity.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/snapshot.hpp"
#include "mpm/io/table.hpp"
#include "study_arguments.hpp"

namespace mpm::app {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

struct StudyCommand {
  StudyArguments input;
  std::filesystem::path out;
  std::vector<std::filesystem::path> width, sections;
  std::filesystem::path sensitivity;  ///< empty: none
  std::vector<std::string> notes;
  std::vector<double> decomposition{0.8, 0.3, 0.5};  ///< M, beta, xi
};

/// A table that grows row by row, and is written whole.
class NumberTable {
 public:
  explicit NumberTable(std::vector<std::string> columns) : columns_(std::move(columns)), values_(columns_.size()) {}
  void add(const std::vector<double>& row) {
    for (std::size_t c = 0; c < values_.size(); ++c) values_[c].push_back(row.at(c));
  }
  void write(const std::filesystem::path& path) const { write_table(path, columns_, values_); }

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<double>> values_;
};

/// Coefficients of the `narrow` set, which the study takes for its own; NaN where it could not be fitted.
HeightCoefficients own_coefficients(const std::vector<SetFit>& fits, HeightEquation equation) {
  for (const SetFit& s : fits) {
    if (s.equation == equation && s.set.name == "narrow" && s.fit) return s.fit->coefficients;
  }
  return {none, none, none};
}

double height_or_none(const HeightSample& s, const HeightCoefficients& c) { return std::isnan(c.k) ? none : relative_height(s, c); }

void write_points(const std::filesystem::path& path, const StudyTable& table, const HeightCoefficients& runup,
                  const HeightCoefficients& pressure) {
  NumberTable points({"froude_number", "critical_state_slope", "cohesion_beta", "hardening_xi", "effective_friction", "relative_width",
                      "runup", "runup_standard_error", "runup_peak", "pressure_height", "pressure_height_standard_error",
                      "pressure_height_peak", "runup_fitted", "runup_published", "pressure_height_fitted", "pressure_height_published"});
  for (const StudyRun& r : table.runs) {
    const HeightSample s{r.effective_friction, r.froude, r.runup};
    points.add({r.froude, r.critical_state_slope, r.cohesion_beta, r.hardening_xi, r.effective_friction, r.relative_width(), r.runup,
                r.runup_error, r.runup_peak, r.pressure_height, r.pressure_height_error, r.pressure_height_peak, height_or_none(s, runup),
                relative_height(s, runup_coefficients), height_or_none(s, pressure), relative_height(s, pressure_height_coefficients)});
  }
  points.write(path);
}

/// Curves of the equations over M' for each Froude number of the table (Figs. A2, A4), and their factors (Fig. 8).
void write_curves(const std::filesystem::path& out, const StudyTable& table, const HeightCoefficients& runup,
                  const HeightCoefficients& pressure) {
  constexpr int steps = 120;
  constexpr double greatest = 2.4;  // M' of the paper's grid goes up to 2.30
  NumberTable curves(
      {"froude_number", "effective_friction", "runup_fitted", "runup_published", "pressure_height_fitted", "pressure_height_published"});
  NumberTable factors({"effective_friction", "zeta_r_fitted", "zeta_r_published", "zeta_p_fitted", "zeta_p_published", "lambda_r_fitted",
                       "lambda_r_published", "lambda_p_fitted", "lambda_p_published"});
  std::vector<double> froude;
  for (const StudyRun& r : table.runs) {
    if (std::ranges::none_of(froude, [&](double f) { return same_input(f, r.froude); })) froude.push_back(r.froude);
  }
  std::ranges::sort(froude);
  for (int i = 0; i <= steps; ++i) {
    const double friction = greatest * i / steps;
    for (const double f : froude) {
      const HeightSample s{friction, f, 1.0};
      curves.add({f, friction, height_or_none(s, runup), relative_height(s, runup_coefficients), height_or_none(s, pressure),
                  relative_height(s, pressure_height_coefficients)});
    }
    factors.add({friction, magnification_factor(friction, runup), magnification_factor(friction, runup_coefficients),
                 magnification_factor(friction, pressure), magnification_factor(friction, pressure_height_coefficients),
                 dissipation_factor(friction, runup), dissipation_factor(friction, runup_coefficients),
                 dissipation_factor(friction, pressure), dissipation_factor(friction, pressure_height_coefficients)});
  }
  curves.write(out / "height_curves.csv");
  factors.write(out / "factor_curves.csv");
}

/// M' and phi' over beta (Fig. 1).
void write_friction(const std::filesystem::path& path) {
  constexpr int steps = 90;
  NumberTable friction({"critical_state_slope", "cohesion_beta", "effective_friction", "friction_angle_deg"});
  for (const double slope : {0.0, 0.4, 0.8, 1.2}) {
    for (int i = 0; i <= steps; ++i) {
      const double beta = 0.45 * i / steps, value = effective_friction(slope, beta);
      friction.add({slope, beta, value, friction_angle(value) * 180.0 / std::numbers::pi});
    }
  }
  friction.write(path);
}

void write_envelopes(const std::filesystem::path& path, const StudyTable& table) {
  NumberTable envelopes(
      {"froude_number", "time_s", "runs", "all_runs", "runup_low", "runup_high", "pressure_height_low", "pressure_height_high"});
  for (const double froude : {0.1, 1.0, 5.0}) {
    const Envelope e = envelope(table.runs, froude);
    for (const EnvelopePoint& p : e.points) {
      envelopes.add({froude, p.time, static_cast<double>(p.runs), static_cast<double>(e.runs), p.runup_low, p.runup_high, p.pressure_low,
                     p.pressure_high});
    }
  }
  envelopes.write(path);
}

void write_guideline(const std::filesystem::path& out, const GuidelineCorrespondence& guideline) {
  NumberTable curves({"lambda", "hardening_xi", "effective_friction", "runs", "rmsle", "normalised"});
  for (const GuidelineDeviation& d : guideline.deviations) {
    curves.add({d.lambda, d.xi, d.effective_friction, static_cast<double>(d.runs), d.rmsle, d.normalised});
  }
  curves.write(out / "guideline.csv");
  NumberTable minima({"lambda", "hardening_xi", "minimum_at", "neighbour_below", "neighbour_above", "parabola_at", "rmsle",
                      "published_from", "published_to", "inside"});
  for (const GuidelineMinimum& m : guideline.minima) {
    minima.add({m.lambda, m.xi, m.at, m.below, m.above, m.parabola, m.rmsle, m.published_from, m.published_to, m.inside ? 1.0 : 0.0});
  }
  minima.write(out / "guideline_minima.csv");
}

void write_decomposition(const std::filesystem::path& path, const StudyTable& table, const std::vector<Rheology>& chain) {
  NumberTable links(
      {"froude_number", "bernoulli", "link", "critical_state_slope", "cohesion_beta", "hardening_xi", "runup", "pressure_height"});
  for (const Decomposition& d : decompose(table.runs, chain)) {
    for (std::size_t i = 0; i < chain.size(); ++i) {
      links.add({d.froude, d.bernoulli, static_cast<double>(i), chain[i].critical_state_slope, chain[i].cohesion_beta,
                 chain[i].hardening_xi, d.runup[i], d.pressure_height[i]});
    }
  }
  links.write(path);
}

void write_width_factors(const std::filesystem::path& path, const StudyTable& table) {
  NumberTable factors({"critical_state_slope", "cohesion_beta", "effective_friction", "hardening_xi", "froude_number", "relative_width",
                       "runup_factor", "runup_standard_error", "pressure_height_factor", "pressure_height_standard_error", "guideline"});
  for (const WidthFactor& w : width_factors(table.runs)) {
    factors.add({w.critical_state_slope, w.cohesion_beta, w.effective_friction, w.hardening_xi, w.froude, w.relative_width, w.runup,
                 w.runup_error, w.pressure_height, w.pressure_height_error, w.guideline});
  }
  factors.write(path);
}

/// Coefficients of the `narrow` set, and scores against the published equations, for each choice of what a run's height is.
void write_height_choices(const std::filesystem::path& path, const StudyTable& table) {
  std::string rows =
      "height,runs,k_r,kappa_r,runup_rmsle_published,runup_fraction_25_published,k_p,Fr_sat,kappa_p,pressure_height_nrmse_published,"
      "pressure_height_fraction_25_published\n";
  for (const HeightChoice& choice : height_choices(table.runs)) {
    std::vector<double> numbers;
    const auto add_fit = [&](HeightEquation equation, double Scores::*error) {
      const SetFit s = fit_set(equation, paper_fitting_sets().front(), choice.runs);
      const HeightCoefficients c = s.fit ? s.fit->coefficients : HeightCoefficients{none, none, none};
      const Scores* whole = s.whole(true);
      if (numbers.empty()) numbers.push_back(static_cast<double>(s.runs));
      numbers.push_back(c.k);
      if (equation == HeightEquation::pressure_height) numbers.push_back(c.saturation_froude);
      numbers.push_back(c.kappa);
      numbers.push_back(whole != nullptr ? whole->*error : none);
      numbers.push_back(whole != nullptr ? whole->fraction_25 : none);
    };
    add_fit(HeightEquation::runup, &Scores::rmsle);
    add_fit(HeightEquation::pressure_height, &Scores::nrmse);
    std::vector<std::string> cells{choice.name};
    for (const double x : numbers) cells.push_back(format_number(x));
    rows += csv_line(cells);
  }
  write_file(path, rows);
}

/// @return for the terminal
std::vector<std::string> write_compaction(const std::filesystem::path& out, const StudyTable& table) {
  const std::vector<CompactionLoss> losses = compaction_losses(table.runs);
  double greatest = 2.0;
  NumberTable rows({"froude_number", "critical_state_slope", "cohesion_beta", "effective_friction", "hardening_xi", "compaction",
                    "stiff_compaction", "head", "head_standard_error", "behind_shock", "share", "share_standard_error"});
  for (const CompactionLoss& l : losses) {
    const double stiff = head_behind_shock(l.stiff_compaction);
    rows.add({l.froude, l.critical_state_slope, l.cohesion_beta, l.effective_friction, l.hardening_xi, l.compaction, l.stiff_compaction,
              l.head.value, l.head.standard_error, l.behind_shock, l.head.value * stiff, l.head.standard_error * stiff});
    greatest = std::max(greatest, l.compaction);
  }
  rows.write(out / "compaction.csv");
  constexpr int steps = 100;
  NumberTable curve({"compaction", "share"});
  for (int i = 0; i <= steps; ++i) {
    const double chi = 1.0 + (greatest - 1.0) * i / steps;
    curve.add({chi, head_behind_shock(chi)});
  }
  curve.write(out / "compaction_curve.csv");
  NumberTable groups({"cohesive", "runs", "mean_head", "mean_behind_shock", "rms"});
  std::vector<std::string> lines;
  for (const CompactionSummary& s : summarise(losses)) {
    groups.add({s.cohesive ? 1.0 : 0.0, static_cast<double>(s.runs), s.mean_head, s.mean_behind_shock, s.rms});
    lines.push_back(
        fmt::format("compaction, Fr >= 3, {} cohesion: {} runs keep {:.2f} of the head of the least compressible snow; behind the shock "
                    "{:.2f}, rms difference {:.2f}",
                    s.cohesive ? "with" : "without", s.runs, s.mean_head, s.mean_behind_shock, s.rms));
  }
  groups.write(out / "compaction_summary.csv");
  return lines;
}

/// Particles near the axis in the last state of a run, with the mean profile that stands beside them.
/// @return the mean spacing of these particles, m: the edge of the cube that each fills
double write_section(const std::filesystem::path& out, const std::string& name, const StudyRun& r) {
  const Snapshot last = read_final(r.folder / "final.h5");
  const ParticleTable& p = last.particles;
  const double half_width = 3.0 / 7.0 * r.obstacle_width;  // the strip of the paper's measurements
  const double from = -6.0 * r.flow_height, to = 3.0 * r.flow_height;
  NumberTable particles({"x_m", "z_m", "stress_xx_pa"});
  double spacing = 0.0, count = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double x = p.position[3 * i], y = p.position[3 * i + 1], z = p.position[3 * i + 2];
    if (std::abs(y) > half_width || x < from || x > to) continue;
    particles.add({x, z, p.stress[6 * i] / p.volume_ratio[i]});
    spacing += std::cbrt(p.volume[i] * p.volume_ratio[i]);
    count += 1.0;
  }
  particles.write(out / fmt::format("section_{}.csv", name));
  const Table profile = Table::read(r.folder / "profile.csv");
  const std::vector<std::string> columns{"z_m", "pressure_pa", "smoothed_pressure_pa"};
  std::vector<std::vector<double>> values;
  values.reserve(columns.size());
  for (const std::string& column : columns) values.push_back(profile.numbers(column));
  write_table(out / fmt::format("section_profile_{}.csv", name), columns, values);
  return spacing / count;
}

/// The two runs of Fig. 5: the end of the decomposition's chain in a slow and in a fast flow.
/// @return what is missing
std::vector<std::string> write_sections(const std::filesystem::path& out, const StudyTable& table, const Rheology& rheology) {
  NumberTable sections({"froude_number", "flow_height_m", "runup", "pressure_height", "particle_spacing_m"});
  std::vector<std::string> missing;
  for (const auto& [name, froude] : {std::pair{"slow", 0.1}, std::pair{"fast", 5.0}}) {
    const auto run = std::ranges::find_if(table.runs, [&, fr = froude](const StudyRun& r) {
      return r.reference_width() && same_input(r.froude, fr) && same_input(r.hardening_xi, rheology.hardening_xi) &&
             same_input(r.critical_state_slope, rheology.critical_state_slope) && same_input(r.cohesion_beta, rheology.cohesion_beta);
    });
    const std::string what = fmt::format("Fr = {:g}, M = {:g}, beta = {:g}, xi = {:g}", froude, rheology.critical_state_slope,
                                         rheology.cohesion_beta, rheology.hardening_xi);
    if (run == table.runs.end()) {
      missing.push_back("no run with " + what);
    } else if (run->folder.empty() || !std::filesystem::exists(run->folder / "final.h5") ||
               !std::filesystem::exists(run->folder / "profile.csv")) {
      missing.push_back("the run with " + what + " did not keep its last state (final.h5) and profile");
    } else {
      const double spacing = write_section(out, name, *run);
      sections.add({froude, run->flow_height, run->runup, run->pressure_height, spacing});
    }
  }
  sections.write(out / "sections.csv");
  return missing;
}

void write_spreads(const std::filesystem::path& path, const StudyTable& table) {
  NumberTable rows({"froude_number", "runs", "runup_low", "runup_high", "runup_ratio", "pressure_height_low", "pressure_height_high",
                    "pressure_height_ratio"});
  for (const Spread& s : spreads(table.runs)) {
    rows.add({s.froude, static_cast<double>(s.runs), s.runup_low, s.runup_high, s.runup_high / s.runup_low, s.pressure_low, s.pressure_high,
              s.pressure_high / s.pressure_low});
  }
  rows.write(path);
}

/// @return notes
std::vector<std::string> write_sensitivities(const std::filesystem::path& out, const std::filesystem::path& results) {
  const SensitivityStudy study = sensitivities(results);
  std::string runs =
      "choice,value,froude_number,critical_state_slope,cohesion_beta,hardening_xi,effective_friction,runup_to_base,runup_standard_error,"
      "pressure_height_to_base,pressure_height_standard_error,force_to_base,force_standard_error,runup_to_published,"
      "pressure_height_to_published\n";
  const auto row = [](const std::string& choice, const std::string& value, const std::vector<double>& numbers) {
    std::vector<std::string> cells{choice, value};
    for (const double x : numbers) cells.push_back(format_number(x));
    return csv_line(cells);
  };
  for (const Sensitivity& s : study.runs) {
    runs += row(s.choice, s.value,
                {s.froude, s.critical_state_slope, s.cohesion_beta, s.hardening_xi, s.effective_friction, s.runup.value,
                 s.runup.standard_error, s.pressure_height.value, s.pressure_height.standard_error, s.force.value, s.force.standard_error,
                 s.runup_to_published, s.pressure_height_to_published});
  }
  write_file(out / "sensitivity.csv", runs);
  std::string summaries =
      "choice,value,points,runup,runup_low,runup_high,pressure_height,pressure_height_low,pressure_height_high,force,force_low,force_high,"
      "runup_rmsle,base_runup_rmsle\n";
  for (const SensitivitySummary& s : study.summaries) {
    summaries += row(s.choice, s.value,
                     {static_cast<double>(s.points), s.runup.mean, s.runup.low, s.runup.high, s.pressure_height.mean, s.pressure_height.low,
                      s.pressure_height.high, s.force.mean, s.force.low, s.force.high, s.runup_rmsle, s.base_runup_rmsle});
  }
  write_file(out / "sensitivity_summary.csv", summaries);
  return study.notes;
}

void study(const StudyCommand& command) {
  StudyTable table = read_study(command.input);
  table.provenance.insert(table.provenance.begin(), command.notes.begin(), command.notes.end());
  const auto other_table = [&](const std::vector<std::filesystem::path>& files) { return files.empty() ? table : read_study_table(files); };
  const std::vector<SetFit> fits = fit_paper_sets(table);
  const HeightCoefficients runup = own_coefficients(fits, HeightEquation::runup);
  const HeightCoefficients pressure = own_coefficients(fits, HeightEquation::pressure_height);
  const Rheology last{command.decomposition.at(0), command.decomposition.at(1), command.decomposition.at(2)};
  const GuidelineCorrespondence guideline = guideline_correspondence(table.runs);

  std::filesystem::create_directories(command.out);
  write_file(command.out / "fit.json", fits_json(fits, table));
  write_file(command.out / "coefficients.csv", coefficients_csv(fits));
  write_file(command.out / "scores.csv", scores_csv(fits));
  write_points(command.out / "points.csv", table, runup, pressure);
  write_curves(command.out, table, runup, pressure);
  write_friction(command.out / "effective_friction.csv");
  write_envelopes(command.out / "envelopes.csv", table);
  write_guideline(command.out, guideline);
  write_decomposition(command.out / "decomposition.csv", table, decomposition_chain(last));
  write_spreads(command.out / "spreads.csv", table);
  write_width_factors(command.out / "width_factors.csv", other_table(command.width));
  write_height_choices(command.out / "height_choices.csv", table);
  const auto compaction = write_compaction(command.out, table);
  const auto missing = write_sections(command.out, other_table(command.sections), last);
  const auto not_compared =
      command.sensitivity.empty() ? std::vector<std::string>{} : write_sensitivities(command.out, command.sensitivity);

  fmt::print("{} rows, {} runs with a steady run-up\n", table.rows, table.runs.size());
  for (const auto& [reason, rows] : table.left_out) fmt::print("  left out: {} ({})\n", rows, reason);
  for (const std::string& note : table.cautions) fmt::print(stderr, "note: {}\n", note);
  for (const SetFit& s : fits) {
    if (!s.fit) fmt::print("{} not fitted to set '{}': {}\n", to_string(s.equation), s.set.name, s.why_not);
  }
  for (const GuidelineMinimum& m : guideline.minima) {
    fmt::print("guideline lambda = {:g}, xi = {:g}: lowest RMSLE {:.3f} at M' = {:.3f}{}; published {} to {}: {}\n", m.lambda, m.xi,
               m.rmsle, m.at, std::isnan(m.parabola) ? " (an end of the curve)" : fmt::format(", parabola {:.3f}", m.parabola),
               m.published_from, m.published_to,
               std::isnan(m.parabola) ? "no minimum located"
               : m.inside             ? "inside"
                                      : "outside");
  }
  for (const std::string& note : guideline.notes) fmt::print("guideline: {}\n", note);
  for (const std::string& line : compaction) fmt::print("{}\n", line);
  for (const std::string& note : not_compared) fmt::print("sensitivities, left out: {}\n", note);
  for (const std::string& what : missing) fmt::print("longitudinal sections: {}\n", what);
  fmt::print(stderr, "wrote {} and the tables beside it; drawn by `./run study`\n", (command.out / "fit.json").string());
}

}  // namespace

void add_study(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "study",
      "The numbers behind the figures of the paper's study, as one folder of tables: regressions and scores (as `mpm fit`), guideline "
      "correspondence, rheological decomposition, envelopes of the time histories, width factors");
  const auto a = std::make_shared<StudyCommand>();
  add_study_arguments(*command, a->input);
  command->add_option("--out", a->out, "Folder for the tables")->required()->type_name("DIR");
  const auto add_list = [command](const char* name, auto& values, const char* text, const char* type) {
    command->add_option(name, values, text)->type_name(type)->type_size(1)->allow_extra_args(false);
  };
  add_list("--width", a->width, "Table of the width study (Fig. 10), where it is another one", "RESULTS.csv");
  add_list("--sections", a->sections, "Table with the two runs of Fig. 5 that kept final.h5, where it is another one", "RESULTS.csv");
  command->add_option("--sensitivity", a->sensitivity, "Table of runs that change one choice at a time, compared with their base")
      ->type_name("RESULTS.csv");
  add_list("--note", a->notes, "A line on where the data come from, for the page", "TEXT");
  command->add_option("--decomposition", a->decomposition, "M,beta,xi at the end of the chain of the decomposition")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  command->callback([a] { study(*a); });
}

}  // namespace mpm::app
