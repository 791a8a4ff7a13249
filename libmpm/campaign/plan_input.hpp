#pragma once
/// Internal to campaign: the TOML of a plan and of the files that it includes (PlanInput), all of whose errors are collected and reported
/// together; and its content (PlanBlocks), before the blocks are expanded to runs.

#include <toml++/toml.h>

#include <deque>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/campaign/plan.hpp"
#include "libmpm/config/file_problems.hpp"

namespace mpm {

/// One of the values of an axis, with its part of the names of runs; without a name, that follows from the settings.
using Choice = NamedSettings;

/// [[when]]: the settings of runs that have certain values.
struct Rule {
  std::string place;                       ///< file, line and name, of one that must match a run; empty: of an included file
  std::vector<std::vector<Choice>> match;  ///< a run matches if it has the settings of one choice of each
  std::vector<Setting> set;                ///< for the runs that match
};

/// [parameters] at the top, or a [[grid]].
struct Crossing {
  std::string name;                       ///< begins the names of its runs; may be empty
  std::vector<std::vector<Choice>> axes;  ///< the choices of each; each of one with each of the others
  std::vector<Setting> set;               ///< for all its runs
  std::vector<Rule> rules;                ///< for some of its runs
};

/// The content of a plan file and of the files that it includes.
struct PlanBlocks {
  CampaignPlan plan;                          ///< without its runs
  toml::table base;                           ///< the base case
  std::map<std::string, std::string> labels;  ///< short names of keys
  std::vector<Setting> set;                   ///< for all runs
  std::vector<Rule> rules;                    ///< for all runs
  std::vector<Crossing> crossings;  ///< [parameters] and [[grid]], in their order; those of included files come after the plan's own
  std::vector<NamedSettings> rows;  ///< [[run]] and rows of tables, without a name or with one; as for the crossings
};

/// Adds a setting; it replaces an earlier one of the same key, and of a key that sets the same quantity.
void put(std::vector<Setting>& settings, const Setting& s);
/// Adds several, in their order.
void put(std::vector<Setting>& settings, const std::vector<Setting>& more);

/// The runs of the blocks, in the order of the plan. @throws ConfigError for a crossing of too many runs
/// @param matched  not null: the rules that match a run are added
[[nodiscard]] std::vector<PlannedRun> expand(const PlanBlocks& blocks, std::set<const Rule*>* matched = nullptr);

/// Reads values, and records their errors. A value with an error is empty, or the preset.
class PlanInput {
 public:
  /// @param file  the plan
  explicit PlanInput(const std::filesystem::path& file) : plan_(file), problems_(plan_.string()) {}

  /// The plan, or a file that it includes.
  struct File {
    std::filesystem::path path;  ///< its name
    toml::table root;            ///< its content
    /// A file that it names.
    [[nodiscard]] std::filesystem::path beside(const std::string& name) const { return path.parent_path() / name; }
  };
  /// Parses the plan and the files that it includes. @throws ConfigError for what is not TOML, IoError
  void load(std::string_view text) { load(plan_, text, {}); }
  [[nodiscard]] const std::deque<File>& files() const { return files_; }  ///< a file, then those that it includes
  /// Those that a file includes, then the file: later ones override.
  [[nodiscard]] const std::vector<const File*>& inner_first() const { return inner_first_; }

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
  /// Reports a key that is one of others, or sets the same quantity as one of them.
  void once(const std::string& key, const std::vector<std::string>& others, const toml::source_region& source, const std::string& where);
  /// Settings of the table `name`, for keys of a case.
  std::vector<Setting> settings(const toml::table& table, const std::string& where, const std::string& name);

  /// The entries in the order of the file, which a TOML table does not keep.
  [[nodiscard]] static std::vector<Entry> in_order(const toml::table& table);

 private:
  /// @param chain  the files that led to this one
  void load(const std::filesystem::path& path, std::string_view text, std::vector<std::filesystem::path> chain);
  /// @return why the file cannot be included; empty if it is
  std::string include(const std::filesystem::path& path, const std::vector<std::filesystem::path>& chain);

  std::filesystem::path plan_;
  std::deque<File> files_;
  std::vector<const File*> inner_first_;
  std::set<std::filesystem::path> loaded_;  ///< each is read once
  config::FileProblems problems_;
  std::vector<std::string> others_;  ///< other files with problems, in the order in which they were found
};

}  // namespace mpm
