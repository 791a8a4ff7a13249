#pragma once
/// How long a run lasts and what it writes, as a case gives it.

namespace mpm {

/// [output]
struct OutputSpec {
  double duration = 1.0;             ///< s
  double stop_when_steady = 0.0;     ///< largest relative standard error of the means at which a run ends sooner; 0: it does not
  double series_per_second = 50.0;   ///< rows of series.csv
  double frames_per_second = 1.0;    ///< HDF5 frames
  double checkpoint_minutes = 10.0;  ///< wall time between checkpoints
  bool operator==(const OutputSpec&) const = default;

  /// The keys of [output] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("duration_s", &OutputSpec::duration)
        .unit("s")
        .positive(1e6)
        .required()
        .text("Simulated time; the run ends with the first row of series.csv at or after it");
    table.add("stop_when_steady", &OutputSpec::stop_when_steady)
        .range(0.0, 0.2)
        .only_with_table("conveyor")
        .no_effect_on_results()
        .text(
            "The run ends before duration_s once the means of run-up, pressure height and force on the obstacle are known to this relative "
            "standard error and no longer drift (docs/cases.md); 0: it does not");
    table.add("series_per_second", &OutputSpec::series_per_second)
        .unit("1/s")
        .positive(1e6)
        .text("Rows of series.csv per simulated second");
    table.add("frames_per_second", &OutputSpec::frames_per_second)
        .unit("1/s")
        .range(0.0, 1e4)
        .text("Stored particle frames per simulated second; 0: none");
    table.add("checkpoint_minutes", &OutputSpec::checkpoint_minutes)
        .unit("min")
        .positive(1e5)
        .no_effect_on_results()
        .text("Wall-clock time between checkpoints");
  }
};

}  // namespace mpm
