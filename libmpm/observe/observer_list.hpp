#pragma once
/// All observers of a run and the series that they fill.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Passes states and frames to its observers and keeps their rows.
class ObserverList {
 public:
  /// Columns in the order of the observers. @throws Error if two columns have one name
  explicit ObserverList(std::vector<std::shared_ptr<Observer>> observers);

  /// At the start and after a resume, before the first step.
  void begin(const State& state, const Scene& scene);
  /// After every step.
  void after_step(const StepReport& report, const State& state);

  /// Measures a state and adds a row to the series. @return the row
  std::vector<double> sample(const Instant& now);
  /// Whether an observer visits the particles of a block.
  [[nodiscard]] bool visits(const Block& block, const Scene& scene, double cell_size) const;
  /// Measures a stored frame and adds a row to the series.
  /// @param carried value of a column of an observer of MeasuredFrom::run at this frame
  std::vector<double> sample(const Snapshot& frame, const std::function<double(const Column&)>& carried);
  /// Warnings. @throws UnstableError
  std::vector<std::string> check(const Instant& now);
  /// Whether an observer lets the run end after the last row.
  [[nodiscard]] bool may_end() const;

  [[nodiscard]] const TimeSeries& series() const { return series_; }  ///< all rows so far
  /// Profiles, and input of results, at the end of a run. @param state and progress: null if frames were measured
  [[nodiscard]] Summary summary(const State* state, const RunProgress* progress) const;
  /// The entries of results.json; of observers of MeasuredFrom::frames only if frames were measured.
  [[nodiscard]] Results results(const Summary& end) const;

  /// Arrays by "observer.array"; the series as "series.column".
  [[nodiscard]] Arrays save() const;
  /// @throws IoError if the arrays are not those of these observers after that many samples
  void load(const Arrays& arrays, std::size_t samples);

 private:
  std::vector<std::shared_ptr<Observer>> observers_;
  std::vector<std::size_t> width_;  ///< columns of each observer
  TimeSeries series_;
};

/// One sample of a single observer, outside of a run.
std::vector<double> measure(Observer& observer, const State& state, const Scene& scene);

}  // namespace mpm
