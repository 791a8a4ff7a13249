#pragma once
/// A case as pure data: the resolved content of a case file, in SI units, with every default filled in. Each part declares its own keys.
/// case_file.hpp reads it from TOML and writes it back; scene.hpp turns it into particles, walls and a source.

#include <optional>
#include <string>
#include <vector>

#include "libmpm/boundary/any_boundary.hpp"
#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/core/numerics.hpp"
#include "libmpm/driver/domain_spec.hpp"
#include "libmpm/driver/output_spec.hpp"
#include "libmpm/impact/conveyor_spec.hpp"
#include "libmpm/impact/measurement_spec.hpp"
#include "libmpm/material/any_material.hpp"
#include "libmpm/source/body.hpp"

namespace mpm {

/// Version of the case format, the key format_version. A file may give it; another version is refused.
inline constexpr int case_format_version = 1;

/// The keys above the first table, of a case file and of a point path.
template <class Table, class Base>
void declare_heading(Table& table, std::string Base::*title) {
  table.add("title", title).no_effect_on_results().text("Describes the case; heading of results and pictures");
  table.add_constant("format_version", case_format_version).text("Version of the format of this file");
}

/// One simulation. read_case (case_file.hpp) returns it checked and complete.
struct Case : BoundaryTables {
  std::string title;                     ///< heading of results and pictures; not part of the hash
  MaterialParameters material;           ///< [material]
  std::vector<BodySpec> bodies;          ///< [[body]]
  std::optional<ConveyorSpec> conveyor;  ///< [conveyor], with its [[conveyor.inflow]]
  std::optional<ObstacleSpec> obstacle;  ///< [obstacle]
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
