#include "mpm/io/campaign_plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <map>
#include <optional>
#include <regex>
#include <sstream>
#include <tuple>

#include "config_guard.hpp"
#include "config_keys.hpp"
#include "mpm/io/schema.hpp"
#include "mpm/io/table.hpp"
#include "toml_text.hpp"

namespace mpm {

namespace {

using config::kind_of;
using config::one_line;
using config::shown;
using config::toml_text;

constexpr int most_threads = 1024, most_retries = 100;

/// Keys joined by commas, and the rows of values that they take together.
struct Parameter {
  std::vector<std::string> keys;
  std::vector<std::vector<std::string>> rows;
};

/// [[when]]: the settings of runs that have one of certain values.
struct Rule {
  std::vector<std::pair<std::string, std::vector<std::string>>> match;
  std::vector<Setting> set;
};

/// [parameters] at the top, or a [[grid]].
struct Grid {
  std::string name;
  std::vector<Parameter> parameters;
  std::vector<Setting> set;
  std::vector<Rule> rules;
};

/// [[run]], or a row of the table.
struct Row {
  std::string name;
  std::vector<Setting> set;
};

/// How the common keys are called in names.
const std::map<std::string, std::string>& common_labels() {
  static const std::map<std::string, std::string> labels{
      {"material.model", ""},
      {"material.critical_state_slope", "m"},
      {"material.cohesion_beta", "beta"},
      {"material.hardening_xi", "xi"},
      {"conveyor.froude_number", "fr"},
      {"conveyor.velocity_m_s", "v"},
      {"conveyor.flow_height_m", "h"},
      {"conveyor.feed", ""},
      {"obstacle.width_m", "w"},
      {"obstacle.friction", "mu"},
      {"obstacle.friction_ratio", "mur"},
      {"obstacle.shape", ""},
      {"numerics.cell_size_m", "dx"},
      {"numerics.slope_deg", "slope"},
      {"numerics.transfer", ""},
      {"numerics.particles_per_cell", "ppc"},
      {"output.duration_s", "t"},
  };
  return labels;
}

/// Letters, digits and . _ + - stay, everything else becomes one '-'.
std::string file_name_part(const std::string& text) {
  std::string part;
  for (const char c : text) {
    const bool safe = (std::isalnum(static_cast<unsigned char>(c)) != 0) || c == '.' || c == '_' || c == '+' || c == '-';
    if (safe) {
      part += c;
    } else if (!part.empty() && part.back() != '-') {
      part += '-';
    }
  }
  while (part.ends_with('-')) part.pop_back();
  return part;
}

/// A TOML value as a name says it: 3.0 is 3.
std::string value_in_name(const std::string& value) {
  const toml::table parsed = toml::parse("value = " + value);
  const toml::node& node = *parsed.get("value");
  if (const auto x = node.value<double>(); x && node.is_number()) return file_name_part(format_number(*x));
  if (const auto text = node.value_exact<std::string>()) return file_name_part(*text);
  return file_name_part(value);
}

/// The same number however it is written, or the same text.
bool same_value(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const toml::table left = toml::parse("value = " + a), right = toml::parse("value = " + b);
  const toml::node &x = *left.get("value"), &y = *right.get("value");
  return x.is_number() && y.is_number() && x.value<double>() == y.value<double>();
}

void put(std::vector<Setting>& settings, const Setting& s) {
  const auto there = std::ranges::find(settings, s.key, &Setting::key);
  if (there == settings.end()) {
    settings.push_back(s);
  } else {
    there->value = s.value;
  }
  // both give the speed: the later one stands alone, as with --set
  const std::string other = s.key == "conveyor.froude_number"  ? "conveyor.velocity_m_s"
                            : s.key == "conveyor.velocity_m_s" ? "conveyor.froude_number"
                                                               : "";
  std::erase_if(settings, [&](const Setting& o) { return o.key == other; });
}

void put(std::vector<Setting>& settings, const std::vector<Setting>& more) {
  for (const Setting& s : more) put(settings, s);
}

class PlanReader {
 public:
  explicit PlanReader(const std::filesystem::path& file) : file_(file) {}

