#pragma once
/// The reference of keys that `mpm schema` prints.

#include <string>
#include <vector>

#include "libmpm/config/schema.hpp"

namespace mpm {

/// One table as a user sees it.
struct TableInfo {
  std::string name;         ///< empty: the keys above the first table
  bool repeated;            ///< [[name]], any number of times
  bool optional;            ///< [name], which may be left out even if it has required keys
  bool in_case;             ///< may be in a case file
  bool in_path;             ///< may be in a point path
  std::string description;  ///< one line
};

/// One constitutive law as a user sees it.
struct ModelInfo {
  std::string name;               ///< value of material.model
  std::string description;        ///< one line
  std::vector<std::string> keys;  ///< keys of [material] that it uses and another law does not
};

}  // namespace mpm

namespace mpm::config {

/// The keys of a kind of file.
struct Reference {
  int format_version;                ///< of these files
  std::vector<TableInfo> tables;     ///< in the order in which they are written
  std::vector<KeyInfo> keys;         ///< table by table
  std::vector<ModelInfo> models;     ///< in the order of AnyMaterial; empty: files that name no law
  std::string files = "case files";  ///< kind of file

  /// A table with its keys. @param empty  a file without any table. @param in_case, in_path  as in TableInfo
  void add(const Table& table, const void* empty, bool in_case, bool in_path);
};

/// Readable text: the tables with their keys, then the laws.
[[nodiscard]] std::string reference_text(const Reference& reference);
/// One JSON object {format_version, tables, models}.
[[nodiscard]] std::string reference_json(const Reference& reference);

}  // namespace mpm::config
