#pragma once
/// The tables of a case file and of a point path, assembled from the components that declare them.

#include "libmpm/config/schema.hpp"
#include "libmpm/driver/case.hpp"
#include "libmpm/driver/point_path.hpp"

namespace mpm {

/// A point path as a file gives it.
struct PathFile {
  std::string title;                        ///< heading of pictures
  MaterialParameters material;              ///< [material]
  PathSteps steps;                          ///< [path]
  std::vector<SegmentParameters> segments;  ///< [[path.segments]]

  /// The keys above the first table.
  template <class Table>
  static void declare(Table& table) {
    declare_heading(table, &PathFile::title);
  }
};

[[nodiscard]] const config::SchemaOf<Case>& case_schema();      ///< of case files; made once
[[nodiscard]] const config::SchemaOf<PathFile>& path_schema();  ///< of point paths; made once

/// What has to hold between tables of a case; completes what one table leaves to another (speed and width of the belt, friction). Names are
/// paths: "numerics.cell_size_m".
void resolve_case(Case& c, ParameterReport& report);

}  // namespace mpm
