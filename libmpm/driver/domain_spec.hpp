#pragma once
/// Where particles may be, as a case gives it.

#include "libmpm/base/limits.hpp"
#include "libmpm/base/types.hpp"

namespace mpm {

class ParameterReport;

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

}  // namespace mpm
