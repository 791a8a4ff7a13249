#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/plan.hpp"
#include "libmpm/campaign/plan_blocks.hpp"
#include "libmpm/config/toml_text.hpp"
#include "libmpm/driver/case_schema.hpp"

namespace mpm {

namespace {

/// Whether two values are the same number, in any notation, or the same text.
bool same_value(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const toml::table left = toml::parse("value = " + a), right = toml::parse("value = " + b);
  const toml::node &x = *left.get("value"), &y = *right.get("value");
  return x.is_number() && y.is_number() && x.value<double>() == y.value<double>();
}

/// The present value of a run: its own, or that of the base.
std::optional<std::string> value_of(const PlanBlocks& blocks, const std::vector<Setting>& settings, const std::string& key) {
  if (const auto s = std::ranges::find(settings, key, &Setting::key); s != settings.end()) return s->value;
  const auto node = blocks.base.at_path(key);
  return node && !node.is_table() ? std::optional(config::toml_text(*node.node())) : std::nullopt;
}

/// Settings by the rules for a run with these settings.
std::vector<Setting> matched(const PlanBlocks& blocks, const std::vector<Rule>& rules, const std::vector<Setting>& settings) {
  std::vector<Setting> given;
  for (const Rule& rule : rules) {
    const auto has = [&](const Setting& s) {
      const auto value = value_of(blocks, settings, s.key);
      return value && same_value(*value, s.value);
    };
    const auto is_one_of = [&](const std::vector<NamedSettings>& choices) {
      return std::ranges::any_of(choices, [&](const NamedSettings& choice) { return std::ranges::all_of(choice.set, has); });
    };
    if (std::ranges::all_of(rule.match, is_one_of)) put(given, rule.set);
  }
  return given;
}

/// Later settings override earlier ones: the plan's, those of its rules, the block's, those of its rules, the run's own.
PlannedRun planned_run(const PlanBlocks& blocks, std::string name, const std::vector<Setting>& block_set,
                       const std::vector<Rule>& block_rules, const std::vector<Setting>& own) {
  std::vector<Setting> all = blocks.set;
  put(all, block_set);
  put(all, own);
  PlannedRun run{std::move(name), blocks.set};
  put(run.settings, matched(blocks, blocks.rules, all));
  put(run.settings, block_set);
  put(run.settings, matched(blocks, block_rules, all));
  put(run.settings, own);
  return run;
}

std::string name_of(const NamedSettings& row, const std::map<std::string, std::string>& labels) {
  return row.name.empty() ? run_name(row.set, labels) : row.name;
}

/// Names and own settings of the runs of a crossing; the last axis varies fastest.
std::vector<NamedSettings> crossed(const Crossing& crossing, const std::map<std::string, std::string>& labels,
                                   const std::filesystem::path& file) {
  std::size_t count = 1;
  for (const std::vector<NamedSettings>& axis : crossing.axes) {
    count *= axis.size();
    if (count > most_runs)
      throw ConfigError(
          fmt::format("{}: the lists of a crossing make more than {} runs; give shorter ones, or several plans", file.string(), most_runs));
  }
  std::vector<NamedSettings> runs(count, {crossing.name, {}});
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t stride = count;
    for (const std::vector<NamedSettings>& axis : crossing.axes) {
      stride /= axis.size();
      const NamedSettings& choice = axis[i / stride % axis.size()];
      if (!runs[i].name.empty()) runs[i].name += '_';
      runs[i].name += name_of(choice, labels);
      put(runs[i].set, choice.set);
    }
  }
  return runs;
}

}  // namespace

void put(std::vector<Setting>& settings, const Setting& s) {
  const auto there = std::ranges::find(settings, s.key, &Setting::key);
  if (there == settings.end()) {
    settings.push_back(s);
  } else {
    there->value = s.value;
  }
  // a later setting replaces an earlier one of a key that sets the same quantity
  const std::vector<std::string> rivals = case_schema().rivals(s.key);
  std::erase_if(settings, [&](const Setting& o) { return std::ranges::find(rivals, o.key) != rivals.end(); });
}

void put(std::vector<Setting>& settings, const std::vector<Setting>& more) {
  for (const Setting& s : more) put(settings, s);
}

std::vector<PlannedRun> expand(const PlanBlocks& blocks, const std::filesystem::path& file) {
  std::vector<PlannedRun> runs;
  const auto add = [&](PlannedRun run) {
    if (runs.size() == most_runs)
      throw ConfigError(fmt::format("{}: the plan makes more than {} runs; divide it into several plans", file.string(), most_runs));
    if (const std::string why = name_problem(run.name); !why.empty()) {
      throw ConfigError(fmt::format(
          "{}: a run is named after its values, but {}; give its [[grid]] or [[run]] a name, or its keys [labels]", file.string(), why));
    }
    runs.push_back(std::move(run));
  };
  for (const Crossing& crossing : blocks.crossings) {
    for (const NamedSettings& run : crossed(crossing, blocks.labels, file))
      add(planned_run(blocks, run.name, crossing.set, crossing.rules, run.set));
  }
  for (const NamedSettings& row : blocks.rows) add(planned_run(blocks, name_of(row, blocks.labels), {}, {}, row.set));
  return runs;
}

}  // namespace mpm
