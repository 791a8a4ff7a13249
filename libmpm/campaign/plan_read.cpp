#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <set>
#include <sstream>
#include <tuple>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/campaign/campaign.hpp"
#include "libmpm/campaign/plan.hpp"
#include "libmpm/campaign/plan_input.hpp"
#include "libmpm/config/guard.hpp"
#include "libmpm/config/toml_text.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

namespace {

using config::kind_of;
using config::one_line;
using config::shown;
using config::toml_text;

constexpr int most_threads_of_a_run = 1024, most_ranks_of_a_run = 100000, most_retries = 100;
constexpr std::size_t most_rules = 1000;  // [[when]] of a file or a [[grid]]: each is compared with each run

/// The errors of the cases of a plan that has errors of its own, one a line.
std::string problems_of_cases(PlanBlocks blocks) try {
  if (blocks.plan.base_text.empty()) return {};
  blocks.plan.runs = expand(blocks);
  constexpr std::size_t enough = 1000;  // runs, of which 100,000 take half a minute
  if (blocks.plan.runs.size() > enough) blocks.plan.runs.resize(enough);
  for (PlannedRun& run : blocks.plan.runs) std::erase_if(run.settings, [](const Setting& s) { return s.key.empty(); });
  blocks.plan.stored_results.clear();
  (void)make_campaign(std::move(blocks.plan));
  return {};
} catch (const ConfigError& error) {
  return fmt::format("\n{}", error.what());
}

/// Reads their tables, one function a table.
class BlockReader : private PlanInput {
 public:
  explicit BlockReader(const std::filesystem::path& file) : PlanInput(file) {
    blocks_.plan.file = file.string();
    blocks_.labels = common_labels();
  }

  PlanBlocks read(std::string_view text) {
    load(text);
    for (const File* file : inner_first()) read_lists(file->root);
    for (const File* file : inner_first()) read_settings(*file);
    if (parameters_) blocks_.crossings.push_back({"", axes(*parameters_, "parameters:"), {}, {}});
    for (const File& file : files()) read_runs(file);
    const toml::source_region& top = files().front().root.source();
    if (blocks_.plan.base_name.empty() && valid())
      problem(top, "", "base is missing; give a case file, relative to the plan, or its tables as [base.material], ...");
    if (blocks_.crossings.empty() && blocks_.rows.empty() && valid())
      problem(top, "", "the plan has no runs; give [parameters], [[grid]], [[run]] or a table");
    try {
      throw_problems();
    } catch (const ConfigError& error) {
      throw ConfigError(error.what() + problems_of_cases(blocks_));
    }
    return std::move(blocks_);
  }

 private:
  void read_lists(const toml::table& root) {
    const toml::table* lists = table_at(root, "", "lists");
    if (lists == nullptr) return;
    for (const auto& [key, node] : *lists) {
      if (node.is_array() || node.is_table()) {
        lists_.insert_or_assign(std::string(key.str()), &node);
      } else {
        problem(key.source(), "[lists]",
                fmt::format("{} = {} is {}; give a list of values, or groups of settings: NAME = {{ key = value }}",
                            one_line(std::string(key.str())), shown(node), kind_of(node)));
      }
    }
  }

  std::vector<Rule> rules(const toml::table& table, const std::string& where) {
    std::vector<Rule> list;
    int number = 0;
    for (const toml::table* entry : tables_at(table, where, "when", most_rules)) {
      const std::string here = fmt::format("{}[[when]] {}", where.empty() ? "" : where + " ", ++number);
      only(*entry, here, {"match", "set"});
      Rule rule;
      if (const toml::source_region& source = entry->source(); source.path && *source.path == blocks_.plan.file)
        rule.place = fmt::format("{}:{}: {}", blocks_.plan.file, source.begin.line, here);
      if (const toml::table* match = table_at(*entry, here, "match")) {
        std::vector<std::string> seen;
        for (const Entry& e : in_order(*match)) {
          if (given_up()) break;
          const bool is_value = !e.node->is_array() && e.key.find(',') == std::string::npos;
          rule.match.push_back(is_value ? std::vector<Choice>{{"", {{key_meant(e.key, e.source, here + " match:"), toml_text(*e.node)}}}}
                                        : choices_of(e, here + " match:"));
          keys_once(rule.match.back(), e, here + " match:", seen);
        }
      }
      if (!entry->contains("match")) problem(entry->source(), here, "has no match; say which runs it is for: match = { key = [values] }");
      rule.set = settings(*entry, here, "set");
      if (!entry->contains("set")) problem(entry->source(), here, "has no set; say what these runs take: set = { key = value }");
      list.push_back(std::move(rule));
    }
    return list;
  }

