#pragma once
/// Internal to campaign: values of a plan file. All errors of the file are collected and reported together.

#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <vector>

#include "libmpm/campaign/plan.hpp"
#include "libmpm/config/file_problems.hpp"

namespace mpm {

/// Reads values, and records their errors. A value with an error is empty, or the preset.
class PlanValues {
 public:
  /// @param file  name of the plan, for messages
  explicit PlanValues(const std::filesystem::path& file) : plan_(file.string()), problems_(plan_) {}

  /// An entry of a table. Keys may be given as "table.key" in quotes or as dotted keys, which TOML makes tables of.
  struct Entry {
    std::string key;             ///< "table.key"
    const toml::node* node;      ///< its value
    toml::source_region source;  ///< where it is in the file
  };

  /// @param where name of the table in messages, empty at the top
  void problem(const toml::source_region& source, const std::string& where, const std::string& text);
  [[nodiscard]] bool valid() const { return !problems_.any(); }         ///< no error so far
  [[nodiscard]] bool given_up() const { return problems_.given_up(); }  ///< so many errors that reading should stop
  /// @throws ConfigError with all errors in the order of the file
  void throw_problems() { problems_.throw_if_any(); }

  /// Reports every key of a table that is not permitted.
  void only(const toml::table& table, const std::string& where, const std::vector<std::string>& permitted);
  /// A string; preset where it is left out.
  std::string text(const toml::table& table, const std::string& where, const char* name, const std::string& preset = {});
  /// A whole number in [low, high]; preset where it is left out.
  int integer(const toml::table& table, const char* name, int low, int high, int preset);
  /// A list of strings; preset where it is left out.
  std::vector<std::string> words(const toml::table& table, const std::string& where, const char* name,
                                 const std::vector<std::string>& preset = {});
  /// [name]; null where it is left out.
  const toml::table* table_at(const toml::table& table, const std::string& where, const char* name);
  /// The entries of [[name]], at most so many.
  std::vector<const toml::table*> tables_at(const toml::table& table, const std::string& where, const char* name,
                                            std::size_t most = most_runs);
  /// The key of a case that is meant: this one, or, once an unknown one is reported, the most similar (empty: there is none).
  std::string key_meant(const std::string& key, const toml::source_region& source, const std::string& where);
  /// Settings of the table `name`, for keys of a case.
  std::vector<Setting> settings(const toml::table& table, const std::string& where, const std::string& name);

  /// The entries in the order of the file, which a TOML table does not keep.
  [[nodiscard]] static std::vector<Entry> in_order(const toml::table& table);

 private:
  std::string plan_;  ///< file of the plan
  config::FileProblems problems_;
  std::vector<std::string> others_;  ///< other files with problems, in the order in which they were found
};

}  // namespace mpm