  CampaignPlan read(std::string_view text) {
    config::check_text(text, file_.string());
    toml::table root;
    try {
      root = toml::parse(text, file_.string());
    } catch (const toml::parse_error& error) {
      const auto& at = error.source().begin;
      throw ConfigError(
          fmt::format("{}:{}:{}: not valid TOML: {}", file_.string(), at.line, at.column, config::printable(error.description())));
    }
    read_root(root);
    throw_faults();
    expand();
    return std::move(plan_);
  }

 private:
  // ---- faults ----------------------------------------------------------------------------------------------------------------------
  struct Fault {
    std::uint32_t line, column;
    std::string text;
  };

  void fault(const toml::source_region& source, const std::string& where, const std::string& text) {
    const auto& at = source.begin;
    faults_.push_back({std::max<std::uint32_t>(1, at.line), std::max<std::uint32_t>(1, at.column),
                       where.empty() ? text : fmt::format("{} {}", where, text)});
  }

  void throw_faults() {
    if (faults_.empty()) return;
    std::ranges::stable_sort(faults_, {}, [](const Fault& f) { return std::tie(f.line, f.column); });
    std::string message;
    for (const Fault& f : faults_)
      message += fmt::format("{}{}:{}:{}: {}", message.empty() ? "" : "\n", file_.string(), f.line, f.column, f.text);
    throw ConfigError(message);
  }

  // ---- values ----------------------------------------------------------------------------------------------------------------------
  /// Reports every key of a table that is none of the permitted ones.
  void only(const toml::table& table, const std::string& where, const std::vector<std::string>& permitted) {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      if (std::ranges::find(permitted, name) != permitted.end()) continue;
      const std::string meant = nearest_word(name, permitted);
      const std::string remedy = !meant.empty()                        ? fmt::format("did you mean {}?", meant)
                                 : name.find('.') != std::string::npos ? "keys of a case stand in set or parameters"
                                                                       : fmt::format("there is {}", fmt::join(permitted, ", "));
      fault(key.source(), where, fmt::format("unknown key {}; {}", one_line(name), remedy));
    }
  }

  std::string text(const toml::table& table, const std::string& where, const char* name) {
    const toml::node* node = table.get(name);
    if (node == nullptr) return {};
    if (const auto value = node->value_exact<std::string>()) return *value;
    fault(node->source(), where, fmt::format("{} = {} is {}; give a string in quotes", name, shown(*node), kind_of(*node)));
    return {};
  }

  int integer(const toml::table& table, const char* name, int low, int high, int preset) {
    const toml::node* node = table.get(name);
    if (node == nullptr) return preset;
    const auto value = node->value_exact<std::int64_t>();
    if (value && *value >= low && *value <= high) return static_cast<int>(*value);
    fault(node->source(), "", fmt::format("{} = {}; give an integer in [{}, {}]", name, shown(*node), low, high));
    return preset;
  }

  std::vector<std::string> words(const toml::table& table, const std::string& where, const char* name) {
    const toml::node* node = table.get(name);
    if (node == nullptr) return {};
    std::vector<std::string> list;
    if (const toml::array* array = node->as_array()) {
      for (const toml::node& element : *array) {
        if (const auto word = element.value_exact<std::string>()) list.push_back(*word);
      }
      if (list.size() == array->size()) return list;
    }
    fault(node->source(), where, fmt::format("{} = {}; give a list of strings", name, shown(*node)));
    return {};
  }

  const toml::table* table_at(const toml::table& table, const std::string& where, const char* name) {
    const toml::node* node = table.get(name);
    if (node == nullptr) return nullptr;
    if (node->is_table()) return node->as_table();
    fault(node->source(), where, fmt::format("{} = {} is {}; give a table", name, shown(*node), kind_of(*node)));
    return nullptr;
  }