  /// "a, b": the keys that take their values together.
  std::vector<std::string> keys_together(const Entry& e, const std::string& here) {
    std::vector<std::string> keys;
    std::istringstream names(e.key);
    for (std::string key; std::getline(names, key, ',');) {
      key = key_meant(std::string(trimmed(key, " ")), e.source, here);
      once(key, keys, e.source, here);
      keys.push_back(key);
    }
    return keys;
  }

  /// The settings that a value gives to the keys; none unless it has one for each.
  std::vector<Setting> settings_of(const Entry& e, const toml::node& value, const std::vector<std::string>& keys, const std::string& here) {
    if (keys.size() == 1) return {{keys.front(), toml_text(value)}};
    const toml::array* together = value.as_array();
    if (together == nullptr || together->size() != keys.size()) {
      problem(
          value.source(), here,
          fmt::format("{}: {} does not give the {} keys a value each; write a list of {}", e.key, shown(value), keys.size(), keys.size()));
      return {};
    }
    std::vector<Setting> set;
    for (std::size_t i = 0; i < keys.size(); ++i) set.push_back({keys[i], toml_text(*together->get(i))});
    return set;
  }

  /// The list that an axis names; null if there is none.
  const toml::node* list_named(const std::string& name, const Entry& e, const std::string& here) {
    if (const auto found = lists_.find(name); found != lists_.end()) return found->second;
    std::vector<std::string> names;
    for (const auto& [known, list] : lists_) names.push_back(known);
    const std::string meant = nearest_word(name, names);
    problem(e.source, here,
            fmt::format("{} = {}: [lists] has no such list; {}", e.key, shown(*e.node),
                        !meant.empty() ? fmt::format("did you mean \"{}\"?", meant) : "give a list of values, or the name of a list"));
    return nullptr;
  }

  /// The groups of a list, each a table of settings, in the order of the file.
  std::vector<Choice> groups(const toml::table& list, const std::string& where) {
    std::vector<const toml::key*> names;
    for (const auto& [name, group] : list) names.push_back(&name);
    std::ranges::sort(names, {}, [](const toml::key* k) { return std::tuple(k->source().begin.line, k->source().begin.column); });
    std::vector<Choice> rows;
    for (const toml::key* key : names) {
      const std::string name(key->str());
      if (name.empty() || name != file_name_part(name))
        problem(key->source(), where,
                fmt::format("group \"{}\": its name is part of names of runs; use letters and digits", one_line(name)));
      rows.push_back({name, settings(list, where, name)});
    }
    return rows;
  }

  /// Reports keys of an axis that one before it has. @param earlier  their keys, to which those of this one are added
  void keys_once(const std::vector<Choice>& choices, const Entry& e, const std::string& here, std::vector<std::string>& earlier) {
    std::set<std::string> keys;
    for (const Choice& choice : choices) {
      for (const Setting& s : choice.settings) keys.insert(s.key);
    }
    for (const std::string& key : keys) once(key, earlier, e.source, here);
    earlier.insert(earlier.end(), keys.begin(), keys.end());
  }

  /// The choices of an axis.
  std::vector<Choice> choices_of(const Entry& e, const std::string& here) {
    const toml::node* choices = e.node;
    if (const auto name = choices->value_exact<std::string>()) {
      choices = list_named(*name, e, here);
      if (choices == nullptr) return {};
      if (const toml::table* list = choices->as_table()) {
        if (list->empty()) problem(e.source, here, fmt::format("{} = \"{}\": [lists.{}] is empty; give it groups", e.key, *name, *name));
        return groups(*list, fmt::format("[lists.{}]", *name));
      }
    }
    const std::vector<std::string> keys = keys_together(e, here);
    const toml::array* values = choices->as_array();
    if (values == nullptr || values->empty()) {
      problem(e.source, here,
              fmt::format("{} = {} is {}; give a list of values", e.key, shown(*e.node), values != nullptr ? "empty" : kind_of(*choices)));
      return {};
    }
    std::vector<Choice> rows;
    std::set<std::vector<std::string>> given;
    for (const toml::node& value : *values) {
      if (given_up()) break;
      std::vector<Setting> set = settings_of(e, value, keys, here);
      if (set.empty()) continue;
      std::vector<std::string> texts;
      for (const Setting& s : set) texts.push_back(s.value);
      if (!given.insert(texts).second)
        problem(value.source(), here, fmt::format("{}: {} is given twice; give each value once", e.key, shown(value)));
      rows.push_back({"", std::move(set)});
    }
    return rows;
  }

