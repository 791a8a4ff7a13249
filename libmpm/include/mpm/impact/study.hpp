#pragma once
/// The evaluations of the paper's study, over a table of runs: its regressions (Tables A1 and A2, Figs. A3 and A5), the guideline's lambda
/// in terms of M' (Fig. 9), the rheological decomposition (Fig. 4), envelopes of the time histories (Fig. 3), the width factors (Fig. 10)
/// and, beyond it, what compaction takes of the velocity head.

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mpm/impact/regression.hpp"
#include "mpm/impact/steady.hpp"
#include "mpm/impact/study_table.hpp"

namespace mpm {

// ---- Regressions ----------------------------------------------------------------------------------------------------------------------

/// Which runs are fitted. The paper names two sets.
struct FittingSet {
  std::string name, description;
  std::vector<double> xi;
  bool only = true;  ///< true: only runs with one of these xi; false: all others

  [[nodiscard]] bool holds(const StudyRun& run) const;
};
/// `narrow`, xi in {0.5, 1.5, 5} (note of Table 1), and `wide`, everything but xi = 0.05 (Sect. 4.1).
[[nodiscard]] std::vector<FittingSet> paper_fitting_sets();

/// Samples of an equation from the runs that have its height and w = H.
[[nodiscard]] std::vector<HeightSample> height_samples(HeightEquation equation, std::span<const StudyRun> runs);

/// Scores of some runs against one set of coefficients.
struct ScoreRow {
  bool published = false;         ///< against the paper's coefficients; else against the fitted ones
  std::optional<double> xi;       ///< only runs of this xi; empty: all of the fitting set
  std::string group;              ///< input that the runs share: froude_number, effective_friction, hardening_xi; empty: none
  double at = Coefficient::none;  ///< its value
  std::size_t runs = 0;
  Scores scores{};
};

/// One equation fitted to one set.
struct SetFit {
  HeightEquation equation = HeightEquation::runup;
  FittingSet set;
  std::size_t runs = 0;                             ///< of the set, with this height and w = H
  std::size_t without_height = 0, other_width = 0;  ///< runs of the set that were left out
  std::optional<HeightFit> fit;                     ///< empty: see why_not
  std::string why_not;
  std::vector<ScoreRow> scores;  ///< of the set by Fr, M' and xi, and of each xi of the table (in the set or not) by Fr and M'