  /// The entries of [[name]].
  std::vector<const toml::table*> tables_at(const toml::table& table, const std::string& where, const char* name) {
    const toml::node* node = table.get(name);
    if (node == nullptr) return {};
    std::vector<const toml::table*> entries;
    if (const toml::array* list = node->as_array()) {
      for (const toml::node& element : *list) {
        if (const toml::table* entry = element.as_table()) entries.push_back(entry);
      }
      if (entries.size() == list->size()) return entries;
    }
    fault(node->source(), where, fmt::format("{0} is {1}; write [[{0}]] with two brackets, once for each", name, kind_of(*node)));
    return {};
  }

  /// The key of a case; reports one that there is not.
  bool known_key(const std::string& key, const toml::source_region& source, const std::string& where) {
    static const std::vector<std::string> keys = [] {
      std::vector<std::string> names;
      for (const KeyInfo& k : schema_keys()) {
        const auto table = std::ranges::find(schema_tables(), k.table, &TableInfo::name);
        if (table->in_case) names.push_back(config::key_path(k.table, k.name));
      }
      return names;
    }();
    static const std::regex index(R"(\[[0-9]+\])");
    constexpr std::size_t longest = 200;  // characters; the regular expression descends once a character
    const std::string plain = key.size() > longest ? key : std::regex_replace(key, index, "");
    if (std::ranges::find(keys, plain) != keys.end()) return true;
    std::string meant = nearest_word(plain, keys);
    for (const std::string& k : keys) {
      if (k.ends_with(fmt::format(".{}", plain))) meant = k;
    }
    fault(source, where,
          fmt::format("unknown key {}; {}", one_line(key),
                      meant.empty() ? "see `mpm schema`, and write table.key" : fmt::format("did you mean \"{}\"?", meant)));
    return false;
  }

  /// Keys may be given as "table.key" in quotes or as dotted keys, which TOML makes tables of. In the order of the file, which a TOML
  /// table has lost.
  struct Entry {
    std::string key;
    const toml::node* node;
    toml::source_region source;
  };

  static void flatten(const toml::table& table, const std::string& prefix, std::vector<Entry>& entries) {
    for (const auto& [key, node] : table) {
      const std::string path = config::key_path(prefix, std::string(key.str()));
      if (const toml::table* inner = node.as_table()) {
        flatten(*inner, path, entries);
      } else {
        entries.push_back({path, &node, key.source()});
      }
    }
  }

  static std::vector<Entry> in_order(const toml::table& table) {
    std::vector<Entry> entries;
    flatten(table, "", entries);
    std::ranges::stable_sort(entries, {}, [](const Entry& e) { return std::tuple(e.source.begin.line, e.source.begin.column); });
    return entries;
  }

  // ---- tables ----------------------------------------------------------------------------------------------------------------------
  std::vector<Setting> settings(const toml::table& table, const std::string& where, const char* name) {
    std::vector<Setting> list;
    if (const toml::table* set = table_at(table, where, name)) {
      for (const Entry& e : in_order(*set)) {
        if (known_key(e.key, e.source, fmt::format("{}{}{}:", where, where.empty() ? "" : " ", name)))
          put(list, {e.key, toml_text(*e.node)});
      }
    }
    return list;
  }

  std::vector<Rule> rules(const toml::table& table, const std::string& where) {
    std::vector<Rule> list;
    int number = 0;
    for (const toml::table* entry : tables_at(table, where, "when")) {
      const std::string here = fmt::format("{}[[when]] {}", where.empty() ? "" : where + " ", ++number);
      only(*entry, here, {"match", "set"});
      Rule rule;
      if (const toml::table* match = table_at(*entry, here, "match")) {
        for (const Entry& e : in_order(*match)) {
          if (!known_key(e.key, e.source, here + " match:")) continue;
          std::vector<std::string> values;
          if (const toml::array* choices = e.node->as_array()) {
            for (const toml::node& value : *choices) values.push_back(toml_text(value));
          } else {
            values.push_back(toml_text(*e.node));
          }
          rule.match.emplace_back(e.key, values);
        }
      }
      if (!entry->contains("match")) fault(entry->source(), here, "has no match; say which runs it is for: match = { key = [values] }");
      rule.set = settings(*entry, here, "set");
      if (!entry->contains("set")) fault(entry->source(), here, "has no set; say what these runs take: set = { key = value }");
      list.push_back(std::move(rule));
    }
    return list;
  }

