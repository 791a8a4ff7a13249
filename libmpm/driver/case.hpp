#pragma once
/// A case as pure data: the resolved content of a case file, in SI units, with every default filled in. Each part declares its own keys.
/// case_file.hpp reads it from TOML and writes it back; scene.hpp turns it into particles, walls and a source.

#include <optional>
#include <string>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/core/numerics.hpp"
#include "libmpm/impact/conveyor_spec.hpp"
#include "libmpm/impact/measurement_spec.hpp"
#include "libmpm/material/any_material.hpp"
#include "libmpm/source/body.hpp"

namespace mpm {

class ParameterReport;

/// Version of the case format, the key format_version. A file may give it; another version is refused.
inline constexpr int case_format_version = 1;

/// The keys above the first table, of a case file and of a point path.
template <class Table, class Base>
void declare_heading(Table& table, std::string Base::*title) {
  table.add("title", title).no_effect_on_results().text("Describes the case; heading of results and pictures");
  table.add_constant("format_version", case_format_version).text("Version of the format of this file");
}

/// [domain]: particles that leave are removed and counted. Mirror planes pass through the origin: only x >= 0 (y >= 0) is
/// computed, and sums such as forces and masses are reported for the whole.
struct DomainSpec {
  Vec3 min = Vec3::Constant(-1e3), max = Vec3::Constant(1e3);  ///< corners, m
  bool mirror_x = false, mirror_y = false;                     ///< planes x = 0 and y = 0
  bool operator==(const DomainSpec&) const = default;

  /// The keys of [domain] (base/parameter.hpp).
  template <class Table>
  static void declare(Table& table) {
    table.add("min_m", &DomainSpec::min)
        .unit("m")
        .range(-longest_length, longest_length)
        .required_without_table("conveyor")
        .text("Lower corner; particles that leave are removed and counted");
    table.add("max_m", &DomainSpec::max)
        .unit("m")
        .range(-longest_length, longest_length)
        .required_without_table("conveyor")
        .text("Upper corner; particles that leave are removed and counted");
    table.add_axes("mirror", &DomainSpec::mirror_x, &DomainSpec::mirror_y)
        .only_with_table("conveyor", false)
        .text("Symmetry planes through the origin: only x >= 0 (y >= 0) is computed");
  }
  /// min is below max along every axis.
  void check(ParameterReport& report) const;
};

/// [output]: how long a run lasts and what it writes.
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

/// One simulation. read_case (case_file.hpp) returns it checked and complete.
struct Case : BoundaryTables {
  std::string title;                     ///< heading of results and pictures; not part of the hash
  MaterialParameters material;           ///< [material]
  std::vector<BodySpec> bodies;          ///< [[body]]
  std::optional<ConveyorSpec> conveyor;  ///< [conveyor], with its [[conveyor.inflow]]
  std::optional<ObstacleSpec> obstacle;  ///< [obstacle]
  std::optional<ArmSpec> arm;            ///< [arm]
  DomainSpec domain;                     ///< [domain]
  Numerics numerics;                     ///< [numerics]
  MeasurementSpec measurement;           ///< [measurement]
  OutputSpec output;                     ///< [output]
  bool operator==(const Case&) const = default;

  /// The keys above the first table.
  template <class Table>
  static void declare(Table& table) {
    declare_heading(table, &Case::title);
  }
};

}  // namespace mpm