  /// Scores of the whole set against the published or the fitted coefficients; null without them.
  [[nodiscard]] const Scores* whole(bool published) const;
};
[[nodiscard]] SetFit fit_set(HeightEquation equation, const FittingSet& set, std::span<const StudyRun> runs);

/// Columns equation,fitting_set,parameter,value,standard_error,relative_standard_error,t_statistic,p_value,interval_from,interval_to,
/// published,published_relative_standard_error,published_t_statistic,relative_difference.
[[nodiscard]] std::string coefficients_csv(std::span<const SetFit> fits);
/// Columns equation,fitting_set,coefficients,hardening_xi,group,at,runs,r2,r2_log,nrmse,rmsle,bias,fraction_10,fraction_25.
[[nodiscard]] std::string scores_csv(std::span<const SetFit> fits);
/// Everything of the fits, the published values, the aims, and what the table left out, as one JSON object.
[[nodiscard]] std::string fits_json(std::span<const SetFit> fits, const StudyTable& table);

/// An aim of the study, and whether it is met.
struct Aim {
  std::string what, aim;
  double value;
  bool met;
};
/// Against the published equations: RMSLE of the run-up <= 15 %, NRMSE of the pressure height <= 10 %, >= 90 % of the runs within 25 %;
/// coefficients within 15 % of the published ones. @param fits of one set
[[nodiscard]] std::vector<Aim> paper_aims(std::span<const SetFit> fits);

// ---- Guideline correspondence (Sect. 4.2, Fig. 9) -------------------------------------------------------------------------------------

/// Distance of the simulated run-up of one M' from the guideline's, H + v^2 / (2 g lambda) f(w/H).
struct GuidelineDeviation {
  double lambda, xi, effective_friction;
  std::size_t runs;
  double rmsle;
  double normalised;  ///< 0 at the smallest and 1 at the largest of its curve, as Fig. 9 draws it
};
/// Where a curve of Fig. 9 is lowest.
struct GuidelineMinimum {
  double lambda, xi;
  double at;            ///< M' with the smallest RMSLE
  double below, above;  ///< its neighbours: the minimum of the continuous curve is between them; NaN beyond the ends
  double parabola;      ///< vertex of the parabola through the three; NaN at an end
  double rmsle;         ///< at `at`
  double published_from, published_to;
  bool inside;  ///< the parabola's vertex lies in the published range; false at an end, where no minimum is located
};
struct GuidelineCorrespondence {
  std::vector<GuidelineDeviation> deviations;
  std::vector<GuidelineMinimum> minima;
  std::vector<std::string> notes;  ///< what is missing
};
/// For lambda = 1.5 and 3 and each xi: RMSLE over the runs with 3 <= Fr <= 7, by M'. Only M' with a run at every such Froude number of
/// their xi are compared, so that all points of a curve mean the same.
[[nodiscard]] GuidelineCorrespondence guideline_correspondence(std::span<const StudyRun> runs);

// ---- Rheological decomposition (Sect. 3.1, Fig. 4) ------------------------------------------------------------------------------------

struct Rheology {
  double critical_state_slope, cohesion_beta, hardening_xi;
};
/// M = beta = 0, xi = 5; then M; then beta; then xi: the chain of Fig. 4 that ends in `last`. The paper's is M = 0.8, beta = 0.3, xi = 0.5.
[[nodiscard]] std::vector<Rheology> decomposition_chain(const Rheology& last);
/// Heights of the links of the chain at one Froude number, over H; NaN where the table has no such run.
struct Decomposition {
  double froude;
  double bernoulli;  ///< 1 + Fr^2/2
  std::vector<double> runup, pressure_height;
};
[[nodiscard]] std::vector<Decomposition> decompose(std::span<const StudyRun> runs, std::span<const Rheology> chain);

// ---- Time histories (Fig. 3) ----------------------------------------------------------------------------------------------------------

/// Lowest and highest of all runs of one Froude number at one time, over H.
struct EnvelopePoint {
  double time;
  std::size_t runs;  ///< whose series reaches so far
  double runup_low, runup_high, pressure_low, pressure_high;
};
struct Envelope {
  double froude;
  std::size_t runs = 0;  ///< with a series
  std::vector<EnvelopePoint> points;
};
/// Envelope of the series.csv of all runs of a Froude number with w = H, on the times of the longest series, linear between samples.
[[nodiscard]] Envelope envelope(std::span<const StudyRun> runs, double froude);

/// What is taken as the height of a run. The paper averages over "a time span several seconds long" that it does not print.
struct HeightChoice {
  std::string name;
  std::vector<StudyRun> runs;
};
/// `steady span`: as the table has it; `last third`: mean over the last third of the run's series.csv; `peak`: the run's highest, splash
/// and all. The same runs for each: those with a series.
[[nodiscard]] std::vector<HeightChoice> height_choices(std::span<const StudyRun> runs);

/// Lowest and highest steady mean of all rheologies at one Froude number, over H.
struct Spread {
  double froude;
  std::size_t runs;
  double runup_low, runup_high, pressure_low, pressure_high;
};
/// For each Froude number of the table; runs with w = H only.
[[nodiscard]] std::vector<Spread> spreads(std::span<const StudyRun> runs);

// ---- Width (Sect. 4.3, Fig. 10) -------------------------------------------------------------------------------------------------------

/// Eq. 11: height over that of the run with w = H and all else equal; standard errors by propagation of both runs'.
struct WidthFactor {
  double critical_state_slope, cohesion_beta, effective_friction, hardening_xi, froude, relative_width;
  double runup, runup_error, pressure_height, pressure_height_error;
  double guideline;  ///< Eq. 6, rescaled to 1 at w = H
};
/// Empty unless the table varies the width.
[[nodiscard]] std::vector<WidthFactor> width_factors(std::span<const StudyRun> runs);

// ---- Compaction (not in the paper)
// -------------------------------------------------------------------------------------------------------

/// Share of the velocity head v^2 / (2 g) that is left behind a standing normal shock which compacts the snow from rho_0 to chi rho_0:
/// (2 chi - 1) / chi^2. Mass, v_1 = v / chi, and momentum, p_1 = rho_0 v^2 (1 - 1/chi), give the total head behind it,
/// p_1 / (chi rho_0 g) + v_1^2 / (2 g); plastic compaction has taken the rest, (1 - 1/chi)^2, and the dense snow does not give it back.
/// @param density_ratio chi >= 1
[[nodiscard]] double head_behind_shock(double density_ratio);

/// A run against the one of the least compressible snow, all else equal (w = H).
struct CompactionLoss {
  double froude, critical_state_slope, cohesion_beta, effective_friction, hardening_xi;
  double compaction, stiff_compaction;  ///< chi at the mast, of this run and of the other one
  MeanRatio head;                       ///< (h_r - H) over the other's
  double behind_shock;                  ///< the same from head_behind_shock of both runs
};
/// Runs with a steady run-up and a compaction, but those of the least compressible snow.
[[nodiscard]] std::vector<CompactionLoss> compaction_losses(std::span<const StudyRun> runs);

/// How well the shock explains the run-ups at Fr >= 3, without and with cohesion.
struct CompactionSummary {
  bool cohesive;  ///< M beta > 0
  std::size_t runs;
  double mean_head;  ///< arithmetic means
  double mean_behind_shock;
  double rms;  ///< of head - behind_shock
};
[[nodiscard]] std::vector<CompactionSummary> summarise(std::span<const CompactionLoss> losses);

[[nodiscard]] std::string_view to_string(HeightEquation equation);  ///< runup, pressure_height

}  // namespace mpm