  std::vector<Parameter> parameters(const toml::table& table, const std::string& where) {
    std::vector<Parameter> list;
    const toml::table* crossed = table_at(table, where, "parameters");
    if (crossed == nullptr) return list;
    std::vector<std::string> seen;
    for (const Entry& e : in_order(*crossed)) {
      const std::string here = fmt::format("{}{}parameters:", where, where.empty() ? "" : " ");
      Parameter p;
      std::istringstream names(e.key);
      bool known = true;
      for (std::string key; std::getline(names, key, ',');) {
        const auto first = key.find_first_not_of(' ');
        key = first == std::string::npos ? "" : key.substr(first, key.find_last_not_of(' ') - first + 1);
        known = known_key(key, e.source, here) && known;
        if (std::ranges::find(seen, key) != seen.end()) fault(e.source, here, fmt::format("{} stands twice; give it once", key));
        seen.push_back(key);
        p.keys.push_back(key);
      }
      const toml::array* values = e.node->as_array();
      if (values == nullptr || values->empty()) {
        fault(e.source, here,
              fmt::format("{} = {} is {}; give a list of values", e.key, shown(*e.node), values != nullptr ? "empty" : kind_of(*e.node)));
        continue;
      }
      for (const toml::node& value : *values) {
        std::vector<std::string> row;
        if (p.keys.size() == 1) {
          row.push_back(toml_text(value));
        } else if (const toml::array* together = value.as_array(); together != nullptr && together->size() == p.keys.size()) {
          for (const toml::node& part : *together) row.push_back(toml_text(part));
        } else {
          fault(value.source(), here,
                fmt::format("{}: {} does not give the {} keys a value each; write a list of {}", e.key, shown(value), p.keys.size(),
                            p.keys.size()));
          continue;
        }
        if (std::ranges::find(p.rows, row) != p.rows.end())
          fault(value.source(), here, fmt::format("{}: {} stands twice; give each value once", e.key, shown(value)));
        p.rows.push_back(std::move(row));
      }
      if (known) list.push_back(std::move(p));
    }
    return list;
  }

  std::string folder_name(const toml::table& table, const std::string& where) {
    std::string name = text(table, where, "name");
    const bool usable = name == file_name_part(name) && !name.starts_with('.') && name.size() <= 200;
    if (!name.empty() && !usable) {
      fault(table.get("name")->source(), where,
            fmt::format("name = \"{}\" names no folder; use letters, digits, '.', '_', '+' and '-', such as \"{}\"", one_line(name),
                        file_name_part(name)));
    }
    return name;
  }

  void read_csv_rows(const std::filesystem::path& path, const toml::source_region& source) {
    const Table table = Table::read(path);
    const std::string where = fmt::format("table {}:", path.filename().string());
    std::vector<std::string> keys;
    for (const std::string& column : table.columns()) {
      if (column != "name" && known_key(column, source, where)) keys.push_back(column);
    }
    const std::vector<std::string> names = table.has("name") ? table.text("name") : std::vector<std::string>(table.rows());
    std::vector<std::vector<std::string>> cells;
    cells.reserve(keys.size());
    for (const std::string& key : keys) cells.push_back(table.text(key));
    for (std::size_t i = 0; i < table.rows(); ++i) {
      Row row{names[i], {}};
      if (names[i] != file_name_part(names[i]))
        fault(source, where,
              fmt::format("row {}: name \"{}\" names no folder; use letters, digits, '.', '_', '+' and '-'", i + 1, one_line(names[i])));
      for (std::size_t k = 0; k < keys.size(); ++k) {
        if (cells[k][i].empty()) continue;
        std::string value = cells[k][i];
        try {
          if (toml::parse("value = " + value).size() != 1) throw ConfigError("more than a value");
        } catch (const std::exception&) {  // a bare word
          value = toml_text(toml::value<std::string>(value));
        }
        put(row.set, {keys[k], value});
      }
      rows_.push_back(std::move(row));
    }
  }

