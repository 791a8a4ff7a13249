#include "libmpm/campaign/plan_input.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <regex>
#include <set>
#include <system_error>
#include <tuple>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/config/guard.hpp"
#include "libmpm/config/toml_text.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

// ---- From TOML -------------------------------------------------------------------------------------------------------------------------

using config::kind_of;
using config::one_line;
using config::shown;
using config::toml_text;

namespace {

constexpr std::size_t most_files = 32;  // a plan and what it includes

void flatten(const toml::table& table, const std::string& prefix, std::vector<PlanInput::Entry>& entries) {
  for (const auto& [key, node] : table) {
    const std::string path = config::key_path(prefix, std::string(key.str()));
    if (const toml::table* inner = node.as_table()) {
      flatten(*inner, path, entries);
    } else {
      entries.push_back({path, &node, key.source()});
    }
  }
}

}  // namespace

void PlanInput::load(const std::filesystem::path& path, std::string_view text, std::vector<std::filesystem::path> chain) {
  File& file = files_.emplace_back(File{path, config::parsed(text, path.string())});
  chain.push_back(std::filesystem::weakly_canonical(path));
  loaded_.insert(chain.back());
  for (const std::string& name : words(file.root, "", "include")) {
    const std::string why = include(file.beside(name), chain);
    if (!why.empty()) problem(file.root.get("include")->source(), "", fmt::format("include: \"{}\" {}", one_line(name), why));
  }
  inner_first_.push_back(&file);
}

std::string PlanInput::include(const std::filesystem::path& path, const std::vector<std::filesystem::path>& chain) {
  if (std::error_code error; !std::filesystem::is_regular_file(path, error))
    return "is not a file; names are relative to the file that includes them";
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(path);
  if (std::ranges::find(chain, canonical) != chain.end()) return "leads back to itself; remove this include, or the one in that file";
  if (loaded_.contains(canonical)) return {};
  if (files_.size() == most_files) return fmt::format("is one too many: a plan has at most {} files; join some of them", most_files);
  load(path, config::bounded_file_text(path), chain);
  return {};
}

void PlanInput::problem(const toml::source_region& source, const std::string& where, const std::string& text) {
  config::FilePosition place = problems_.in_file(source.begin.line, source.begin.column);
  if (source.path && *source.path != plan_.string()) {
    place.text = fmt::format("{}:{}:{}", *source.path, place.line, place.column);
    place.source_number = static_cast<std::size_t>(std::ranges::find(others_, *source.path) - others_.begin()) + 1;
    if (place.source_number > others_.size()) others_.push_back(*source.path);
  }
  problems_.add(place, where.empty() ? text : fmt::format("{} {}", where, text));
}

void PlanInput::only(const toml::table& table, const std::string& where, const std::vector<std::string>& permitted) {
  for (const auto& [key, node] : table) {
    if (given_up()) return;
    const std::string name(key.str());
    if (std::ranges::find(permitted, name) != permitted.end()) continue;
    const std::string meant = nearest_word(name, permitted);
    const std::string remedy = !meant.empty()                        ? fmt::format("did you mean {}?", meant)
                               : name.find('.') != std::string::npos ? "keys of a case belong into set or parameters"
                                                                     : fmt::format("there is {}", fmt::join(permitted, ", "));
    problem(key.source(), where, fmt::format("unknown key {}; {}", one_line(name), remedy));
  }
}

std::string PlanInput::text(const toml::table& table, const std::string& where, const char* name, const std::string& preset) {
  const toml::node* node = table.get(name);
  if (node == nullptr) return preset;
  if (const auto value = node->value_exact<std::string>()) return *value;
  problem(node->source(), where, fmt::format("{} = {} is {}; give a string in quotes", name, shown(*node), kind_of(*node)));
  return {};
}

int PlanInput::integer(const toml::table& table, const char* name, int low, int high, int preset) {
  const toml::node* node = table.get(name);
  if (node == nullptr) return preset;
  const auto value = node->value_exact<std::int64_t>();
  if (value && *value >= low && *value <= high) return static_cast<int>(*value);
  problem(node->source(), "", fmt::format("{} = {}; give an integer in [{}, {}]", name, shown(*node), low, high));
  return preset;
}

