#pragma once
/// Internal to campaign: the content of a plan file, before the blocks are expanded to runs.

#include <toml++/toml.h>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libmpm/campaign/plan.hpp"

namespace mpm {

/// Keys joined by commas, and the rows of their values.
struct VariedKeys {
  std::vector<std::string> keys;               ///< "table.key"
  std::vector<std::vector<std::string>> rows;  ///< one value for each key
};

/// [[when]]: the settings of runs that have one of certain values.
struct Rule {
  std::vector<std::pair<std::string, std::vector<std::string>>> match;  ///< key and values; all must match
  std::vector<Setting> set;                                             ///< for the runs that match
};

/// [parameters] at the top, or a [[grid]].
struct Crossing {
  std::string name;                    ///< begins the names of its runs; may be empty
  std::vector<VariedKeys> parameters;  ///< each row of one with each row of the others
  std::vector<Setting> set;            ///< for all its runs
  std::vector<Rule> rules;             ///< for some of its runs
};

/// [[run]], or a row of the table.
struct Row {
  std::string name;          ///< of the run
  std::vector<Setting> set;  ///< of this run
};

/// The content of a plan file.
struct PlanBlocks {
  CampaignPlan plan;                          ///< without its runs
  toml::table base;                           ///< the base case, if the plan contains it
  std::map<std::string, std::string> labels;  ///< short names of keys
  std::vector<Setting> set;                   ///< for all runs
  std::vector<Rule> rules;                    ///< for all runs
  std::vector<Crossing> crossings;            ///< in the order of the file
  std::vector<Row> rows;                      ///< in the order of the file
};

/// Adds a setting; it replaces an earlier one of the same key, and of a key that sets the same quantity.
void put(std::vector<Setting>& settings, const Setting& s);
/// Adds several, in their order.
void put(std::vector<Setting>& settings, const std::vector<Setting>& more);

/// @throws ConfigError with all problems of the file; IoError
[[nodiscard]] PlanBlocks read_blocks(std::string_view text, const std::filesystem::path& file);

/// The runs of the blocks, in the order of the plan. @throws ConfigError for a crossing of too many runs
[[nodiscard]] std::vector<PlannedRun> expand(const PlanBlocks& blocks, const std::filesystem::path& file);

}  // namespace mpm
