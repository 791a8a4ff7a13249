#pragma once
/// Whatever is measured is an observer: one file with its columns, its entries of results.json, what it sums and what it has to keep. The
/// list in driver/observers.cpp names them all; run, replay, checkpoint and files are loops over that list (observer_list.hpp).

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/impact/steady.hpp"
#include "libmpm/observe/column.hpp"
#include "libmpm/observe/particle_batch.hpp"
#include "libmpm/observe/time_series.hpp"

namespace mpm {

/// How far a run has come, beside its state.
struct RunProgress {
  std::uint64_t samples = 0;            ///< rows of series.csv
  std::uint64_t particle_steps = 0;     ///< sum over steps of the particles moved
  std::uint64_t initial_particles = 0;  ///< at t = 0
  double wall_time = 0.0;               ///< s, of all stretches
  double step_time = 0.0;               ///< s, of it in the solver

  /// Million particle-steps per second of wall time; 0 at the start.
  [[nodiscard]] double speed() const { return wall_time > 0.0 ? 1e-6 * static_cast<double>(particle_steps) / wall_time : 0.0; }
};

/// A state at a sample.
struct LiveState {
  const State& state;  ///< positions in grid coordinates: x + Scene::offset
  const Scene& scene;  ///< of the same run
  Totals totals;       ///< of the computed part, without the images of mirror planes
};

/// One sample.
struct Instant {
  double time = 0.0;                ///< s
  double interval = 0.0;            ///< s since the sample before; 0 at the first
  const LiveState* live = nullptr;  ///< null in a stored frame, where observers of Source::run are not asked
};

/// What entries of results.json are made from, at the end of a run or of the frames.
struct Summary {
  const TimeSeries& series;               ///< all samples
  Steady span = {};                       ///< the steady interval; none: steady is false
  const State* state = nullptr;           ///< at the end; null for frames, where observers of Source::run are not asked
  const RunProgress* progress = nullptr;  ///< likewise

  /// Mean of a column over the steady interval; all its members are NaN where there is none.
  [[nodiscard]] MeanEstimate mean(std::string_view column) const;
  /// The same of a quantity that is no column. @param values  one for each sample
  [[nodiscard]] MeanEstimate mean(std::span<const double> values) const;
  /// Largest finite value of a column; NaN without one.
  [[nodiscard]] double peak(std::string_view column) const;
  /// Mean over the steady interval of `width` values a sample, given sample by sample; empty where there is none.
  [[nodiscard]] std::vector<double> mean_rows(std::span<const double> values, std::size_t width) const;
};

/// A quantity over height.
struct HeightProfile {
  Column column;                  ///< of profile.csv
  std::vector<double> mean;       ///< over the steady interval, one value a bin: a column of profile.csv
  std::vector<double> over_time;  ///< one value a bin for each sample, sample by sample: a dataset of profiles.h5; empty: none
};

/// A component that measures. Its functions are called in the order in which they are declared here: begin once for each stretch of a run,
/// after_step after every step, then at each sample visit for all particles, sample, check; at the end summary and profiles.
class Observer {
 public:
  virtual ~Observer() = default;

  /// Short, unique, "contact_force": heading of tables, and prefix of what a checkpoint holds.
  [[nodiscard]] virtual std::string name() const = 0;
  /// Whether stored frames give its columns and results again. Otherwise they are carried over from the run.
  [[nodiscard]] virtual Source source() const { return Source::particles; }
  /// Its columns of series.csv.
  [[nodiscard]] virtual std::vector<Column> columns() const { return {}; }

  /// A run starts, or goes on after load().
  virtual void begin(const State& /*state*/, const Scene& /*scene*/) {}
  /// A step is done: the place to sum up what must not be sampled.
  virtual void after_step(const StepReport& /*report*/, const State& /*state*/) {}
  /// Whether visit() has to see the particles of a box. Depends on nothing that changes; an observer that has a visit() says when.
  /// The arguments are the lowest and the highest corner of the box, m.
  [[nodiscard]] virtual bool visits(const Vec3& /*low*/, const Vec3& /*high*/) const { return false; }
  /// All particles of the boxes that it visits, batch by batch.
  virtual void visit(const ParticleBatch& /*batch*/) {}
  /// Fills its row, one number for each of columns(), NaN where a value is unknown, and starts its sums anew.
  virtual void sample(const Instant& /*now*/, std::span<double> /*row*/) {}
  /// Asked after the row and the frame are written. @return warnings for the log. @throws UnstableError
  virtual std::vector<std::string> check(const Instant& /*now*/) { return {}; }

  /// The steady interval, over which all means are taken; one observer of a list may give it.
  [[nodiscard]] virtual std::optional<Steady> steady_interval(const TimeSeries& /*series*/) const { return std::nullopt; }
  /// Its entries of results.json: always the same, unknown ones as NaN, so that they can be listed without a run.
  [[nodiscard]] virtual std::vector<Result> summary(const Summary& /*end*/) const { return {}; }
  /// What it knows over height; the same columns always.
  [[nodiscard]] virtual std::vector<HeightProfile> profiles(const Summary& /*end*/) const { return {}; }

  /// What it keeps from sample to sample, beside its columns. Called at a sample, when no sums are under way.
  [[nodiscard]] virtual Arrays save() const { return {}; }
  /// Takes back what save() gave after so many samples. @throws IoError for arrays that it cannot have given then
  virtual void load(const Arrays& /*arrays*/, std::size_t /*samples*/) {}
};

}  // namespace mpm