  void read_base(const toml::table& root) {
    const toml::node* base = root.get("base");
    if (base == nullptr) {
      fault(root.source(), "", "base is missing; give a case file, relative to the plan, or its tables as [base.material], ...");
    } else if (const toml::table* tables = base->as_table()) {
      base_ = *tables;
      base_.is_inline(false);  // base = { ... } in the plan is the root of a case
      std::ostringstream out;
      out << toml::toml_formatter(base_, toml::toml_formatter::default_flags & ~toml::format_flags::allow_literal_strings);
      plan_.base_text = out.str();
      plan_.base_name = file_.string() + ", [base]";
    } else if (const auto name = base->value_exact<std::string>()) {
      const auto path = file_.parent_path() / *name;
      try {
        plan_.base_text = config::bounded_file_text(path);
        config::check_text(plan_.base_text, path.string());
        base_ = toml::parse(plan_.base_text, path.string());
      } catch (const toml::parse_error& error) {
        const auto& at = error.source().begin;
        fault(base->source(), "",
              fmt::format("base {}:{}:{}: not valid TOML: {}", path.string(), at.line, at.column, config::printable(error.description())));
      } catch (const Error& error) {
        fault(base->source(), "", fmt::format("base: {}", error.what()));
      }
      plan_.base_name = path.string();
    } else {
      fault(base->source(), "", fmt::format("base is {}; give a case file in quotes, or tables", kind_of(*base)));
    }
  }

