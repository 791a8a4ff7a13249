#include "libmpm/campaign/status.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/folder.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/io/json_object.hpp"

namespace mpm {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string to_string(RunState state) {
  switch (state) {
    case RunState::to_do: return "to do";
    case RunState::running: return "running";
    case RunState::done: return "done";
    case RunState::failed: return "failed";
  }
  return {};
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
  const auto computed = finished_results(directory, run.spec);
  if (computed || run.stored_results) {
    s.state = RunState::done;
    s.stored = !computed;
    s.results = computed ? *computed : *run.stored_results;
    s.progress = 1.0;
    return s;
  }
  if (const fs::path results = directory / "results.json"; fs::exists(results) && read_json_object(results).is_null())
    throw IoError(fmt::format("'{}' is damaged: it holds no JSON object; delete it, and the run is computed again", results.string()));
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
    const Json results = Json::parse(status[i].results, nullptr, false);
    const auto seconds = results.find("wall_time_s");
    if (seconds == results.end() || !seconds->is_number()) continue;
    work += steps;
    time += seconds->get<double>();
  }
  cost.measured = time > 0.0;
  constexpr double assumed_cores = 2.0;  // of assumed_particle_steps_per_s
  cost.particle_steps_per_s =
      cost.measured ? work / time : assumed_particle_steps_per_s / assumed_cores * campaign.plan.threads * campaign.plan.ranks;
  return cost;
}

}  // namespace mpm
