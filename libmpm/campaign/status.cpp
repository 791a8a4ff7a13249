#include "libmpm/campaign/status.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libmpm/campaign/folder.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/sampling.hpp"

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

std::string RunStatus::cause() const { return state == RunState::failed && !attempts.empty() ? attempts.back().cause : ""; }

RunStatus status_of(const fs::path& out, const CampaignRun& run) {
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
    work += steps;
    time += results.value("wall_time_s", 0.0);
  }
  cost.measured = time > 0.0;
  constexpr double assumed_cores = 2.0;  // of assumed_particle_steps_per_s
  cost.particle_steps_per_s =
      cost.measured ? work / time : assumed_particle_steps_per_s / assumed_cores * campaign.plan.threads * campaign.plan.ranks;
  return cost;
}

}  // namespace mpm