  void read_root(const toml::table& root) {
    only(root, "",
         {"format_version", "title", "base", "threads", "retries", "order", "keep", "table", "set", "when", "parameters", "grid", "run",
          "labels", "slurm"});
    if (integer(root, "format_version", 1, plan_format_version, plan_format_version) != plan_format_version) return;
    plan_.title = text(root, "", "title");
    plan_.threads = integer(root, "threads", 1, most_threads, plan_.threads);
    plan_.retries = integer(root, "retries", 0, most_retries, plan_.retries);
    read_base(root);
    if (const std::string order = text(root, "", "order"); !order.empty()) {
      if (order != "longest_first" && order != "plan")
        fault(root.get("order")->source(), "", fmt::format("order = \"{}\"; give \"longest_first\" or \"plan\"", one_line(order)));
      plan_.longest_first = order != "plan";
    }
    const std::vector<std::string> files{"frames", "final", "checkpoint"};
    for (const std::string& word : words(root, "", "keep")) {
      if (std::ranges::find(files, word) == files.end())
        fault(root.get("keep")->source(), "",
              fmt::format("keep: there is no \"{}\"; give some of \"{}\"", word, fmt::join(files, "\", \"")));
      plan_.keep_frames = plan_.keep_frames || word == "frames";
      plan_.keep_final = plan_.keep_final || word == "final";
      plan_.keep_checkpoint = plan_.keep_checkpoint || word == "checkpoint";
    }
    labels_ = common_labels();
    if (const toml::table* labels = table_at(root, "", "labels")) {
      for (const Entry& e : in_order(*labels)) {
        const auto word = e.node->value_exact<std::string>();
        if (!known_key(e.key, e.source, "[labels]")) continue;
        if (!word || *word != file_name_part(*word)) {
          fault(e.source, "[labels]", fmt::format("{} = {}; give letters and digits in quotes", e.key, shown(*e.node)));
        } else {
          labels_[e.key] = *word;
        }
      }
    }
    if (const toml::table* slurm = table_at(root, "", "slurm")) {
      only(*slurm, "[slurm]", {"partition", "account", "qos", "time_limit", "memory", "options"});
      plan_.slurm = {text(*slurm, "[slurm]", "partition"),  text(*slurm, "[slurm]", "account"), text(*slurm, "[slurm]", "qos"),
                     text(*slurm, "[slurm]", "time_limit"), text(*slurm, "[slurm]", "memory"),  words(*slurm, "[slurm]", "options")};
    }
    set_ = settings(root, "", "set");
    rules_ = rules(root, "");
    if (root.contains("parameters")) grids_.push_back({"", parameters(root, ""), {}, {}});
    int number = 0;
    for (const toml::table* entry : tables_at(root, "", "grid")) {
      const std::string where = fmt::format("[[grid]] {}", ++number);
      only(*entry, where, {"name", "parameters", "set", "when"});
      if (!entry->contains("parameters")) fault(entry->source(), where, "has no parameters; give lists to cross, or write a [[run]]");
      grids_.push_back({folder_name(*entry, where), parameters(*entry, where), settings(*entry, where, "set"), rules(*entry, where)});
    }
    number = 0;
    for (const toml::table* entry : tables_at(root, "", "run")) {
      const std::string where = fmt::format("[[run]] {}", ++number);
      only(*entry, where, {"name", "set"});
      rows_.push_back({folder_name(*entry, where), settings(*entry, where, "set")});
      if (rows_.back().name.empty() && rows_.back().set.empty()) fault(entry->source(), where, "is empty; give it a name, or keys in set");
    }
    if (const std::string name = text(root, "", "table"); !name.empty()) {
      try {
        read_csv_rows(file_.parent_path() / name, root.get("table")->source());
      } catch (const IoError& error) {
        fault(root.get("table")->source(), "", fmt::format("table: {}", error.what()));
      }
    }
    if (grids_.empty() && rows_.empty() && faults_.empty())
      fault(root.source(), "", "the plan has no runs; give [parameters], [[grid]], [[run]] or a table");
  }

  // ---- from blocks to runs ---------------------------------------------------------------------------------------------------------
  [[nodiscard]] std::string label_and_value(const Setting& s) const {
    const auto label = labels_.find(s.key);
    const std::string short_name = label != labels_.end() ? label->second : file_name_part(s.key.substr(s.key.rfind('.') + 1));
    return short_name + value_in_name(s.value);
  }

  [[nodiscard]] std::string name_of(const std::string& block, const std::vector<Setting>& varied) const {
    std::string name = block;
    for (const Setting& s : varied) name += fmt::format("{}{}", name.empty() ? "" : "_", label_and_value(s));
    return name;
  }

  /// The value that a run has so far: its own, or the base's.
  [[nodiscard]] std::optional<std::string> value_of(const std::vector<Setting>& settings, const std::string& key) const {
    if (const auto s = std::ranges::find(settings, key, &Setting::key); s != settings.end()) return s->value;
    const auto node = base_.at_path(key);
    return node && !node.is_table() ? std::optional(toml_text(*node.node())) : std::nullopt;
  }

  /// What the rules give to a run that will have these settings.
  [[nodiscard]] std::vector<Setting> matched(const std::vector<Rule>& rules, const std::vector<Setting>& settings) const {
    std::vector<Setting> given;
    for (const Rule& rule : rules) {
      const bool holds = std::ranges::all_of(rule.match, [&](const auto& m) {
        const auto value = value_of(settings, m.first);
        return value && std::ranges::any_of(m.second, [&](const std::string& choice) { return same_value(*value, choice); });
      });
      if (holds) put(given, rule.set);
    }
    return given;
  }

