#pragma once
/// A validation case and its result.
///
/// A case is a folder validation/cases/<name>/ with README.md (the physics, the origin of the reference, the checks and the reasons of
/// their tolerances) and case.cpp, which registers itself:
///
///   namespace mpm::validation::NAME { namespace { void run(CaseContext& context, CaseResult& result) { ... }
///   const Registration registered{{.title = "...", .run = run}}; } }
///
/// The build finds the folder without a list. Every number and every verdict is computed in C++; scripts/validation_report.py only draws.

#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/driver/convergence.hpp"
#include "validation/harness/comparison.hpp"
#include "validation/harness/flow.hpp"

namespace mpm::validation {

/// Kind of a check. The three are kept apart.
enum class Label {
  verification,  ///< against an exact solution or an exact property: error and order
  validation,    ///< against an experiment or the paper: a band from its scatter
  regression,    ///< against our own earlier results
};
enum class Level { quick, standard, full };
std::string to_string(Label);
std::string to_string(Level);

/// Measure of `error`, and so the unit of `tolerance`.
enum class Measure {
  relative,  ///< |value - reference| / |reference|
  absolute,  ///< |value - reference|, in the check's unit
  at_most,   ///< value - reference, in the check's unit: a one-sided bound with slack `tolerance`
};

/// A target that this program is known to miss: the cause, and a bound. The result may lie between target and bound.
struct KnownMiss {
  double bound = 0.0;  ///< in the check's unit; above the reference for a result that is too large, below for one too small
  std::string cause;
};

/// Outcome of a check: it holds; it fails as known and explained (Check::known_miss); it fails.
enum class Verdict { ok, not_met, failed };
/// "ok", "not met", "FAILED"
std::string to_string(Verdict verdict);

/// One assertion. `passed` is false if one of the numbers is NaN.
struct Check {
  std::string quantity;
  double value = 0.0, reference = 0.0;
  std::string unit;
  Measure measure = Measure::relative;
  double error = 0.0, tolerance = 0.0;
  std::string tolerance_reason;
  std::optional<double> observed_order;
  bool passed = false;
  Label label = Label::verification;
  std::optional<Comparison> comparison = {};  ///< its point in the summary
  std::optional<KnownMiss> miss = {};         ///< empty: the target must be met

  [[nodiscard]] Verdict verdict() const;  ///< failed if a number is NaN
  /// Keeps the target, which this program is known not to meet at present: it is reported as "not met" with this cause, and is no failure
  /// while the result lies between the target and `bound`. Choose the bound near the measured value, so that a change for the worse fails,
  /// and state the cause in the README of the case. Another solver that misses the target fails (run_case_entry).
  /// @param bound  as KnownMiss::bound, of no use within the tolerance; std::invalid_argument if it is the reference or not finite
  Check& known_miss(double bound, std::string cause);
  /// Shows value and reference in the summary of predicted against reference values. Both must be in the quantity's unit, with a prefix at
  /// most (kPa, mm).
  /// @param reference_uncertainty  standard deviation of the reference, relative. @throws std::logic_error for a regression check
  Check& in_summary(Quantity quantity, double reference_uncertainty = 0.0);
  /// The same for a check without a unit or in units of the flow ("h0", "c0").
  /// @param unit_value  what 1 of value and reference is, in the quantity's unit
  Check& in_summary(Quantity quantity, double reference_uncertainty, double unit_value);
};

/// A point of the summary without a check of its own: one of several values that one check tests together, for example by a fit.
struct NamedComparison {
  Label label = Label::verification;
  std::string name;
  Comparison comparison;
};

/// Named data of a plot.
struct Series {
  enum class Style {
    reference,   ///< exact solution, experiment: black line
    simulation,  ///< ours: coloured line
    points,      ///< ours: coloured markers
    bound,       ///< dashed grey: a limit or a slope to compare with
  };
  std::string name;
  std::vector<double> x, y;
  Style style = Style::simulation;
};

/// The line error ~ size^order through (the finest size, at_finest): two points, straight where both axes are logarithmic.
/// @param size  coarse first
Series slope_line(std::string name, const std::vector<double>& size, double at_finest, double order);
/// The exact curve y(x), a reference, at parts + 1 places spread evenly from one x to the other.
Series reference_curve(std::string name, double from, double to, int parts, const std::function<double(double)>& y);

struct Plot {
  std::string id;                       ///< file name, unique in its case
  std::string title, x_label, y_label;  ///< labels carry the unit
  std::vector<Series> series = {};
  std::string caption = {};
  bool log_x = false, log_y = false;
};

/// A picture file made by the case (PNG), embedded in the report.
struct Picture {
  std::filesystem::path file;
  std::string caption;
};

/// The convergence of a quantity, drawn beside its checks.
struct NamedConvergence {
  std::string quantity, unit;
  Convergence convergence;
  std::string size_label = "cell size [m]";  ///< refined parameter
};

/// The result of a case.
struct CaseResult {
  std::string name, title;
  std::string physics;       ///< first paragraph of the README
  std::deque<Check> checks;  ///< a deque: the references that the functions below return stay valid
  std::vector<Plot> plots;
  std::vector<Picture> pictures;
  std::vector<FlowPicture> flows;
  std::vector<NamedConvergence> convergences;
  std::vector<NamedComparison> comparisons;  ///< points of the summary beside those of the checks
  std::vector<std::string> notes;            ///< information for the reader: settings, observations without a check
  std::string fault;                         ///< message of an exception; a case that throws has failed
  double wall_time_s = 0.0;

