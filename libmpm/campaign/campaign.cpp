#include "libmpm/campaign/campaign.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <sstream>
#include <string_view>
#include <tuple>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/config/file_problems.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/impact/steady.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/json.hpp"

namespace mpm {

namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> overrides_of(const CampaignPlan& plan, const PlannedRun& run) {
  std::vector<std::string> overrides;
  if (!plan.keep_frames) overrides.emplace_back("output.frames_per_second=0");
  for (const Setting& s : run.settings) overrides.push_back(s.key + "=" + s.value);
  return overrides;
}

/// A table of TOML as JSON.
Json json_of(const toml::table& table) {
  std::ostringstream text;
  text << toml::json_formatter{table};
  return Json::parse(text.str());
}

/// Settings that differ between two runs, by key.
std::string differences(const CampaignRun& a, const CampaignRun& b) {
  std::set<std::string> keys;
  for (const auto* side : {&a, &b}) {
    const auto& other = side == &a ? b : a;
    for (const Setting& s : side->settings) {
      if (std::ranges::find(other.settings, s) == other.settings.end()) keys.insert(s.key);
    }
  }
  return fmt::format("{}", fmt::join(keys, ", "));
}

/// Errors of many cases; an error common to several runs is reported once.
class SharedProblems {
 public:
  /// @param message one problem a line
  void add(const std::string& message, const std::string& run) {
    std::istringstream lines(message);
    for (std::string line; std::getline(lines, line);) {
      const auto found = std::ranges::find(problems_, line, &Problem::text);
      if (found == problems_.end()) {
        if (full()) return;
        problems_.push_back({line, run, 0});
      } else {
        ++found->further_runs;
      }
    }
  }
  void add(const std::string& text) { problems_.push_back({text, "", 0}); }

  [[nodiscard]] bool full() const { return problems_.size() >= config::most_problems; }

  void throw_any() const {
    if (problems_.empty()) return;
    std::string message;
    for (const Problem& f : std::span(problems_).first(std::min(problems_.size(), config::problems_shown))) {
      message += (message.empty() ? "" : "\n") + f.text;
      if (f.first_run.empty()) continue;
      message +=
          f.further_runs == 0 ? fmt::format(" (run {})", f.first_run) : fmt::format(" (run {} and {} more)", f.first_run, f.further_runs);
    }
    if (problems_.size() > config::problems_shown)
      message += fmt::format("\n{}{} more errors", full() ? "at least " : "", problems_.size() - config::problems_shown);
    throw ConfigError(message);
  }

 private:
  struct Problem {
    std::string text, first_run;  ///< first_run is empty for an error that is not of a single run
    std::size_t further_runs;
  };
  std::vector<Problem> problems_;
};

// ---- Stored results ---------------------------------------------------------------------------------------------------------------------

bool is_case_key(std::string_view column) {
  const std::size_t dot = column.rfind('.');
  if (dot == std::string_view::npos) return false;
  const std::string_view table = column.substr(0, std::min(dot, column.find('[')));  // of an entry: body[0]
  return case_schema().find_key(table, column.substr(dot + 1)) != nullptr;
}

/// Whether a column tells of the campaign or of the case, and not of the results.
bool describes_the_run(const std::string& column) {
  constexpr std::string_view own[] = {"name", "run", "status", "cause"};
  static const std::vector<RunInput> inputs = inputs_of({});
  return std::ranges::find(own, column) != std::end(own) || is_case_key(column) ||
         std::ranges::any_of(inputs, [&](const RunInput& input) { return input.column == column; });
}

/// A cell of results.csv as results.json has it.
Value value_of(const std::string& column, const std::string& cell) {
  if (column == "case_hash" || column == "version" || column == "commit") return cell;  // a hash may look like a number
  if (cell == "nan") return MeanEstimate::none;
  if (cell.size() < 19 && cell.find_first_not_of("0123456789") == std::string::npos)
    return std::uint64_t{std::strtoull(cell.c_str(), nullptr, 10)};
  const auto number = parse_number(cell);
  return number ? Value(*number) : Value(cell);
}

/// Results of earlier campaigns, from their results.csv: rows of finished runs, by the hash of their case. A campaign goes on with them
/// where the folders of its runs are not there.
class StoredResults {
 public:
  /// @throws IoError if a file cannot be read or is not a table of results
  explicit StoredResults(const std::vector<std::filesystem::path>& tables) {
    for (const std::filesystem::path& path : tables) {
      const Table table = Table::read(path);
      const std::vector<std::string> hashes = table.text("case_hash"), status = table.text("status");
      std::vector<Results> results(table.rows());
      for (const std::string& column : table.columns()) {
        if (describes_the_run(column)) continue;
        const std::vector<std::string> cells = table.text(column);
        for (std::size_t i = 0; i < cells.size(); ++i) {
          if (!cells[i].empty()) results[i].add({column, value_of(column, cells[i]), {}, {}});
        }
      }
      for (std::size_t i = 0; i < table.rows(); ++i) {
        if (status[i] == "done") rows_.emplace(hashes[i], std::move(results[i]));
      }
    }
  }

  /// The row of a case, if it is of its whole duration (is_whole_run): its columns except for the inputs, vectors by component. The first
  /// such row counts.
  [[nodiscard]] const Results* of(const Case& c, const std::string& case_hash) const {
    const auto [first, last] = rows_.equal_range(case_hash);
    const auto whole = std::find_if(first, last, [&](const auto& row) { return is_whole_run(row.second, c); });
    return whole == last ? nullptr : &whole->second;
  }
  [[nodiscard]] std::size_t rows() const { return rows_.size(); }  ///< finished runs in all tables