std::vector<std::string> PlanInput::words(const toml::table& table, const std::string& where, const char* name,
                                          const std::vector<std::string>& preset) {
  const toml::node* node = table.get(name);
  if (node == nullptr) return preset;
  std::vector<std::string> list;
  if (const toml::array* array = node->as_array()) {
    for (const toml::node& element : *array) {
      if (const auto word = element.value_exact<std::string>()) list.push_back(*word);
    }
    if (list.size() == array->size()) return list;
  }
  problem(node->source(), where, fmt::format("{} = {}; give a list of strings", name, shown(*node)));
  return {};
}

const toml::table* PlanInput::table_at(const toml::table& table, const std::string& where, const char* name) {
  const toml::node* node = table.get(name);
  if (node == nullptr) return nullptr;
  if (node->is_table()) return node->as_table();
  problem(node->source(), where, fmt::format("{} = {} is {}; give a table", name, shown(*node), kind_of(*node)));
  return nullptr;
}

std::vector<const toml::table*> PlanInput::tables_at(const toml::table& table, const std::string& where, const char* name,
                                                     std::size_t most) {
  const toml::node* node = table.get(name);
  if (node == nullptr) return {};
  std::vector<const toml::table*> entries;
  if (const toml::array* list = node->as_array()) {
    if (list->size() > most) {
      problem(node->source(), where, fmt::format("[[{}]] is given {} times; at most {} are possible", name, list->size(), most));
      return {};
    }
    for (const toml::node& element : *list) {
      if (const toml::table* entry = element.as_table()) entries.push_back(entry);
    }
    if (entries.size() == list->size()) return entries;
  }
  problem(node->source(), where, fmt::format("{0} is {1}; write [[{0}]] with two brackets, once for each", name, kind_of(*node)));
  return {};
}

std::string PlanInput::key_meant(const std::string& key, const toml::source_region& source, const std::string& where) {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> names;
    for (const config::Table& table : case_schema().tables()) {
      for (const config::Key& k : table.keys) names.push_back(config::key_path(table.name, k.name));
    }
    return names;
  }();
  static const std::regex index(R"(\[[0-9]+\])");
  constexpr std::size_t longest = 200;  // characters; the regular expression recurses for each character
  const std::string plain = key.size() > longest ? key : std::regex_replace(key, index, "");
  if (std::ranges::find(keys, plain) != keys.end()) return key;
  std::string meant = nearest_word(plain, keys);
  const auto ends_so = [&](const std::string& k) { return k.ends_with(fmt::format(".{}", plain)); };
  if (const auto whole = std::ranges::find_if(keys, ends_so); whole != keys.end()) meant = *whole;
  problem(source, where,
          fmt::format("unknown key {}; {}", one_line(key),
                      meant.empty() ? "see `mpm schema`, and write table.key" : fmt::format("did you mean \"{}\"?", meant)));
  return meant;
}

std::vector<PlanInput::Entry> PlanInput::in_order(const toml::table& table) {
  std::vector<Entry> entries;
  flatten(table, "", entries);
  std::ranges::stable_sort(entries, {}, [](const Entry& e) { return std::tuple(e.source.begin.line, e.source.begin.column); });
  return entries;
}

void PlanInput::once(const std::string& key, const std::vector<std::string>& others, const toml::source_region& source,
                     const std::string& where) {
  const std::vector<std::string> rivals = case_schema().rivals(key);
  for (const std::string& other : others) {
    if (key.empty() || (other != key && std::ranges::find(rivals, other) == rivals.end())) continue;
    return problem(source, where,
                   other == key ? fmt::format("{} is given twice; give it once", key)
                                : fmt::format("{} and {} set the same quantity; give one of them", other, key));
  }
}