  std::vector<std::vector<Choice>> axes(const std::vector<Entry>& entries, const std::string& here) {
    std::vector<std::vector<Choice>> list;
    std::vector<std::string> seen;
    for (const Entry& e : entries) {
      if (given_up()) break;
      list.push_back(choices_of(e, here));
      keys_once(list.back(), e, here, seen);
    }
    return list;
  }

  std::string folder_name(const toml::table& table, const std::string& where) {
    std::string name = text(table, where, "name");
    if (const std::string why = name_problem(name); !name.empty() && !why.empty())
      problem(table.get("name")->source(), where, "name = " + why);
    return name;
  }

  /// A cell as TOML: a bare word is a string.
  static std::string toml_value(const std::string& cell) {
    const std::string text = "value = " + cell;
    try {
      config::check_text(text, "");
      const toml::table parsed = toml::parse(text);
      if (parsed.size() == 1) return cell.find('#') == std::string::npos ? cell : toml_text(*parsed.get("value"));  // without its comment
    } catch (const toml::parse_error&) {                                                                            // not a value
    } catch (const ConfigError&) {  // no text for the parser
    }
    return toml_text(toml::value<std::string>(cell));
  }

  void read_csv_rows(const std::filesystem::path& path, const toml::source_region& source) {
    const Table table = Table::read(path);
    if (table.rows() > most_runs || table.columns().size() > most_settings)
      return problem(source, "",
                     fmt::format("table: {} rows of {} columns; at most {} of {} are possible", table.rows(), table.columns().size(),
                                 most_runs, most_settings));
    const std::string where = fmt::format("table {}:", path.filename().string());
    std::vector<std::string> keys;
    std::vector<std::vector<std::string>> cells;
    for (const std::string& column : table.columns()) {
      if (column == "name") continue;
      keys.push_back(key_meant(column, source, where));
      cells.push_back(table.text(column));
    }
    const std::vector<std::string> names = table.has("name") ? table.text("name") : std::vector<std::string>(table.rows());
    for (std::size_t i = 0; i < table.rows() && !given_up(); ++i) {
      NamedSettings row{names[i], {}};
      if (const std::string why = name_problem(names[i]); !names[i].empty() && !why.empty())
        problem(source, where, fmt::format("row {}: name = {}", i + 1, why));
      std::vector<std::string> filled;
      for (std::size_t k = 0; k < keys.size(); ++k) {
        if (cells[k][i].empty()) continue;
        once(keys[k], filled, source, fmt::format("{} row {}:", where, i + 1));
        filled.push_back(keys[k]);
        put(row.settings, {keys[k], toml_value(cells[k][i])});
      }
      blocks_.rows.push_back(std::move(row));
    }
  }

  /// base = { ... }, or [base.material] and so on
  void read_base_tables(const toml::table& tables, const std::string& file) {
    blocks_.base = tables;
    blocks_.base.is_inline(false);  // base = { ... } in the plan is the root of a case
    blocks_.plan.base_text = config::document_text(blocks_.base);
    blocks_.plan.base_name = file + ", [base]";
  }

  /// base = "case.toml"
  void read_base_file(const std::filesystem::path& path, const toml::source_region& source) {
    blocks_.plan.base_name = path.string();
    try {
      blocks_.plan.base_text = config::bounded_file_text(path);
      config::check_text(blocks_.plan.base_text, path.string());
      blocks_.base = toml::parse(blocks_.plan.base_text, path.string());
    } catch (const toml::parse_error& error) {
      problem(source, "", "base " + config::syntax_error(error, path.string()));
    } catch (const Error& error) {
      problem(source, "", fmt::format("base: {}", error.what()));
    }
  }

