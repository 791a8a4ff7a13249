#include "libmpm/campaign/status.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/folder.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/json.hpp"

namespace mpm {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int attempts_format_version = 1;

}  // namespace

std::vector<Attempt> read_attempts(const fs::path& directory, const CampaignRun& run) {
  const fs::path file = directory / "attempts.json";
  if (!fs::exists(file)) return {};
  const Json json = read_json_object(file);
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
  } catch (const Json::exception&) {  // a value of another type
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
  all.reserve(campaign.runs.size());
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
