#include "mpm/campaign.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <utility>

#include "mpm/error.hpp"
#include "mpm/impact/semi_empirical.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/checkpoint.hpp"
#include "mpm/io/config.hpp"
#include "mpm/io/json_text.hpp"
#include "mpm/io/table.hpp"
#include "mpm/run.hpp"
#include "mpm/run_folder.hpp"

namespace mpm {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int attempts_format_version = 1;

std::vector<std::string> overrides_of(const CampaignPlan& plan, const PlannedRun& run) {
  std::vector<std::string> overrides;
  if (!plan.keep_frames) overrides.emplace_back("output.frames_per_second=0");
  for (const Setting& s : run.settings) overrides.push_back(s.key + "=" + s.value);
  return overrides;
}

/// Time of the last sample, s.
double end_of(const Case& c) { return static_cast<double>(last_sample(c)) / c.output.series_per_second; }

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

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Time of the last whole row of a series, s; 0 without one.
double last_time(const fs::path& series) {
  if (!fs::exists(series)) return 0.0;
  std::string text = read_file(series);
  text.erase(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n'));
  const auto start = text.rfind('\n');
  return start == std::string::npos ? 0.0 : std::strtod(text.c_str() + start + 1, nullptr);
}

/// Whether what a folder holds, finished or not, is of this case and not longer than it.
bool can_go_on(const fs::path& directory, const CampaignRun& run) {
  if (!fs::exists(directory / "case.toml")) return false;
  try {
    if (case_hash_text(read_case(directory / "case.toml")) != run.case_hash) return false;
  } catch (const Error&) {  // of another version of this program, or torn
    return false;
  }
  return last_time(directory / "series.csv") <= end_of(run.spec) * (1.0 + 1e-9);
}

std::vector<std::string> folders_in(const fs::path& directory) {
  std::vector<std::string> names;
  if (fs::is_directory(directory)) {
    for (const auto& entry : fs::directory_iterator(directory)) {
      if (entry.is_directory()) names.push_back(entry.path().filename().string());
    }
  }
  std::ranges::sort(names);
  return names;
}

/// Pairs of run and folder: the folder, which the plan does not name, holds the finished run.
std::vector<std::pair<const CampaignRun*, std::string>> adoptable(const fs::path& out, const Campaign& campaign,
                                                                  const std::vector<std::string>& unnamed) {
  std::map<std::string, std::string> by_hash;  // a folder for each case hash
  for (const std::string& name : unnamed) {
    const fs::path results = out / "runs" / name / "results.json";
    if (!fs::exists(results) || is_locked(out / "runs" / name)) continue;
    const auto json = Json::parse(read_json_text(results), nullptr, false);
    if (json.is_object()) by_hash.emplace(json.value("case_hash", ""), name);
  }
  std::vector<std::pair<const CampaignRun*, std::string>> pairs;
  for (const CampaignRun& run : campaign.runs) {
    const auto found = by_hash.find(run.case_hash);
    if (found == by_hash.end() || finished_results(run_directory(out, run), run.spec)) continue;
    if (is_locked(run_directory(out, run)) || !finished_results(out / "runs" / found->second, run.spec)) continue;
    pairs.emplace_back(&run, found->second);
    by_hash.erase(found);
  }
  return pairs;
}

/// What every table of impacts says about its runs, whether it varies or not; NaN where a case has no such thing.
struct Input {
  const char* column;
  const char* key;  ///< of the case file that it stands for, if there is one
  std::function<double(const Case&)> value;
};

const std::vector<Input>& standard_inputs() {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto belt = [](auto get) { return [=](const Case& c) { return c.conveyor ? get(*c.conveyor, c) : none; }; };
  const auto mast = [](auto get) { return [=](const Case& c) { return c.obstacle ? get(*c.obstacle, c) : none; }; };
  const auto snow = [](auto get) {
    return [=](const Case& c) { return c.material.model == "cohesive_cam_clay" ? get(c.material) : none; };
  };
  static const std::vector<Input> inputs{
      {"froude_number", "conveyor.froude_number", belt([](const ConveyorSpec& b, const Case& c) {
         return c.numerics.gravity > 0.0 ? froude_number(b.velocity, b.flow_height, c.numerics.gravity) : none;
       })},
      {"velocity_m_s", "conveyor.velocity_m_s", belt([](const ConveyorSpec& b, const Case&) { return b.velocity; })},
      {"flow_height_m", "conveyor.flow_height_m", belt([](const ConveyorSpec& b, const Case&) { return b.flow_height; })},
      {"conveyor_width_m", "conveyor.width_m", belt([](const ConveyorSpec& b, const Case&) { return b.width; })},
      {"gravity_m_s2", "numerics.gravity_m_s2", belt([](const ConveyorSpec&, const Case& c) { return c.numerics.gravity; })},
      {"critical_state_slope", "material.critical_state_slope", snow([](const MaterialSpec& m) { return m.critical_state_slope; })},
      {"cohesion_beta", "material.cohesion_beta", snow([](const MaterialSpec& m) { return m.cohesion_beta; })},
      {"hardening_xi", "material.hardening_xi", snow([](const MaterialSpec& m) { return m.hardening_xi; })},
      {"effective_friction", "", snow([](const MaterialSpec& m) { return effective_friction(m.critical_state_slope, m.cohesion_beta); })},
      {"plastic_compressibility", "", snow([](const MaterialSpec& m) {
         constexpr double quoted_at = 25e3;  // Pa; the paper's chi
         return plastic_compressibility(m.hardening_xi, quoted_at, m.preconsolidation_pressure,
                                        bulk_modulus(m.young_modulus, m.poisson_ratio));
       })},
      {"obstacle_width_m", "obstacle.width_m", mast([](const ObstacleSpec& o, const Case&) { return o.width; })},
      {"relative_width", "",
       mast([](const ObstacleSpec& o, const Case& c) { return c.conveyor ? o.width / c.conveyor->flow_height : none; })},
      {"obstacle_friction", "obstacle.friction", mast([](const ObstacleSpec& o, const Case&) { return o.friction; })},
      {"obstacle_friction_ratio", "obstacle.friction_ratio",
       mast([](const ObstacleSpec& o, const Case& c) { return o.friction / internal_friction(c.material).value_or(none); })},
      {"cell_size_m", "numerics.cell_size_m", [](const Case& c) { return c.numerics.cell_size; }},
  };
  return inputs;
}

/// Keys of the settings that do not have a column above and are not the same in all runs.
std::vector<std::string> other_varied_keys(const Campaign& campaign) {
  std::vector<std::string> keys;
  for (const CampaignRun& run : campaign.runs) {
    for (const Setting& s : run.settings) {
      if (std::ranges::find(keys, s.key) == keys.end()) keys.push_back(s.key);
    }
  }
  std::erase_if(keys, [&](const std::string& key) {
    if (std::ranges::any_of(standard_inputs(), [&](const Input& i) { return key == i.key; })) return true;
    const auto same = [&](const CampaignRun& r) {
      const auto& first = campaign.runs.front();
      return case_value(r.spec, key) == case_value(first.spec, key);
    };
    return std::ranges::all_of(campaign.runs, same);
  });
  return keys;
}

/// Figures of results.json that say how it was computed, and not what.
bool belongs_to_execution(const std::string& key) {
  static const std::set<std::string> keys{
      "compiler", "instruction_set", "threads", "wall_time_s", "solver_time_s", "million_particle_steps_per_s", "peak_memory_bytes"};
  return keys.contains(key);
}

/// Said by the other columns.
bool is_told_otherwise(const std::string& key) {
  static const std::set<std::string> keys{"format_version", "title", "case_hash", "version", "commit"};
  return keys.contains(key);
}

std::string cell_of(const Json& value) {
  if (value.is_null()) return "nan";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (value.is_number_float()) return format_number(value.get<double>());
  if (value.is_string()) return value.get<std::string>();
  return value.dump();
}

/// Columns of the figures, vectors by component: force_mean_n.x.
std::vector<std::pair<std::string, std::string>> cells_of(const Json& results) {
  std::vector<std::pair<std::string, std::string>> cells;
  for (const auto& [key, value] : results.items()) {
    if (belongs_to_execution(key) || is_told_otherwise(key)) continue;
    if (!value.is_array()) {
      cells.emplace_back(key, cell_of(value));
      continue;
    }
    for (std::size_t i = 0; i < value.size(); ++i)
      cells.emplace_back(value.size() == 3 ? fmt::format("{}.{}", key, "xyz"[i]) : fmt::format("{}[{}]", key, i), cell_of(value[i]));
  }
  return cells;
}

/// The figures of all runs: the names in the order in which they first appear, and for each run its cells by name.
struct Figures {
  std::vector<std::string> names;
  std::vector<std::map<std::string, std::string>> cells;
};

Figures figures_of(const std::vector<Json>& results) {
  Figures f;
  for (const Json& json : results) {
    std::map<std::string, std::string> row;
    for (auto& [name, cell] : cells_of(json)) {
      if (std::ranges::find(f.names, name) == f.names.end()) f.names.push_back(name);
      row.emplace(name, cell);
    }
    f.cells.push_back(std::move(row));
  }
  return f;
}

std::string results_table(const Campaign& campaign, const std::vector<RunStatus>& status, const std::vector<Json>& results) {
  std::vector<Input> inputs;
  for (const Input& input : standard_inputs()) {
    if (std::ranges::any_of(campaign.runs, [&](const CampaignRun& r) { return std::isfinite(input.value(r.spec)); }))
      inputs.push_back(input);
  }
  const std::vector<std::string> others = other_varied_keys(campaign);
  const Figures figures = figures_of(results);
  std::vector<std::string> head{"name", "run", "status", "case_hash", "version", "commit"};
  for (const Input& input : inputs) head.emplace_back(input.column);
  head.insert(head.end(), others.begin(), others.end());
  head.insert(head.end(), figures.names.begin(), figures.names.end());
  head.emplace_back("cause");
  std::string text = csv_line(head);
  for (std::size_t i = 0; i < campaign.runs.size(); ++i) {
    const CampaignRun& run = campaign.runs[i];
    // what is under way now is no property of the run: the table does not depend on when it is written
    const RunState state = status[i].state == RunState::running ? RunState::to_do : status[i].state;
    std::vector<std::string> row{run.name, "runs/" + run.name, to_string(state), run.case_hash};
    for (const char* key : {"version", "commit"}) row.push_back(results[i].value(key, ""));
    for (const Input& input : inputs) row.push_back(format_number(input.value(run.spec)));
    for (const std::string& key : others) row.push_back(case_value(run.spec, key).value_or(""));
    for (const std::string& name : figures.names) {
      const auto cell = figures.cells[i].find(name);
      row.push_back(cell == figures.cells[i].end() ? "" : cell->second);
    }
    row.push_back(state == RunState::failed ? status[i].cause() : "");
    text += csv_line(row);
  }
  return text;
}

std::string executions_table(const Campaign& campaign, const std::vector<RunStatus>& status, const std::vector<Json>& results) {
  const std::vector<std::string> figures{"threads",           "wall_time_s",     "solver_time_s", "million_particle_steps_per_s",
                                         "peak_memory_bytes", "instruction_set", "compiler"};
  std::vector<std::string> head{"name", "status",       "attempts",  "first_started", "last_ended",
                                "host", "last_outcome", "exit_code", "signal",        "cause"};
  head.insert(head.end(), figures.begin(), figures.end());
  std::string text = csv_line(head);
  for (std::size_t i = 0; i < campaign.runs.size(); ++i) {
    const auto& attempts = status[i].attempts;
    const Attempt last = attempts.empty() ? Attempt{} : attempts.back();
    const auto number = [](const std::optional<int>& x) { return x ? std::to_string(*x) : ""; };
    std::vector<std::string> row{campaign.runs[i].name,
                                 to_string(status[i].state),
                                 std::to_string(attempts.size()),
                                 attempts.empty() ? "" : attempts.front().started,
                                 last.ended,
                                 last.host,
                                 last.outcome,
                                 number(last.exit_code),
                                 number(last.signal),
                                 last.cause};
    for (const std::string& key : figures) row.push_back(results[i].contains(key) ? cell_of(results[i][key]) : "");
    text += csv_line(row);
  }
  return text;
}

}  // namespace

Campaign make_campaign(CampaignPlan plan) {
  Campaign campaign;
  struct Said {
    std::string first_run;
    std::size_t runs;
  };
  std::vector<std::string> faults;  // each once, however many runs share it
  std::map<std::string, Said> said;
  std::map<std::pair<std::string, double>, std::size_t> known;  // case and end -> index
  std::map<std::string, std::size_t> names;
  for (const PlannedRun& planned : plan.runs) {
    CampaignRun run{planned.name, planned.settings, {}, {}, {}};
    try {
      run.spec = parse_case(plan.base_text, plan.base_name, overrides_of(plan, planned));
    } catch (const ConfigError& error) {
      std::istringstream lines(error.what());
      for (std::string line; std::getline(lines, line);) {
        if (const auto [at, fresh] = said.try_emplace(line, Said{planned.name, 0}); fresh) {
          faults.push_back(line);
        } else {
          ++at->second.runs;
        }
      }
      continue;
    }
    run.spec.title = plan.title.empty() ? run.name : fmt::format("{}: {}", plan.title, run.name);
    run.case_hash = case_hash_text(run.spec);
    run.cost = estimate(run.spec);
    if (!known.try_emplace({run.case_hash, end_of(run.spec)}, campaign.runs.size()).second) {
      ++campaign.duplicates;
      continue;
    }
    // names that differ by capitals alone are one folder on some file systems
    if (const auto [at, fresh] = names.try_emplace(lower(run.name), campaign.runs.size()); !fresh) {
      faults.push_back(fmt::format("two runs are called {}, and differ in {}; give their [[grid]] or [[run]] a name each", run.name,
                                   differences(campaign.runs[at->second], run)));
    }
    campaign.runs.push_back(std::move(run));
  }
  if (!faults.empty()) {
    std::string message;
    for (const std::string& f : faults) {
      message += (message.empty() ? "" : "\n") + f;
      if (const auto s = said.find(f); s != said.end())
        message += s->second.runs == 0 ? fmt::format(" (run {})", s->second.first_run)
                                       : fmt::format(" (run {} and {} more)", s->second.first_run, s->second.runs);
    }
    throw ConfigError(message);
  }
  campaign.plan = std::move(plan);
  return campaign;
}

fs::path run_directory(const fs::path& out, const CampaignRun& run) { return out / "runs" / run.name; }

std::vector<Attempt> read_attempts(const fs::path& directory, const CampaignRun& run) {
  if (!fs::exists(directory / "attempts.json")) return {};
  const Json json = Json::parse(read_json_text(directory / "attempts.json"), nullptr, false);
  if (!json.is_object() || json.value("case_hash", "") != run.case_hash || json.value("end_s", -1.0) != end_of(run.spec) ||
      !json.contains("attempts"))
    return {};
  std::vector<Attempt> attempts;
  for (const Json& a : json["attempts"]) {
    const auto whole = [&](const char* key) {
      return a.contains(key) && a[key].is_number() ? std::optional(a[key].get<int>()) : std::nullopt;
    };
    attempts.push_back({a.value("started", ""), a.value("ended", ""), a.value("host", ""), a.value("outcome", ""), whole("exit_code"),
                        whole("signal"), a.value("cause", ""), a.value("final", false)});
  }
  return attempts;
}

void write_attempts(const fs::path& directory, const CampaignRun& run, const std::vector<Attempt>& attempts) {
  Json json{{"format_version", attempts_format_version}, {"case_hash", run.case_hash}, {"end_s", end_of(run.spec)}};
  json["attempts"] = Json::array();
  for (const Attempt& a : attempts) {
    const auto whole = [](const std::optional<int>& x) { return x ? Json(*x) : Json(); };
    json["attempts"].push_back({{"started", a.started},
                                {"ended", a.ended},
                                {"host", a.host},
                                {"outcome", a.outcome},
                                {"exit_code", whole(a.exit_code)},
                                {"signal", whole(a.signal)},
                                {"cause", a.cause},
                                {"final", a.final}});
  }
  write_file(directory / "attempts.json", json.dump(2) + "\n");
}

std::string to_string(RunState state) {
  switch (state) {
    case RunState::to_do: return "to do";
    case RunState::running: return "running";
    case RunState::done: return "done";
    case RunState::failed: return "failed";
  }
  return {};
}

std::string RunStatus::cause() const { return state == RunState::failed && !attempts.empty() ? attempts.back().cause : ""; }

RunStatus status_of(const fs::path& out, const CampaignRun& run) {
  const fs::path directory = run_directory(out, run);
  RunStatus s;
  s.attempts = read_attempts(directory, run);
  if (const auto results = finished_results(directory, run.spec)) {
    s.state = RunState::done;
    s.results = *results;
    s.progress = 1.0;
    return s;
  }
  const bool running = is_locked(directory);
  if (running) {
    s.state = RunState::running;
  } else if (!s.attempts.empty() && s.attempts.back().outcome == "failed") {
    s.state = RunState::failed;
  }
  // a run that was cut off goes on from its checkpoint, not from its last row
  if ((running || has_checkpoint(directory)) && can_go_on(directory, run))
    s.progress = std::min(1.0, last_time(directory / "series.csv") / end_of(run.spec));
  return s;
}

std::vector<RunStatus> status_of(const fs::path& out, const Campaign& campaign) {
  std::vector<RunStatus> all;
  all.reserve(campaign.runs.size());
  for (const CampaignRun& run : campaign.runs) all.push_back(status_of(out, run));
  return all;
}

std::string resolved_plan(const Campaign& campaign) {
  CampaignPlan resolved = campaign.plan;
  resolved.runs.clear();
  for (const CampaignRun& run : campaign.runs) resolved.runs.push_back({run.name, run.settings});
  return write_plan(resolved);
}

Preparation compare_with_folder(const fs::path& out, const Campaign& campaign) {
  Preparation p;
  std::vector<std::string> unnamed = folders_in(out / "runs");
  std::erase_if(unnamed,
                [&](const std::string& name) { return std::ranges::find(campaign.runs, name, &CampaignRun::name) != campaign.runs.end(); });
  for (const auto& [run, folder] : adoptable(out, campaign, unnamed)) {
    p.adopted.push_back(fmt::format("{} (was {})", run->name, folder));
    std::erase(unnamed, folder);
  }
  for (const CampaignRun& run : campaign.runs) {
    const fs::path directory = run_directory(out, run);
    if (fs::exists(directory / "case.toml") && !finished_results(directory, run.spec) && !can_go_on(directory, run))
      p.replaced.push_back(run.name);
  }
  p.dropped = std::move(unnamed);
  return p;
}

Preparation prepare(const fs::path& out, const Campaign& campaign) {
  Preparation p = compare_with_folder(out, campaign);
  make_directory(out / "runs");
  std::vector<std::string> unnamed = folders_in(out / "runs");
  std::erase_if(unnamed,
                [&](const std::string& name) { return std::ranges::find(campaign.runs, name, &CampaignRun::name) != campaign.runs.end(); });
  for (const auto& [run, folder] : adoptable(out, campaign, unnamed)) {
    std::error_code error;
    fs::remove_all(run_directory(out, *run), error);
    if (!error) fs::rename(out / "runs" / folder, run_directory(out, *run), error);
    if (error) throw file_error("cannot rename", out / "runs" / folder, error.value());
  }
  write_file(out / "plan.toml", resolved_plan(campaign));
  return p;
}

void prepare_run(const fs::path& out, const CampaignRun& run) {
  const fs::path directory = run_directory(out, run);
  make_directory(directory);
  if (fs::exists(directory / "case.toml") && !can_go_on(directory, run)) {
    for (const auto& entry : fs::directory_iterator(directory)) {
      if (entry.path().filename() == ".lock") continue;
      std::error_code error;
      fs::remove_all(entry.path(), error);
      if (error) throw file_error("cannot remove", entry.path(), error.value());
    }
  }
  write_file(directory / "case.toml", write_case(run.spec));
}

void tidy_run(const fs::path& out, const CampaignPlan& plan, const CampaignRun& run) {
  const fs::path directory = run_directory(out, run);
  std::vector<std::string> names{"stderr.log"};
  if (!plan.keep_checkpoint) names.insert(names.end(), {checkpoint_file, previous_checkpoint_file, refused_checkpoint_file});
  if (!plan.keep_final) names.emplace_back("final.h5");
  if (!plan.keep_frames) names.insert(names.end(), {"frames", "frames.xdmf"});
  for (const std::string& name : names) {
    std::error_code error;
    fs::remove_all(directory / name, error);
    if (error) throw file_error("cannot remove", directory / name, error.value());
  }
}

void write_campaign_tables(const fs::path& out, const Campaign& campaign, const std::vector<RunStatus>& status) {
  std::vector<Json> results;
  results.reserve(status.size());
  for (const RunStatus& s : status) results.push_back(s.results.empty() ? Json::object() : Json::parse(s.results));
  write_file(out / "results.csv", results_table(campaign, status, results));
  write_file(out / "runs.csv", executions_table(campaign, status, results));
}

CampaignCost cost_of(const Campaign& campaign, const std::vector<RunStatus>& status) {
  CampaignCost cost;
  double work = 0.0, time = 0.0;
  for (std::size_t i = 0; i < campaign.runs.size(); ++i) {
    const double steps = campaign.runs[i].cost.particle_steps;
    cost.particle_steps += steps;
    cost.left += (1.0 - status[i].progress) * (status[i].state == RunState::failed ? 0.0 : steps);
    if (status[i].state != RunState::done) continue;
    const Json results = Json::parse(status[i].results, nullptr, false);
    work += steps;
    time += results.value("wall_time_s", 0.0);
  }
  cost.measured = time > 0.0;
  constexpr double assumed_cores = 2.0;  // of assumed_particle_steps_per_s
  cost.particle_steps_per_s = cost.measured ? work / time : assumed_particle_steps_per_s / assumed_cores * campaign.plan.threads;
  return cost;
}

}  // namespace mpm