  void read_base(const File& file) {
    const toml::node* base = file.root.get("base");
    if (base == nullptr) return;
    if (const toml::table* tables = base->as_table()) {
      read_base_tables(*tables, file.path.string());
    } else if (const auto name = base->value_exact<std::string>()) {
      read_base_file(file.beside(*name), base->source());
    } else {
      problem(base->source(), "", fmt::format("base is {}; give a case file in quotes, or tables", kind_of(*base)));
    }
  }

  void read_order(const toml::table& root) {
    const std::string order = text(root, "", "order");
    if (order.empty()) return;
    if (order != "longest_first" && order != "plan")
      problem(root.get("order")->source(), "", fmt::format("order = \"{}\"; give \"longest_first\" or \"plan\"", one_line(order)));
    blocks_.plan.longest_first = order != "plan";
  }

  void read_keep(const toml::table& root) {
    CampaignPlan& plan = blocks_.plan;
    const std::vector<std::string> files{"frames", "final", "checkpoint"};
    if (root.contains("keep")) plan.keep_frames = plan.keep_final = plan.keep_checkpoint = false;
    for (const std::string& word : words(root, "", "keep")) {
      if (std::ranges::find(files, word) == files.end())
        problem(root.get("keep")->source(), "",
                fmt::format("keep: there is no \"{}\"; give some of \"{}\"", word, fmt::join(files, "\", \"")));
      plan.keep_frames = plan.keep_frames || word == "frames";
      plan.keep_final = plan.keep_final || word == "final";
      plan.keep_checkpoint = plan.keep_checkpoint || word == "checkpoint";
    }
  }

  void read_labels(const toml::table& root) {
    const toml::table* labels = table_at(root, "", "labels");
    if (labels == nullptr) return;
    for (const Entry& e : in_order(*labels)) {
      if (given_up()) break;
      const auto word = e.node->value_exact<std::string>();
      const std::string key = key_meant(e.key, e.source, "[labels]");
      if (!word || *word != file_name_part(*word)) {
        problem(e.source, "[labels]", fmt::format("{} = {}; give letters and digits in quotes", e.key, shown(*e.node)));
      } else {
        blocks_.labels[key] = *word;
      }
    }
  }

  void read_slurm(const toml::table& root) {
    const toml::table* slurm = table_at(root, "", "slurm");
    if (slurm == nullptr) return;
    only(*slurm, "[slurm]", {"partition", "account", "qos", "time_limit", "memory", "options"});
    SlurmSpec& s = blocks_.plan.slurm;
    const auto word = [&](const char* name, const std::string& preset) { return text(*slurm, "[slurm]", name, preset); };
    s = {word("partition", s.partition),   word("account", s.account), word("qos", s.qos),
         word("time_limit", s.time_limit), word("memory", s.memory),   words(*slurm, "[slurm]", "options", s.options)};
  }

  void read_stored_results(const File& file) {
    if (file.root.contains("stored_results")) blocks_.plan.stored_results.clear();
    for (const std::string& name : words(file.root, "", "stored_results")) {
      blocks_.plan.stored_results.push_back(std::filesystem::absolute(file.beside(name)).lexically_normal());
      if (!std::filesystem::is_regular_file(blocks_.plan.stored_results.back())) {
        problem(file.root.get("stored_results")->source(), "",
                fmt::format("stored_results: there is no file \"{}\"; give a results.csv, relative to the plan", one_line(name)));
      }
    }
  }

  /// An axis of the plan replaces the one with the same key of a file that it includes.
  void read_parameters(const toml::table& root) {
    const toml::table* table = table_at(root, "", "parameters");
    if (table == nullptr) return;
    if (table->empty()) problem(table->source(), "", "[parameters] is empty; give lists to cross, or write a [[run]]");
    if (!parameters_) parameters_.emplace();
    for (const Entry& e : in_order(*table)) {
      const auto there = std::ranges::find(*parameters_, e.key, &Entry::key);
      if (there == parameters_->end()) {
        parameters_->push_back(e);
      } else {
        *there = e;
      }
    }
  }

