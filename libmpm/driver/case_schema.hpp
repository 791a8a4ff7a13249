#pragma once
/// The keys of case files and of point paths, assembled from the components that declare them (base/parameter.hpp), and their reference.
/// Reading, range checks, suggestions and writing follow from the same declarations.

#include <string>
#include <vector>

#include "libmpm/config/reference.hpp"
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

/// What `mpm schema` prints: tables and keys of both kinds of files, and the laws.
[[nodiscard]] const config::Reference& case_reference();

}  // namespace mpm
