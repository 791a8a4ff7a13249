#include "libmpm/campaign/plan_blocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "libmpm/base/error.hpp"
#include "libmpm/config/toml_text.hpp"
#include "libmpm/driver/case_schema.hpp"
#include "libmpm/io/csv.hpp"

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
    const auto is_one_of = [&](const std::vector<Choice>& choices) {
      return std::ranges::any_of(choices, [&](const Choice& choice) { return std::ranges::all_of(choice.settings, has); });
    };
    if (std::ranges::all_of(rule.match, is_one_of)) put(given, rule.set);
  }
  return given;
}

/// Later settings override earlier ones: the plan's, those of its rules, the block's, those of its rules, the run's own.
PlannedRun planned_run(const PlanBlocks& blocks, const Crossing& block, NamedSettings own) {
  std::vector<Setting> all = blocks.set;
  put(all, block.set);
  put(all, own.settings);
  PlannedRun run{std::move(own.name), blocks.set};
  put(run.settings, matched(blocks, blocks.rules, all));
  put(run.settings, block.set);
  put(run.settings, matched(blocks, block.rules, all));
  put(run.settings, own.settings);
  return run;
}

/// A TOML value as part of a name: 3.0 is 3.
std::string value_in_name(const std::string& value) {
  const toml::table parsed = toml::parse("value = " + value);
  const toml::node& node = *parsed.get("value");
  if (const auto x = node.value<double>(); x && node.is_number()) return file_name_part(format_number(*x));
  if (const auto text = node.value_exact<std::string>()) return file_name_part(*text);
  return file_name_part(value);
}

/// The name that was given, or one made from the settings.
std::string name_of(const NamedSettings& row, const std::map<std::string, std::string>& labels) {
  if (!row.name.empty()) return row.name;
  std::string name;
  for (const Setting& s : row.settings) {
    const auto label = labels.find(s.key);
    const std::string key = label != labels.end() ? label->second : file_name_part(s.key.substr(s.key.rfind('.') + 1));
    name += fmt::format("{}{}{}", name.empty() ? "" : "_", key, value_in_name(s.value));
  }
  return name;
}

/// Names and own settings of the runs of a crossing; the last axis varies fastest.
std::vector<NamedSettings> crossed(const Crossing& crossing, const PlanBlocks& blocks) {
  std::size_t count = 1;
  for (const std::vector<Choice>& axis : crossing.axes) {
    count *= axis.size();
    if (count > most_runs)
      throw ConfigError(fmt::format("{}: the lists of a crossing make more than {} runs; give shorter ones, or several plans",
                                    blocks.plan.file, most_runs));
  }
  std::vector<NamedSettings> runs(count, {crossing.name, {}});
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t stride = count;
    for (const std::vector<Choice>& axis : crossing.axes) {
      stride /= axis.size();
      const Choice& choice = axis[i / stride % axis.size()];
      if (!runs[i].name.empty()) runs[i].name += '_';
      runs[i].name += name_of(choice, blocks.labels);
      put(runs[i].settings, choice.settings);
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

std::vector<PlannedRun> expand(const PlanBlocks& blocks) {
  std::vector<PlannedRun> runs;
  const auto add = [&](PlannedRun run) {
    if (runs.size() == most_runs)
      throw ConfigError(fmt::format("{}: the plan makes more than {} runs; divide it into several plans", blocks.plan.file, most_runs));
    if (const std::string why = name_problem(run.name); !why.empty()) {
      throw ConfigError(fmt::format(
          "{}: a run is named after its values, but {}; give its [[grid]] or [[run]] a name, or its keys [labels]", blocks.plan.file, why));
    }
    runs.push_back(std::move(run));
  };
  for (const Crossing& crossing : blocks.crossings) {
    for (NamedSettings& run : crossed(crossing, blocks)) add(planned_run(blocks, crossing, std::move(run)));
  }
  for (const NamedSettings& row : blocks.rows) add(planned_run(blocks, {}, {name_of(row, blocks.labels), row.settings}));
  return runs;
}

}  // namespace mpm
