#pragma once
/// Water that a gate releases onto an obstacle: the runs of the cases that compare with such experiments.

#include <vector>

#include "validation/harness/grid_convergence.hpp"
#include "validation/harness/setup.hpp"
#include "validation/harness/time_record.hpp"

namespace mpm::validation {

/// The case file on another grid. Every body starts at rest under the hydrostatic pressure of its own depth, as behind a gate, and the gate
/// vanishes at t = 0.
/// @param base      half of the scene, with a fluid that follows Tait's equation of state
/// @param cells     of the grid in `length`, m
/// @param duration  s; results are written 200 times a second
Setup dam_on_obstacle_setup(const Case& base, int cells, double length, double duration);

/// A part of the record whose mean is compared with that of the run.
struct TimeWindow {
  double from, to;  ///< s
  bool judged;      ///< by a check; the others are reported
};

/// Means of a quantity over time windows, on all grids, against those of a record.
struct WindowComparison {
  std::string id;                   ///< of the plots, unique in its case
  std::string quantity, clock;      ///< "force", "after the release"
  std::string unit;                 ///< of the records
  Quantity kind;                    ///< in the summary
  double uncertainty;               ///< relative standard deviation of the record's means; the tolerance is twice this
  std::string reason;               ///< of the tolerance
  std::vector<TimeWindow> windows;  ///< on the clock of the records
};

/// A convergence study and a note for each window that the runs have reached; for the judged ones a check of the finest grid.
/// @param sizes  cell sizes, m, coarse first. @param runs  as many records, on the clock of `measured`
/// @returns the checks of the judged windows, in their order
std::vector<Check*> compare_windows(CaseResult& result, const WindowComparison& comparison, const TimeRecord& measured,
                                    const std::vector<double>& sizes, const std::vector<TimeRecord>& runs);

/// Plot of a record and of the runs. @param band  two standard deviations of the record, in its unit: lines on both sides of it
Plot record_plot(Plot plot, const TimeRecord& measured, double band, const std::vector<std::string>& names,
                 const std::vector<TimeRecord>& runs);

}  // namespace mpm::validation
