#include "libmpm/campaign/folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/plan.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/json.hpp"

namespace mpm {

// ---- Preparation -----------------------------------------------------------------------------------------------------------------------

namespace {

namespace fs = std::filesystem;

/// Names of the folders that are not in the plan.
std::vector<std::string> unnamed_folders(const fs::path& out, const Campaign& campaign) {
  std::vector<std::string> names = names_in(out / "runs");
  std::erase_if(names, [&](const std::string& name) {
    return !fs::is_directory(out / "runs" / name) || std::ranges::find(campaign.runs, name, &CampaignRun::name) != campaign.runs.end();
  });
  return names;
}

void remove_tree(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) throw file_error("cannot remove", path, error.value());
}

/// The answer to a question about a folder; false if a file of it is damaged, which status_of() reports.
template <class Question>
bool answer_or_false(Question&& question) {
  try {
    return question();
  } catch (const IoError&) {
    return false;
  } catch (const fs::filesystem_error&) {
    return false;
  }
}

bool is_finished(const fs::path& directory, const Case& c) {
  return answer_or_false([&] { return finished_results(directory, c).has_value(); });
}

/// Makes way for another run: results and checkpoints are kept under the name NAME.1, NAME.2, ..., where prepare() finds them if the plan
/// is changed back.
void move_aside(const fs::path& directory) {
  if (!fs::exists(directory)) return;
  if (!fs::exists(directory / "results.json") && !has_checkpoint(directory)) return remove_tree(directory);
  int number = 1;
  while (fs::exists(fs::symlink_status(fmt::format("{}.{}", directory.string(), number)))) ++number;
  rename_file(directory, fmt::format("{}.{}", directory.string(), number));
}

/// Time of the last complete row of a series, s; 0 without one.
double last_time(const fs::path& series) {
  if (!fs::exists(series)) return 0.0;
  std::string text = read_file(series);
  text.erase(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n'));
  const auto start = text.rfind('\n');
  return start == std::string::npos ? 0.0 : std::strtod(text.c_str() + start + 1, nullptr);
}

/// What does not match its checksums in a finished run, which is then computed again in its place; empty: nothing, or what cannot be read
/// at all, which status_of() reports.
std::string damage_of_finished(const fs::path& directory, const Case& c) {
  std::string damage;
  (void)answer_or_false([&] {
    const ResultsFile file(directory);
    if (file.results() && fs::exists(directory / "case.toml") && !file.is_finished(c)) damage = file.damage();
    return true;
  });
  return damage;
}

/// Whether a run that goes on in this folder would destroy results or a checkpoint.
bool is_of_another_run(const fs::path& directory, const CampaignRun& run) {
  return answer_or_false([&] {
    const ResultsFile file(directory);
    if (file.is_finished(run.spec) || !damage_of_finished(directory, run.spec).empty()) return false;
    if (file.exists()) {
      if (!file.results()) return false;            // damaged
      if (!has_checkpoint(directory)) return true;  // of another duration, without a state to go on from
    }
    return fs::exists(directory / "case.toml") && !can_go_on(directory, run);
  });
}

/// Pairs of a run and a folder with another name, not in the plan, that holds the finished run.
std::vector<std::pair<const CampaignRun*, std::string>> adoptable(const fs::path& out, const Campaign& campaign,
                                                                  const std::vector<std::string>& unnamed) {
  std::multimap<std::string, std::string> by_hash;  // folders of each case hash
  for (const std::string& name : unnamed) {
    (void)answer_or_false([&] {
      const ResultsFile file(out / "runs" / name);
      if (file.results() && !is_locked(out / "runs" / name)) by_hash.emplace(file.results()->text("case_hash"), name);
      return true;
    });
  }
  std::vector<std::pair<const CampaignRun*, std::string>> pairs;
  for (const CampaignRun& run : campaign.runs) {
    if (is_finished(run_directory(out, run), run.spec) || is_locked(run_directory(out, run))) continue;
    const auto [first, last] = by_hash.equal_range(run.case_hash);
    const auto found = std::find_if(first, last, [&](const auto& f) { return is_finished(out / "runs" / f.second, run.spec); });
    if (found == last) continue;
    pairs.emplace_back(&run, found->second);
    by_hash.erase(found);
  }
  return pairs;
}

}  // namespace

bool can_go_on(const fs::path& directory, const CampaignRun& run) {
  return answer_or_false([&] {
    return holds_case(directory, run.case_hash) && last_time(directory / "series.csv") <= Sampling(run.spec).end() * (1.0 + 1e-9);
  });
}

std::string resolved_plan(const Campaign& campaign) {
  CampaignPlan resolved = campaign.plan;
  resolved.runs.assign(campaign.runs.begin(), campaign.runs.end());
  return write_plan(resolved);
}

Preparation compare_with_folder(const fs::path& out, const Campaign& campaign) {
  Preparation p;
  std::vector<std::string> unnamed = unnamed_folders(out, campaign);
  for (const auto& [run, folder] : adoptable(out, campaign, unnamed)) {
    p.adopted.push_back(fmt::format("{} (was {})", run->name, folder));
    std::erase(unnamed, folder);
  }
  for (const CampaignRun& run : campaign.runs) {
    const fs::path directory = run_directory(out, run);
    if (const std::string damage = damage_of_finished(directory, run.spec); !damage.empty()) {
      p.damaged.push_back(fmt::format("{} ({})", run.name, damage));
    } else if (is_of_another_run(directory, run)) {
      p.replaced.push_back(run.name);
    }
  }
  p.dropped = std::move(unnamed);
  return p;
}

Preparation prepare(const fs::path& out, const Campaign& campaign) {
  for (const fs::path& table : campaign.plan.stored_results) {
    std::error_code error;
    if (fs::equivalent(table, out / "results.csv", error)) {
      throw ConfigError(
          fmt::format("stored_results: '{}' is the table of this campaign, and its rows would be overwritten; choose another "
                      "folder with --out",
                      table.string()));
    }
  }
  Preparation p = compare_with_folder(out, campaign);
  make_directory(out / "runs");
  remove_leftovers(out);
  const std::vector<std::string> unnamed = unnamed_folders(out, campaign);
  for (const auto& [run, folder] : adoptable(out, campaign, unnamed)) {
    move_aside(run_directory(out, *run));
    rename_file(out / "runs" / folder, run_directory(out, *run));
  }
  write_file(out / "plan.toml", resolved_plan(campaign));
  return p;
}

void prepare_run(const fs::path& out, const CampaignRun& run) {
  const fs::path directory = run_directory(out, run);
  make_directory(directory);
  if (is_of_another_run(directory, run)) {
    const DirectoryLock lock(directory);
    if (is_of_another_run(directory, run)) move_aside(directory);  // still so, now that nobody else does the same
    make_directory(directory);
  }
  write_file(directory / "case.toml", write_case(run.spec));
}

void tidy_run(const fs::path& out, const CampaignPlan& plan, const CampaignRun& run) {
  const fs::path directory = run_directory(out, run);
  remove_leftovers(directory);
  std::vector<std::string> names{"stderr.log"};
  if (!plan.keep_checkpoint) names.insert(names.end(), {checkpoint_file, previous_checkpoint_file, refused_checkpoint_file});
  if (!plan.keep_final) names.emplace_back("final.h5");
  if (!plan.keep_frames) names.insert(names.end(), {"frames", "frames.xdmf"});
  for (const std::string& name : names) remove_tree(directory / name);
}

// ---- Progress --------------------------------------------------------------------------------------------------------------------------

namespace {

using Json = nlohmann::ordered_json;

constexpr int attempts_format_version = 1;

}  // namespace

std::vector<Attempt> read_attempts(const fs::path& directory, const CampaignRun& run) {
  const fs::path file = directory / "attempts.json";
  if (!fs::exists(file)) return {};
  const Json json = Json::parse(read_json_text(file), nullptr, false);
  try {
    if (json.value("case_hash", "") != run.case_hash || json.value("end_s", -1.0) != Sampling(run.spec).end()) return {};
    std::vector<Attempt> attempts;
    for (const Json& a : json.at("attempts")) {
      const auto whole = [&](const char* key) {
        return a.contains(key) && a[key].is_number_integer() ? std::optional(a[key].get<int>()) : std::nullopt;
      };
      attempts.push_back({a.value("started", ""), a.value("ended", ""), a.value("host", ""), a.value("outcome", ""), whole("exit_code"),
                          whole("signal"), a.value("cause", ""), a.value("final", false)});
    }
    return attempts;
  } catch (const Json::exception&) {  // no object, or a value of another type
    throw IoError(fmt::format("'{}' is damaged: it is no list of attempts; delete it", file.string()));
  }
}

void write_attempts(const fs::path& directory, const CampaignRun& run, const std::vector<Attempt>& attempts) {
  Json json{{"format_version", attempts_format_version}, {"case_hash", run.case_hash}, {"end_s", Sampling(run.spec).end()}};
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
  write_file(directory / "attempts.json", json_text(json, 2));
}

std::string to_string(RunState state) {
  static constexpr std::array names{"to do", "running", "done", "failed"};
  return names.at(static_cast<std::size_t>(state));
}

std::string RunStatus::cause() const {
  if (state != RunState::failed) return {};
  return damage.empty() ? attempts.back().cause : damage;
}

namespace {

RunStatus status_by_files(const fs::path& out, const CampaignRun& run) {
  const fs::path directory = run_directory(out, run);
  RunStatus s;
  s.attempts = read_attempts(directory, run);
  const ResultsFile file(directory);
  const bool computed = file.is_finished(run.spec);
  if (computed || run.stored_results) {
    s.state = RunState::done;
    s.stored = !computed;
    s.results = computed ? *file.results() : *run.stored_results;
    s.progress = 1.0;
    return s;
  }
  if (file.exists() && !file.results()) {
    throw IoError(fmt::format("'{}' is damaged: it holds no JSON object; delete it, and the run is computed again",
                              (directory / "results.json").string()));
  }
  const bool running = is_locked(directory);
  if (running) {
    s.state = RunState::running;
  } else if (!s.attempts.empty() && s.attempts.back().outcome == "failed") {
    s.state = RunState::failed;
  }
  // a run that was cut off goes on from its checkpoint, not from its last row
  if ((running || has_checkpoint(directory)) && can_go_on(directory, run))
    s.progress = std::min(1.0, last_time(directory / "series.csv") / Sampling(run.spec).end());
  return s;
}

}  // namespace

RunStatus status_of(const fs::path& out, const CampaignRun& run) {
  RunStatus s;
  s.state = RunState::failed;
  try {
    return status_by_files(out, run);
  } catch (const Error& error) {
    s.damage = error.what();
  } catch (const std::system_error& error) {  // of the file system
    s.damage = error.what();
  }
  return s;
}

std::vector<RunStatus> status_of(const fs::path& out, const Campaign& campaign) {
  std::vector<RunStatus> all;
  for (const CampaignRun& run : campaign.runs) all.push_back(status_of(out, run));
  return all;
}

CampaignCost cost_of(const Campaign& campaign, const std::vector<RunStatus>& status) {
  CampaignCost cost;
  double work = 0.0, time = 0.0;
  for (std::size_t i = 0; i < campaign.runs.size(); ++i) {
    const double steps = campaign.runs[i].cost.particle_steps;
    cost.particle_steps += steps;
    cost.left += (1.0 - status[i].progress) * (status[i].state == RunState::failed ? 0.0 : steps);
    if (status[i].state != RunState::done || status[i].stored) continue;
    const double seconds = status[i].results.number_or_nan("wall_time_s");
    if (!std::isfinite(seconds)) continue;
    work += steps;
    time += seconds;
  }
  cost.measured = time > 0.0;
  constexpr double assumed_cores = 2.0;  // of assumed_particle_steps_per_s
  cost.particle_steps_per_s =
      cost.measured ? work / time : assumed_particle_steps_per_s / assumed_cores * campaign.plan.threads * campaign.plan.ranks;
  return cost;
}

}  // namespace mpm