  void add_run(std::string name, const std::vector<Setting>& block_set, const std::vector<Rule>& block_rules,
               const std::vector<Setting>& own) {
    std::vector<Setting> all = set_;
    put(all, block_set);
    put(all, own);
    PlannedRun run{std::move(name), set_};
    put(run.settings, matched(rules_, all));
    put(run.settings, block_set);
    put(run.settings, matched(block_rules, all));
    put(run.settings, own);
    plan_.runs.push_back(std::move(run));
  }

  void expand() {
    for (const Grid& grid : grids_) {
      constexpr std::size_t most_runs = 1'000'000;
      std::size_t count = 1;
      for (const Parameter& p : grid.parameters) {
        count *= p.rows.size();
        if (count > most_runs)
          throw ConfigError(fmt::format("{}: the lists of a crossing make more than {} runs; give shorter ones, or several plans",
                                        file_.string(), most_runs));
      }
      for (std::size_t i = 0; i < count; ++i) {
        std::vector<Setting> own;
        std::size_t stride = count;
        for (const Parameter& p : grid.parameters) {
          stride /= p.rows.size();
          const auto& row = p.rows[i / stride % p.rows.size()];
          for (std::size_t k = 0; k < p.keys.size(); ++k) own.push_back({p.keys[k], row[k]});
        }
        add_run(name_of(grid.name, own), grid.set, grid.rules, own);
      }
    }
    for (const Row& row : rows_) add_run(row.name.empty() ? name_of("", row.set) : row.name, {}, {}, row.set);
  }

  std::filesystem::path file_;
  CampaignPlan plan_;
  toml::table base_;
  std::map<std::string, std::string> labels_;
  std::vector<Setting> set_;
  std::vector<Rule> rules_;
  std::vector<Grid> grids_;
  std::vector<Row> rows_;
  std::vector<Fault> faults_;
};

std::string quoted(const std::string& text) { return toml_text(toml::value<std::string>(text)); }

}  // namespace

CampaignPlan parse_plan(std::string_view text, const std::filesystem::path& file) { return PlanReader(file).read(text); }

CampaignPlan read_plan(const std::filesystem::path& file) { return parse_plan(config::bounded_file_text(file), file); }

std::string write_plan(const CampaignPlan& plan) {
  std::string out = fmt::format("format_version = {}\ntitle = {}\nthreads = {}\nretries = {}\norder = {}\n", plan_format_version,
                                quoted(plan.title), plan.threads, plan.retries, quoted(plan.longest_first ? "longest_first" : "plan"));
  std::vector<std::string> keep;
  if (plan.keep_frames) keep.emplace_back(quoted("frames"));
  if (plan.keep_final) keep.emplace_back(quoted("final"));
  if (plan.keep_checkpoint) keep.emplace_back(quoted("checkpoint"));
  out += fmt::format("keep = [{}]\n", fmt::join(keep, ", "));
  const SlurmSpec& s = plan.slurm;
  if (s != SlurmSpec{}) {
    std::vector<std::string> options;
    for (const std::string& o : s.options) options.push_back(quoted(o));
    out += fmt::format("\n[slurm]\npartition = {}\naccount = {}\nqos = {}\ntime_limit = {}\nmemory = {}\noptions = [{}]\n",
                       quoted(s.partition), quoted(s.account), quoted(s.qos), quoted(s.time_limit), quoted(s.memory),
                       fmt::join(options, ", "));
  }
  toml::table base;
  base.insert("base", toml::parse(plan.base_text));
  std::ostringstream tables;
  tables << toml::toml_formatter(base, toml::toml_formatter::default_flags & ~toml::format_flags::allow_literal_strings);
  out += fmt::format("\n{}\n", tables.str());
  for (const PlannedRun& run : plan.runs) {
    out += fmt::format("\n[[run]]\nname = {}\n", quoted(run.name));
    std::vector<std::string> set;
    for (const Setting& x : run.settings) set.push_back(fmt::format("{} = {}", quoted(x.key), x.value));
    if (!set.empty()) out += fmt::format("set = {{ {} }}\n", fmt::join(set, ", "));
  }
  return out;
}

}  // namespace mpm
