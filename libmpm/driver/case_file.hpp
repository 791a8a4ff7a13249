#pragma once
/// Case files: TOML in, a resolved Case out, and back; and the keys of case files and of point paths, assembled from the components that
/// declare them (base/parameter.hpp), and their reference. Reading, range checks, suggestions and writing follow from the same
/// declarations.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/config/reference.hpp"
#include "libmpm/config/schema.hpp"
#include "libmpm/driver/case.hpp"
#include "libmpm/driver/point_path.hpp"

namespace mpm {

/// Reads a case file (keys: case_schema(), `mpm schema`) and fills in every default.
/// @param overrides  "table.key=value" as given by --set, "body[0].velocity_m_s=[1,0,0]" in a repeated table; the value is TOML, a bare
///                   word is taken as a string. An override replaces the file's value, and the file's value of a key that sets the same
///                   quantity (froude_number and velocity_m_s, friction and friction_ratio). Two overrides that do so exclude each other.
/// @throws ConfigError with all errors at once, one a line, in the order of the file: `file:line:column: [table] what, value, remedy`
///         (`--set table.key=value` in place of the position where an override is wrong). @throws IoError if the file cannot be read.
[[nodiscard]] Case read_case(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// The same from memory. @param file_name  for messages. @param prefix  of an override in messages: where it was given
[[nodiscard]] Case parse_case(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides = {},
                              std::string_view prefix = "--set ");

/// Checks what has to hold between the components of a case whose tables were read (each component checks itself), and completes what one
/// table leaves to another: speed and width of the belt, friction of the obstacle. Names are paths: "numerics.cell_size_m".
void resolve_case(Case& c, ParameterReport& report);

/// The resolved case as TOML with every key that applies. Numbers are written so that they read back to the same bits:
/// parse_case(write_case(c)) == c for every c that parse_case returned.
[[nodiscard]] std::string write_case(const Case& spec);

/// One key of the resolved case, "table.key" or "body[0].key", as text: a number as in write_case, a string without its quotes. Empty if
/// the key is left out, does not apply, is resolved into another (conveyor.froude_number, obstacle.friction_ratio), or does not exist.
[[nodiscard]] std::optional<std::string> case_value(const Case& spec, const std::string& path);

/// Hash of what influences the computed numbers: FNV-1a (64 bit) of write_case without the title and the keys without
/// effect on them (Parameter::no_effect_on_results) and output.duration_s, so that a longer run of the same case has the same hash and can
/// resume. The strip source is the exception: its duration sets the length of the avalanche, and is part of the hash.
[[nodiscard]] std::uint64_t case_hash(const Case& spec);

/// The same as 16 hexadecimal digits, as in results.json.
[[nodiscard]] std::string case_hash_text(const Case& spec);

/// The keys in which two cases differ, among those that the hash covers: "numerics.cfl was 0.4, is 0.3", "body[1].shape was "box", is
/// (none)".
[[nodiscard]] std::vector<std::string> case_differences(const Case& before, const Case& now);

/// Reads a strain path of one material point for `mpm point` ([material] and [path]). Errors as in read_case.
[[nodiscard]] PathSpec read_path(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
/// The same from a text. @param file_name  for messages
[[nodiscard]] PathSpec parse_path(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides = {});

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
