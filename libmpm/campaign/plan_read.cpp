#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/campaign/plan_blocks.hpp"
#include "libmpm/campaign/plan_values.hpp"
#include "libmpm/campaign/run_name.hpp"
#include "libmpm/config/guard.hpp"
#include "libmpm/config/toml_text.hpp"
#include "libmpm/driver/launcher.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

namespace {

using config::kind_of;
using config::one_line;
using config::shown;
using config::toml_text;

constexpr int most_threads_of_a_run = 1024, most_ranks_of_a_run = 100000, most_retries = 100;
constexpr std::size_t most_rules = 1000;  // [[when]] of a plan or a [[grid]]: each is compared with each run

/// Reads the tables of a plan, one function a table.
class BlockReader : private PlanValues {
 public:
  explicit BlockReader(const std::filesystem::path& file) : PlanValues(file), file_(file) { blocks_.plan.file = file.string(); }

  PlanBlocks read(std::string_view text) {
    config::check_text(text, file_.string());
    toml::table root;
    try {
      root = toml::parse(text, file_.string());
    } catch (const toml::parse_error& error) {
      throw ConfigError(config::syntax_error(error, file_.string()));
    }
    read_root(root);
    throw_problems();
    return std::move(blocks_);
  }

 private:
  std::vector<Rule> rules(const toml::table& table, const std::string& where) {
    std::vector<Rule> list;
    int number = 0;
    for (const toml::table* entry : tables_at(table, where, "when", most_rules)) {
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
          if (given_up()) break;
          rule.match.emplace_back(e.key, values);
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
  std::vector<std::string> keys_together(const Entry& e, const std::string& here, std::vector<std::string>& seen, bool& known) {
    std::vector<std::string> keys;
    std::istringstream names(e.key);
    for (std::string key; std::getline(names, key, ',');) {
      key = std::string(trimmed(key, " "));
      known = known_key(key, e.source, here) && known;
      if (std::ranges::find(seen, key) != seen.end()) problem(e.source, here, fmt::format("{} is given twice; give it once", key));
      seen.push_back(key);
      keys.push_back(key);
    }
    return keys;
  }

  /// The values of the keys in one run; empty unless there is one for each.
  std::vector<std::string> value_row(const Entry& e, const toml::node& value, std::size_t keys, const std::string& here) {
    if (keys == 1) return {toml_text(value)};
    const toml::array* together = value.as_array();
    if (together == nullptr || together->size() != keys) {
      problem(value.source(), here,
              fmt::format("{}: {} does not give the {} keys a value each; write a list of {}", e.key, shown(value), keys, keys));
      return {};
    }
    std::vector<std::string> row;
    for (const toml::node& part : *together) row.push_back(toml_text(part));
    return row;
  }

  std::vector<VariedKeys> parameters(const toml::table& table, const std::string& where) {
    std::vector<VariedKeys> list;
    const toml::table* crossed = table_at(table, where, "parameters");
    if (crossed == nullptr) return list;
    const std::string here = fmt::format("{}{}parameters:", where, where.empty() ? "" : " ");
    std::vector<std::string> seen;
    for (const Entry& e : in_order(*crossed)) {
      if (given_up()) break;
      bool known = true;
      VariedKeys p{keys_together(e, here, seen, known), {}};
      const toml::array* values = e.node->as_array();
      if (values == nullptr || values->empty()) {
        problem(e.source, here,
                fmt::format("{} = {} is {}; give a list of values", e.key, shown(*e.node), values != nullptr ? "empty" : kind_of(*e.node)));
        continue;
      }
      std::set<std::vector<std::string>> given;
      for (const toml::node& value : *values) {
        if (given_up()) break;
        std::vector<std::string> row = value_row(e, value, p.keys.size(), here);
        if (row.empty()) continue;
        if (!given.insert(row).second)
          problem(value.source(), here, fmt::format("{}: {} is given twice; give each value once", e.key, shown(value)));
        p.rows.push_back(std::move(row));
      }
      if (known) list.push_back(std::move(p));
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
    for (const std::string& column : table.columns()) {
      if (column != "name" && known_key(column, source, where)) keys.push_back(column);
    }
    const std::vector<std::string> names = table.has("name") ? table.text("name") : std::vector<std::string>(table.rows());
    std::vector<std::vector<std::string>> cells;
    cells.reserve(keys.size());
    for (const std::string& key : keys) cells.push_back(table.text(key));
    for (std::size_t i = 0; i < table.rows() && !given_up(); ++i) {
      Row row{names[i], {}};
      if (const std::string why = name_problem(names[i]); !names[i].empty() && !why.empty())
        problem(source, where, fmt::format("row {}: name = {}", i + 1, why));
      for (std::size_t k = 0; k < keys.size(); ++k) {
        if (cells[k][i].empty()) continue;
        put(row.set, {keys[k], toml_value(cells[k][i])});
      }
      blocks_.rows.push_back(std::move(row));
    }
  }

  /// base = { ... }, or [base.material] and so on
  void read_base_tables(const toml::table& tables) {
    blocks_.base = tables;
    blocks_.base.is_inline(false);  // base = { ... } in the plan is the root of a case
    blocks_.plan.base_text = toml_text(blocks_.base);
    blocks_.plan.base_name = file_.string() + ", [base]";
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

  void read_base(const toml::table& root) {
    const toml::node* base = root.get("base");
    if (base == nullptr) {
      problem(root.source(), "", "base is missing; give a case file, relative to the plan, or its tables as [base.material], ...");
    } else if (const toml::table* tables = base->as_table()) {
      read_base_tables(*tables);
    } else if (const auto name = base->value_exact<std::string>()) {
      read_base_file(file_.parent_path() / *name, base->source());
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
    blocks_.labels = common_labels();
    const toml::table* labels = table_at(root, "", "labels");
    if (labels == nullptr) return;
    for (const Entry& e : in_order(*labels)) {
      if (given_up()) break;
      const auto word = e.node->value_exact<std::string>();
      if (!known_key(e.key, e.source, "[labels]")) continue;
      if (!word || *word != file_name_part(*word)) {
        problem(e.source, "[labels]", fmt::format("{} = {}; give letters and digits in quotes", e.key, shown(*e.node)));
      } else {
        blocks_.labels[e.key] = *word;
      }
    }
  }

  void read_slurm(const toml::table& root) {
    const toml::table* slurm = table_at(root, "", "slurm");
    if (slurm == nullptr) return;
    only(*slurm, "[slurm]", {"partition", "account", "qos", "time_limit", "memory", "options"});
    const auto word = [&](const char* name) { return text(*slurm, "[slurm]", name); };
    blocks_.plan.slurm = {word("partition"),  word("account"), word("qos"),
                          word("time_limit"), word("memory"),  words(*slurm, "[slurm]", "options")};
  }

  void read_stored_results(const toml::table& root) {
    for (const std::string& name : words(root, "", "stored_results")) {
      blocks_.plan.stored_results.push_back(std::filesystem::absolute(file_.parent_path() / name).lexically_normal());
      if (!std::filesystem::is_regular_file(blocks_.plan.stored_results.back())) {
        problem(root.get("stored_results")->source(), "",
                fmt::format("stored_results: there is no file \"{}\"; give a results.csv, relative to the plan", one_line(name)));
      }
    }
  }

  void read_crossings(const toml::table& root) {
    if (root.contains("parameters")) blocks_.crossings.push_back({"", parameters(root, ""), {}, {}});
    int number = 0;
    for (const toml::table* entry : tables_at(root, "", "grid")) {
      const std::string where = fmt::format("[[grid]] {}", ++number);
      only(*entry, where, {"name", "parameters", "set", "when"});
      if (!entry->contains("parameters")) problem(entry->source(), where, "has no parameters; give lists to cross, or write a [[run]]");
      blocks_.crossings.push_back(
          {folder_name(*entry, where), parameters(*entry, where), settings(*entry, where, "set"), rules(*entry, where)});
    }
  }

  void read_rows(const toml::table& root) {
    int number = 0;
    for (const toml::table* entry : tables_at(root, "", "run")) {
      const std::string where = fmt::format("[[run]] {}", ++number);
      only(*entry, where, {"name", "set"});
      const Row row{folder_name(*entry, where), settings(*entry, where, "set")};
      if (row.name.empty() && row.set.empty()) problem(entry->source(), where, "is empty; give it a name, or keys in set");
      blocks_.rows.push_back(row);
    }
    const std::string name = text(root, "", "table");
    if (name.empty()) return;
    try {
      read_csv_rows(file_.parent_path() / name, root.get("table")->source());
    } catch (const IoError& error) {
      problem(root.get("table")->source(), "", fmt::format("table: {}", error.what()));
    }
  }

  void read_root(const toml::table& root) {
    only(root, "",
         {"format_version", "title", "base", "ranks", "launcher", "threads", "retries", "order", "keep", "table", "set", "when",
          "parameters", "grid", "run", "labels", "slurm", "stored_results"});
    if (integer(root, "format_version", 1, plan_format_version, plan_format_version) != plan_format_version) return;
    CampaignPlan& plan = blocks_.plan;
    plan.title = text(root, "", "title");
    plan.ranks = integer(root, "ranks", 1, most_ranks_of_a_run, plan.ranks);
    plan.launcher = words(root, "", "launcher");
    const auto says_how_many = [](const std::string& word) { return word.find(ranks_placeholder) != std::string::npos; };
    if (!plan.launcher.empty() && std::ranges::none_of(plan.launcher, says_how_many)) {
      problem(root.get("launcher")->source(), "",
              fmt::format("launcher: no word says how many ranks it starts; give one with {}", ranks_placeholder));
    }
    plan.threads = integer(root, "threads", 1, most_threads_of_a_run, plan.threads);
    plan.retries = integer(root, "retries", 0, most_retries, plan.retries);
    read_base(root);
    read_order(root);
    read_keep(root);
    read_labels(root);
    read_slurm(root);
    read_stored_results(root);
    blocks_.set = settings(root, "", "set");
    blocks_.rules = rules(root, "");
    read_crossings(root);
    read_rows(root);
    if (blocks_.crossings.empty() && blocks_.rows.empty() && sound())
      problem(root.source(), "", "the plan has no runs; give [parameters], [[grid]], [[run]] or a table");
  }

  std::filesystem::path file_;
  PlanBlocks blocks_;
};

}  // namespace

PlanBlocks read_blocks(std::string_view text, const std::filesystem::path& file) { return BlockReader(file).read(text); }

}  // namespace mpm