 private:
  std::multimap<std::string, Results> rows_;  ///< by case hash
};

}  // namespace

std::vector<RunInput> inputs_of(const Case& c) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN(), quoted_at = 25e3;  // Pa; of the paper's chi
  const ConveyorSpec* const belt = c.conveyor ? &*c.conveyor : nullptr;
  const ObstacleSpec* const mast = c.obstacle ? &*c.obstacle : nullptr;
  const CamClay::Parameters* const snow = c.material.get_if<CamClay>();
  const double g = c.numerics.gravity, width = mast ? mast->width() : none;
  return {
      {"froude_number", "conveyor.froude_number", belt && g > 0.0 ? froude_number(belt->velocity, belt->flow_height, g) : none},
      {"velocity_m_s", "conveyor.velocity_m_s", belt ? belt->velocity : none},
      {"flow_height_m", "conveyor.flow_height_m", belt ? belt->flow_height : none},
      {"conveyor_width_m", "conveyor.width_m", belt ? belt->width : none},
      {"gravity_m_s2", "numerics.gravity_m_s2", belt ? g : none},
      {"critical_state_slope", "material.critical_state_slope", snow ? snow->critical_state_slope : none},
      {"cohesion_beta", "material.cohesion_beta", snow ? snow->cohesion_beta : none},
      {"hardening_xi", "material.hardening_xi", snow ? snow->hardening_xi : none},
      {"effective_friction", "", c.material.critical_state_ratio().value_or(none)},
      {"plastic_compressibility", "",
       snow ? plastic_compressibility(snow->hardening_xi, quoted_at, snow->preconsolidation_pressure,
                                      bulk_modulus(snow->young_modulus, snow->poisson_ratio))
            : none},
      {"obstacle_width_m", "obstacle.width_m", width},
      {"relative_width", "", belt ? width / belt->flow_height : none},
      {"obstacle_friction", "obstacle.friction", mast ? mast->friction : none},
      {"obstacle_friction_ratio", "obstacle.friction_ratio", mast ? mast->friction / c.material.internal_friction().value_or(none) : none},
      {"cell_size_m", "numerics.cell_size_m", c.numerics.cell_size},
  };
}

Campaign make_campaign(CampaignPlan plan) {
  Campaign campaign;
  SharedProblems problems;
  const std::string prefix = plan.file.empty() ? "--set " : plan.file + ": ";
  using Same = std::tuple<std::string, double, double, std::string>;  // case, end, rule that stops it, column that has to be steady
  std::map<Same, std::size_t> known;                                  // -> index
  std::map<std::string, std::size_t> names;
  for (const PlannedRun& planned : plan.runs) {
    if (problems.full()) break;
    CampaignRun run{planned, {}, {}, {}, {}};
    try {
      run.spec = parse_case(plan.base_text, plan.base_name, overrides_of(plan, planned), prefix);
    } catch (const ConfigError& error) {
      problems.add(error.what(), planned.name);
      continue;
    }
    run.spec.title = plan.title.empty() ? run.name : fmt::format("{}: {}", plan.title, run.name);
    run.case_hash = case_hash_text(run.spec);
    run.cost = estimate(run.spec);
    const Same same{run.case_hash, Sampling(run.spec).end(), run.spec.output.stop_when_steady, run.spec.measurement.steady_column()};
    if (!known.try_emplace(same, campaign.runs.size()).second) {
      ++campaign.duplicates;
      continue;
    }
    // names that differ only in case are one folder on some file systems
    if (const auto [at, fresh] = names.try_emplace(lower(run.name), campaign.runs.size()); !fresh) {
      problems.add(fmt::format("two runs are called {}, and differ in {}; give their [[grid]] or [[run]] a name each", run.name,
                               differences(campaign.runs[at->second], run)));
    }
    campaign.runs.push_back(std::move(run));
  }
  problems.throw_any();
  const StoredResults stored(plan.stored_results);
  std::set<const Results*> used;  // a row may serve several durations
  for (CampaignRun& run : campaign.runs) {
    const Results* const row = stored.of(run.spec, run.case_hash);
    if (row == nullptr) continue;
    run.stored_results = *row;
    used.insert(row);
  }
  campaign.unused_rows = stored.rows() - used.size();
  campaign.plan = std::move(plan);
  return campaign;
}

std::string expansion_json(const Campaign& campaign) {
  Json runs = Json::array();
  for (const CampaignRun& run : campaign.runs) {
    Json settings = Json::object();
    for (const Setting& s : run.settings) settings[s.key] = json_of(toml::parse("value = " + s.value)).at("value");
    runs.push_back(
        {{"name", run.name}, {"case_hash", run.case_hash}, {"stored", run.stored_results.has_value()}, {"settings", std::move(settings)}});
  }
  return json_text({{"title", campaign.plan.title},
                    {"base", json_of(toml::parse(campaign.plan.base_text))},
                    {"runs", std::move(runs)},
                    {"unused_rows", campaign.unused_rows}},
                   1);
}

std::filesystem::path run_directory(const std::filesystem::path& out, const CampaignRun& run) { return out / "runs" / run.name; }

}  // namespace mpm