  void read_crossings(const toml::table& root) {
    int number = 0;
    for (const toml::table* entry : tables_at(root, "", "grid")) {
      const std::string where = fmt::format("[[grid]] {}", ++number);
      only(*entry, where, {"name", "parameters", "set", "when"});
      const toml::table* parameters = table_at(*entry, where, "parameters");
      if (!entry->contains("parameters") || (parameters != nullptr && parameters->empty()))
        problem(entry->source(), where, "has no parameters; give lists to cross, or write a [[run]]");
      blocks_.crossings.push_back(
          {folder_name(*entry, where),
           parameters != nullptr ? axes(in_order(*parameters), where + " parameters:") : std::vector<std::vector<Choice>>{},
           settings(*entry, where, "set"), rules(*entry, where)});
    }
  }

  void read_runs(const File& file) {
    const toml::table& root = file.root;
    read_crossings(root);
    int number = 0;
    for (const toml::table* entry : tables_at(root, "", "run")) {
      const std::string where = fmt::format("[[run]] {}", ++number);
      only(*entry, where, {"name", "set"});
      const NamedSettings row{folder_name(*entry, where), settings(*entry, where, "set")};
      if (row.name.empty() && row.settings.empty()) problem(entry->source(), where, "is empty; give it a name, or keys in set");
      blocks_.rows.push_back(row);
    }
    const std::string name = text(root, "", "table");
    if (name.empty()) return;
    try {
      read_csv_rows(file.beside(name), root.get("table")->source());
    } catch (const IoError& error) {
      problem(root.get("table")->source(), "", fmt::format("table: {}", error.what()));
    }
  }

  /// All but the runs. Later files override earlier ones.
  void read_settings(const File& file) {
    const toml::table& root = file.root;
    only(root, "",
         {"format_version", "include", "title", "base", "ranks",      "launcher", "threads", "retries", "order", "keep",
          "table",          "lists",   "set",   "when", "parameters", "grid",     "run",     "labels",  "slurm", "stored_results"});
    if (integer(root, "format_version", 1, plan_format_version, plan_format_version) != plan_format_version) return;
    CampaignPlan& plan = blocks_.plan;
    plan.title = text(root, "", "title", plan.title);
    plan.ranks = integer(root, "ranks", 1, most_ranks_of_a_run, plan.ranks);
    plan.launcher = words(root, "", "launcher", plan.launcher);
    const auto says_how_many = [](const std::string& word) { return word.find(ranks_placeholder) != std::string::npos; };
    if (root.contains("launcher") && !plan.launcher.empty() && std::ranges::none_of(plan.launcher, says_how_many)) {
      problem(root.get("launcher")->source(), "",
              fmt::format("launcher: no word says how many ranks it starts; give one with {}", ranks_placeholder));
    }
    plan.threads = integer(root, "threads", 1, most_threads_of_a_run, plan.threads);
    plan.retries = integer(root, "retries", 0, most_retries, plan.retries);
    read_base(file);
    read_order(root);
    read_keep(root);
    read_labels(root);
    read_slurm(root);
    read_stored_results(file);
    put(blocks_.set, settings(root, "", "set"));
    for (Rule& rule : rules(root, "")) blocks_.rules.push_back(std::move(rule));
    read_parameters(root);
  }

  std::map<std::string, const toml::node*> lists_;  ///< values, or groups of settings
  std::optional<std::vector<Entry>> parameters_;    ///< [parameters]
  PlanBlocks blocks_;
};

}  // namespace

CampaignPlan parse_plan(std::string_view text, const std::filesystem::path& file) {
  PlanBlocks blocks = BlockReader(file).read(text);
  std::set<const Rule*> matched;
  blocks.plan.runs = expand(blocks, &matched);
  std::string unmatched;
  const auto check = [&](const std::vector<Rule>& rules) {
    for (const Rule& rule : rules) {
      if (rule.place.empty() || matched.contains(&rule)) continue;
      unmatched += fmt::format(
          "{}{} matches no run; compare its values with those of the runs, [set] and the base case, which has to give a key itself: "
          "a default does not match, nor does what another [[when]] sets",
          unmatched.empty() ? "" : "\n", rule.place);
    }
  };
  check(blocks.rules);
  for (const Crossing& crossing : blocks.crossings) check(crossing.rules);
  if (!unmatched.empty()) throw ConfigError(unmatched + problems_of_cases(blocks));
  return std::move(blocks.plan);
}

CampaignPlan read_plan(const std::filesystem::path& file) { return parse_plan(config::bounded_file_text(file), file); }

}  // namespace mpm