  /// Whether no check has failed, there is at least one, and nothing was thrown.
  [[nodiscard]] bool passed() const;

  /// |value - reference| <= tolerance |reference|
  Check& check_relative(Label, std::string quantity, double value, double reference, std::string unit, double tolerance,
                        std::string reason);
  /// |value - reference| <= tolerance
  Check& check_absolute(Label, std::string quantity, double value, double reference, std::string unit, double tolerance,
                        std::string reason);
  /// value <= bound + slack
  Check& check_at_most(Label, std::string quantity, double value, double bound, std::string unit, double slack, std::string reason);
  /// A point of the summary beside those of the checks. The numbers must be in the quantity's unit, with a prefix at most.
  void compare(Label, std::string name, Quantity, double predicted, double reference, const std::string& unit,
               double reference_uncertainty = 0.0);
  /// low <= order <= high; shown as observed order against the middle of the band
  Check& check_order(Label, std::string quantity, double order, double low, double high, std::string reason);
};

class RunSource;  // harness/setup.hpp
struct Setup;

/// The context in which a case runs.
class CaseContext {
 public:
  CaseContext(Level level, int threads, std::filesystem::path directory, std::filesystem::path case_directory,
              std::function<void(const std::string&)> log, const RunSource* source = nullptr,
              Precision precision = Precision::double_precision)
      : level_(level),
        threads_(threads),
        directory_(std::move(directory)),
        case_directory_(std::move(case_directory)),
        log_(std::move(log)),
        source_(source),
        precision_(precision) {}
  [[nodiscard]] Level level() const { return level_; }
  /// The entry of this level.
  template <class T>
  [[nodiscard]] T choose(T quick, T standard, T full) const {
    return level_ == Level::quick ? quick : level_ == Level::standard ? standard : full;
  }
  [[nodiscard]] int threads() const { return threads_; }
  /// The directory of the case below the output directory; it exists.
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }
  /// validation/cases/<name>/ in the sources: data.csv, case.toml
  [[nodiscard]] const std::filesystem::path& case_directory() const { return case_directory_; }
  /// A case file of the case, in the precision that this run of the suite has.
  [[nodiscard]] Case read_case(const std::string& file = "case.toml") const;
  /// A line of progress, for standard error.
  void log(const std::string& line) const { log_(line); }
  /// Source of the runs of a case with set-ups (harness/setup.hpp); null: this program makes them.
  [[nodiscard]] const RunSource* source() const { return source_; }

 private:
  Level level_;
  int threads_;
  std::filesystem::path directory_, case_directory_;
  std::function<void(const std::string&)> log_;
  const RunSource* source_;
  Precision precision_;
};

struct CaseEntry {
  std::string name, title;
  std::filesystem::path directory;  ///< validation/cases/<name>/
  std::function<void(const CaseContext&, CaseResult&)> run;
  /// The runs that the case needs. `run` then evaluates the results of play() (harness/setup.hpp), so that it can evaluate other solvers,
  /// too. Empty for a case that only this program can run.
  std::function<std::vector<Setup>(const CaseContext&)> setups = {};
  bool experiment = false;  ///< compares with measurements: before the other cases in the report
};

/// All registered cases, those that compare with measurements first, and by name; the order of the report.
const std::vector<CaseEntry>& registered_cases();

/// Registers a case while the program starts, under the name of the folder of its source.
/// (`std::source_location` would say the same, but clang-tidy 14 does not know it.)
struct Registration {
  explicit Registration(CaseEntry entry, const char* source = __builtin_FILE());
};

/// Runs one case: times it, turns an exception into `fault`, reads the README's first paragraph.
CaseResult run_case_entry(const CaseEntry& entry, const CaseContext& context);

/// First paragraph of a Markdown text that is no heading, on one line; empty if there is none.
std::string first_paragraph(const std::string& markdown);

}  // namespace mpm::validation
