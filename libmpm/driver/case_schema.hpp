#pragma once
/// The tables of a case file and of a point path, assembled from the components that declare them.

#include "libmpm/config/schema.hpp"
#include "libmpm/driver/case.hpp"
#include "libmpm/driver/point_path.hpp"

namespace mpm {

/// The content of a file with a point path.
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

[[nodiscard]] const config::SchemaOf<Case>& case_schema();      ///< of case files
[[nodiscard]] const config::SchemaOf<PathFile>& path_schema();  ///< of point paths

}  // namespace mpm