std::vector<Setting> PlanInput::settings(const toml::table& table, const std::string& where, const std::string& name) {
  std::vector<Setting> list;
  if (const toml::table* set = table_at(table, where, name.c_str())) {
    const std::string here = fmt::format("{}{}{}:", where, where.empty() ? "" : " ", name);
    std::vector<std::string> keys;
    for (const Entry& e : in_order(*set)) {
      if (given_up()) break;
      if (list.size() == most_settings) {
        problem(e.source, where, fmt::format("{} has more than {} keys", name, most_settings));
        break;
      }
      const std::string key = key_meant(e.key, e.source, here);
      if (key == e.key) once(key, keys, e.source, here);
      keys.push_back(key);
      put(list, {key, toml_text(*e.node)});
    }
  }
  return list;
}

// ---- Runs ------------------------------------------------------------------------------------------------------------------------------

namespace {

/// Whether two values are the same number, in any notation, the same text, or lists of such.
bool same(const toml::node& a, const toml::node& b) {
  if (const auto* left = a.as_array(), *right = b.as_array(); left != nullptr && right != nullptr)
    return std::equal(left->begin(), left->end(), right->begin(), right->end(), same);
  return a.is_number() && b.is_number() ? a.value<double>() == b.value<double>() : toml_text(a) == toml_text(b);
}
bool same_value(const std::string& a, const std::string& b) {
  return a == b || same(*toml::parse("value = " + a).get("value"), *toml::parse("value = " + b).get("value"));
}

/// The present value of a run: its own, or that of the base.
std::optional<std::string> value_of(const PlanBlocks& blocks, const std::vector<Setting>& settings, const std::string& key) {
  if (const auto s = std::ranges::find(settings, key, &Setting::key); s != settings.end()) return s->value;
  const std::vector<std::string> rivals = case_schema().rivals(key);  // one of them replaces the base's
  if (std::ranges::any_of(settings, [&](const Setting& s) { return std::ranges::find(rivals, s.key) != rivals.end(); })) return {};
  const auto node = blocks.base.at_path(key);
  return node && !node.is_table() ? std::optional(toml_text(*node.node())) : std::nullopt;
}

using Matched = std::set<const Rule*>;

/// Settings by the rules for a run with these settings. @param matching  the rules that match are added, if it is not null
std::vector<Setting> matched(const PlanBlocks& blocks, const std::vector<Rule>& rules, const std::vector<Setting>& settings,
                             Matched* matching) {
  std::vector<Setting> given;
  for (const Rule& rule : rules) {
    const auto has = [&](const Setting& s) {
      const auto value = value_of(blocks, settings, s.key);
      return value && same_value(*value, s.value);
    };
    const auto is_one_of = [&](const std::vector<Choice>& choices) {
      return std::ranges::any_of(choices, [&](const Choice& choice) { return std::ranges::all_of(choice.settings, has); });
    };
    if (!std::ranges::all_of(rule.match, is_one_of)) continue;
    if (matching != nullptr) matching->insert(&rule);
    put(given, rule.set);
  }
  return given;
}

/// Later settings override earlier ones: the plan's, those of its rules, the block's, those of its rules, the run's own.
PlannedRun planned_run(const PlanBlocks& blocks, const Crossing& block, NamedSettings own, Matched* matching) {
  std::vector<Setting> all = blocks.set;
  put(all, block.set);
  put(all, own.settings);
  PlannedRun run{std::move(own.name), blocks.set};
  put(run.settings, matched(blocks, blocks.rules, all, matching));
  put(run.settings, block.set);
  put(run.settings, matched(blocks, block.rules, all, matching));
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

std::vector<PlannedRun> expand(const PlanBlocks& blocks, std::set<const Rule*>* matched) {
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
    for (NamedSettings& run : crossed(crossing, blocks)) add(planned_run(blocks, crossing, std::move(run), matched));
  }
  for (const NamedSettings& row : blocks.rows) add(planned_run(blocks, {}, {name_of(row, blocks.labels), row.settings}, matched));
  return runs;
}

}  // namespace mpm
