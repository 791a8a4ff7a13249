#pragma once
/// Internal to campaign: the content of a plan file and of the files that it includes, before the blocks are expanded to runs.

#include <toml++/toml.h>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/campaign/plan.hpp"

namespace mpm {

/// One of the values of an axis, with its part of the names of runs; without a name, that follows from the settings.
using Choice = NamedSettings;

/// [[when]]: the settings of runs that have certain values.
struct Rule {
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
[[nodiscard]] std::vector<PlannedRun> expand(const PlanBlocks& blocks);

}  // namespace mpm
