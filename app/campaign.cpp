/// `mpm campaign`: many runs of a plan in one folder, here or through Slurm, resumable.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <ranges>

#include "arguments.hpp"
#include "campaign_control.hpp"
#include "commands.hpp"
#include "libmpm/base/error.hpp"
#include "libmpm/base/process.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/campaign/campaign.hpp"
#include "libmpm/campaign/execution.hpp"
#include "libmpm/campaign/folder.hpp"
#include "libmpm/campaign/plan.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "ranks.hpp"
#include "run_control.hpp"

namespace mpm::app {

namespace {

namespace fs = std::filesystem;

fs::path this_program() { return fs::read_symlink("/proc/self/exe"); }

void print_line(const std::string& line) { fmt::print(stderr, "{}\n", line); }

std::string short_list(const std::vector<std::string>& names) {
  constexpr std::size_t most = 6;
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(std::min(most, names.size()));
  const std::string text = fmt::format("{}", fmt::join(names.begin(), end, ", "));
  return names.size() > most ? fmt::format("{} and {} more", text, names.size() - most) : text;
}

void print_changes(const Preparation& p) {
  const auto print = [](const std::vector<std::string>& names, const char* what) {
    if (!names.empty()) fmt::print(stderr, "{} {}: {}\n", counted(names.size(), "run"), what, short_list(names));
  };
  print(p.adopted, "computed under another name; the results are used");
  print(p.replaced, "changed since the last campaign; to be run again, and what was computed is kept beside them, as NAME.1");
  print(p.damaged, "with damaged results; to be run again");
  print(p.dropped, "in the folder but not in the plan; kept there, but not in the table");
}

std::ptrdiff_t count_of(RunState state, const std::vector<RunStatus>& status) {
  return std::ranges::count(status, state, &RunStatus::state);
}

/// Runs at a time: as many as asked for, unless more are running.
std::ptrdiff_t at_once(const std::vector<RunStatus>& status, int jobs) {
  return std::max<std::ptrdiff_t>(count_of(RunState::running, status), jobs);
}

/// Elapsed time until all runs are done, s.
double time_left(const CampaignCost& cost, std::ptrdiff_t runs_at_once) {
  return cost.left / (cost.particle_steps_per_s * static_cast<double>(runs_at_once));
}

/// The summary at the end of `run`, and of `status`.
void print_status(std::FILE* to, const Campaign& campaign, const std::vector<RunStatus>& status, const fs::path& out, int jobs, bool list) {
  const auto count = [&](RunState s) { return count_of(s, status); };
  fmt::print(to, "{}: {} in {}: {} done, {} running, {} failed, {} to do\n", campaign.plan.title.empty() ? "campaign" : campaign.plan.title,
             counted(campaign.runs.size(), "run"), out.string(), count(RunState::done), count(RunState::running), count(RunState::failed),
             count(RunState::to_do));
  if (const auto stored = std::ranges::count(status, true, &RunStatus::stored); stored > 0)
    fmt::print(to, "{} of the done ones are rows of stored results, not of this folder\n", stored);
  if (campaign.unused_rows > 0) {
    fmt::print(to, "{} of the stored results left out: no run of the plan has their case and duration, or another row is of the same\n",
               counted(campaign.unused_rows, "row"));
  }
  if (campaign.duplicates > 0)
    fmt::print(to, "{} of the plan left out because of an earlier one of the same case\n", counted(campaign.duplicates, "row"));
  const CampaignCost cost = cost_of(campaign, status);
  const std::ptrdiff_t runs_at_once = at_once(status, jobs);
  fmt::print(
      to, "work: {:.3g} particle-steps in all, {:.3g} left ({:.0f} %); {:.3g} million a second and run ({}): {} left with {} at a time\n",
      cost.particle_steps, cost.left, cost.particle_steps > 0.0 ? 100.0 * cost.left / cost.particle_steps : 0.0,
      1e-6 * cost.particle_steps_per_s, cost.measured ? "measured" : "assumed", clock_text(time_left(cost, runs_at_once)), runs_at_once);
  for (std::size_t i = 0; i < status.size(); ++i) {
    const CampaignRun& run = campaign.runs[i];
    const RunStatus& s = status[i];
    const bool shown = list || s.state == RunState::running || s.state == RunState::failed;
    if (!shown) continue;
    std::string line = fmt::format("  {:<8}{:<40} {:>5.1f} % of {:g} s  {:.2g} particle-steps", to_string(s.state), run.name,
                                   100.0 * s.progress, run.spec.output.duration, run.cost.particle_steps);
    if (s.state == RunState::running && !s.attempts.empty()) line += fmt::format("  since {}", s.attempts.back().started);
    if (s.state == RunState::failed) line += fmt::format("  {}: {}", counted(s.attempts.size(), "attempt"), s.cause());
    fmt::print(to, "{}\n", line);
  }
}

/// The same for programs.
void print_status_json(const Campaign& campaign, const std::vector<RunStatus>& status, int jobs) {
  nlohmann::ordered_json runs = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < status.size(); ++i) {
    const RunStatus& s = status[i];
    runs.push_back({{"name", campaign.runs[i].name}, {"state", to_string(s.state)}, {"progress", s.progress}, {"cause", s.cause()}});
  }
  nlohmann::ordered_json json{{"done", count_of(RunState::done, status)},
                              {"running", count_of(RunState::running, status)},
                              {"failed", count_of(RunState::failed, status)},
                              {"to_do", count_of(RunState::to_do, status)},
                              {"time_left_s", time_left(cost_of(campaign, status), at_once(status, jobs))}};
  json["runs"] = std::move(runs);
  fmt::print("{}\n", json.dump(2));
}

std::vector<std::size_t> all_of(const Campaign& campaign) {
  std::vector<std::size_t> runs(campaign.runs.size());
  std::iota(runs.begin(), runs.end(), std::size_t{0});
  return runs;
}

/// End of the command: tables, summary, exit code.
void conclude(const Campaign& campaign, const CampaignArguments& a, const fs::path& out, int jobs) {
  const std::vector<RunStatus> status = status_of(out, campaign);
  write_campaign_tables(out, campaign, status);
  print_status(a.summary, campaign, status, out, jobs, false);
  fmt::print(stderr, "wrote {} and runs.csv\n", (out / "results.csv").string());
  if (std::ranges::count(status, RunState::done, &RunStatus::state) != std::ssize(status))
    throw CLI::RuntimeError(static_cast<int>(ExitCode::failed));
}

/// Messages, and on request a line with the progress and the remaining time, estimated from the runs of this call.
class CampaignReports {
 public:
  CampaignReports(const Campaign& campaign, const CampaignArguments& a) : campaign_(campaign), out_(folder_of(a)), wanted_(a.progress) {}

  void message(const std::string& text) { line_.message(text); }
  void finish() { line_.finish(); }

  void show_progress() {
    if (!wanted_ || !line_.is_due()) return;
    const std::vector<RunStatus> status = status_of(out_, campaign_);
    double time = 0.0, duration = 0.0;  // s
    for (std::size_t i = 0; i < status.size(); ++i) {
      time += status[i].progress * campaign_.runs[i].spec.output.duration;
      duration += campaign_.runs[i].spec.output.duration;
    }
    const CampaignCost cost = cost_of(campaign_, status);
    if (!left_at_start_) left_at_start_ = cost.left;
    const double rate = (*left_at_start_ - cost.left) / seconds_since(started_);
    line_.show(1.0 - cost.left / cost.particle_steps, time, duration,
               fmt::format("{} of {} runs done", count_of(RunState::done, status), status.size()), cost.left / rate);
  }

 private:
  const Campaign& campaign_;
  fs::path out_;
  bool wanted_;
  ProgressLine line_;
  std::optional<double> left_at_start_;  ///< particle-steps
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
};

/// The folder of a campaign has runs/ first of all.
void require_own_folder(const fs::path& out) { require_no_other_files(out, {"plan.toml", "results.csv", "runs.csv"}, {"runs"}); }

void run_here(const Campaign& campaign, const CampaignArguments& a) {
  require_mpi(campaign.plan.ranks);
  const fs::path out = folder_of(a);
  const int jobs = a.jobs > 0 ? a.jobs : default_jobs(campaign.plan);
  require_memory(campaign, jobs, physical_memory_bytes());
  require_own_folder(out);
  make_directory(out);
  const DirectoryLock lock(out);
  if (const std::string note = lock.note(); !note.empty()) print_line(note);
  print_changes(prepare(out, campaign));
  listen_to_signals();
  CampaignReports reports(campaign, a);
  const auto poll = [&] {
    reports.show_progress();
    return pending_request();
  };
  const auto message = [&](const std::string& text) { reports.message(text); };
  ExecutionOptions options{out, this_program(), jobs, a.retry_failed, poll, message, {}};
  options.on_change = [&] { write_campaign_tables(out, campaign, status_of(out, campaign)); };
  const ExecutionReport report = execute(campaign, all_of(campaign), options);
  reports.finish();
  if (!report.finished) {
    write_campaign_tables(out, campaign, status_of(out, campaign));
    fmt::print(stderr, "stopped; the same command continues\n");
    end_by_signal();
  }
  conclude(campaign, a, out, jobs);
}

/// Runs to submit to Slurm: not complete, and without a failure that would recur.
std::vector<std::string> names_to_submit(const Campaign& campaign, const fs::path& out, bool retry_failed) {
  std::vector<std::string> names;
  for (const CampaignRun& run : campaign.runs) {
    const RunStatus s = status_of(out, run);
    const bool hopeless = s.hopeless() && (!retry_failed || !s.damage.empty());
    if (s.state != RunState::done && !hopeless) names.push_back(run.name);
  }
  return names;
}

void submit(const Campaign& campaign, const CampaignArguments& a, bool wait) {
  require_mpi(campaign.plan.ranks);
  const fs::path out = fs::absolute(folder_of(a));
  std::vector<std::string> names;
  SlurmJob job;
  {
    require_own_folder(out);
    make_directory(out);
    const DirectoryLock lock(out);
    print_changes(prepare(out, campaign));
    names = names_to_submit(campaign, out, a.retry_failed);
    if (!names.empty()) job = write_slurm_job(campaign.plan, a.plan.stem().string(), names, out, this_program(), a.jobs);
  }
  if (names.empty()) {
    fmt::print(stderr, "nothing to submit\n");
    return conclude(campaign, a, out, a.jobs);
  }
  const std::string id = submit_slurm_job(job, wait);
  fmt::print(stderr, "Slurm job {}: {} ({})\n", id, counted(names.size(), "task"), job.script.string());
  if (wait) conclude(campaign, a, out, a.jobs);
}

Campaign planned(const CampaignArguments& a) {
  CampaignPlan plan = read_plan(a.plan);
  constexpr std::size_t many = 2000;  // seconds of work
  if (plan.runs.size() > many) print_line(fmt::format("reading the cases of {} runs", plan.runs.size()));
  if (a.ranks > 0) plan.ranks = a.ranks;
  return make_campaign(std::move(plan));
}

void run(const CampaignArguments& a) { run_campaign(planned(a), a); }

void print_plan(const CampaignArguments& a) {
  const Campaign campaign = planned(a);
  fmt::print("{}", a.json ? expansion_json(campaign) : resolved_plan(campaign));
}

/// Writes the tables of a folder unless they belong to another plan, or to a version of the program with other case hashes. A campaign that
/// is running there keeps them itself.
void update_tables(const Campaign& campaign, const fs::path& out, const std::vector<RunStatus>& all, const Preparation& changes) {
  if (!fs::exists(out / "plan.toml")) return;
  if (read_file(out / "plan.toml") != resolved_plan(campaign) || !changes.replaced.empty())
    return fmt::print(stderr, "the tables in '{}' are of another plan, and stay as they are until `mpm campaign run`\n", out.string());
  if (std::ranges::any_of(all, [](const RunStatus& s) { return s.state == RunState::running; })) return;
  try {
    write_campaign_tables(out, campaign, all);
  } catch (const IoError& error) {
    fmt::print(stderr, "the tables are not brought up to date: {}\n", error.what());
  }
}

void status(const CampaignArguments& a) {
  const Campaign campaign = planned(a);
  const fs::path out = folder_of(a);
  const std::vector<RunStatus> all = status_of(out, campaign);
  const Preparation changes = compare_with_folder(out, campaign);
  print_changes(changes);
  update_tables(campaign, out, all, changes);  // before printing, which may wait for a reader
  const int jobs = a.jobs > 0 ? a.jobs : default_jobs(campaign.plan);
  if (a.json) {
    print_status_json(campaign, all, jobs);
  } else {
    print_status(stdout, campaign, all, out, jobs, a.list);
  }
}

/// One run, as a task of a Slurm array.
void run_task(const CampaignArguments& a) {
  const Campaign campaign = make_campaign(read_plan(a.out / "plan.toml"));
  const auto found = std::ranges::find(campaign.runs, a.name, &CampaignRun::name);
  if (found == campaign.runs.end()) {
    fmt::print(stderr, "{} is no longer in the plan\n", a.name);
    return;
  }
  listen_to_signals();
  // what had failed was chosen when the job was submitted
  ExecutionOptions options{a.out, this_program(), 1, true, pending_request, print_line, {}};
  const ExecutionReport report = execute(campaign, {static_cast<std::size_t>(found - campaign.runs.begin())}, options);
  if (!report.finished) end_by_signal();
  if (report.failed > 0) throw CLI::RuntimeError(static_cast<int>(ExitCode::failed));
}

void add_plan_argument(CLI::App& command, CampaignArguments& a) {
  command.add_option("plan", a.plan, "Plan of the campaign (docs/campaigns.md)")->required()->type_name("PLAN.toml");
}

void add_plan_arguments(CLI::App& command, CampaignArguments& a) {
  add_plan_argument(command, a);
  command.add_option("--out", a.out, "Folder of the campaign (default: out/<name of the plan>)")->type_name("DIR");
  add_jobs_argument(command, a, "Runs at a time (default: cores over threads a run; Slurm: as many as it grants)");
  add_ranks_argument(command, a.ranks, "Processes of each run (default: `ranks` of the plan, 1)");
}

}  // namespace

void add_jobs_argument(CLI::App& command, CampaignArguments& a, const std::string& text) {
  constexpr int most_jobs = 100000;
  command.add_option("--jobs", a.jobs, text)->check(in_range(1, most_jobs))->type_name("N");
}

void add_execution_arguments(CLI::App& command, CampaignArguments& a) {
  command.add_option("--executor", a.executor, "local, or slurm (submits, and waits for the end)")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->default_str("local");
  command.add_flag("--retry-failed", a.retry_failed, "Also runs whose failure would repeat itself (after a change of the program)");
}

fs::path folder_of(const CampaignArguments& a) { return a.out.empty() ? fs::path("out") / a.plan.stem() : a.out; }

void run_campaign(const Campaign& campaign, const CampaignArguments& a) {
  if (a.executor == "slurm") {
    submit(campaign, a, true);
  } else {
    run_here(campaign, a);
  }
}

void add_campaign(CLI::App& app) {
  CLI::App* campaign = app.add_subcommand("campaign", "Many runs of one plan, resumable after any interruption, with one table of results");
  campaign->require_subcommand(1);
  const auto a = std::make_shared<CampaignArguments>();

  CLI::App* run_command =
      campaign->add_subcommand("run", "Compute the runs that are not complete; exit code 0 if all are complete, 1 if runs failed");
  add_plan_arguments(*run_command, *a);
  add_execution_arguments(*run_command, *a);
  run_command->callback([a] { run(*a); });

  CLI::App* status_command = campaign->add_subcommand(
      "status", "List complete, running, failed and waiting runs, with the remaining time and the causes of failures; update the tables");
  add_plan_arguments(*status_command, *a);
  status_command->add_flag("--list", a->list, "Every run");
  status_command->add_flag("--json", a->json, "For programs: the numbers, and every run");
  status_command->callback([a] { status(*a); });

  CLI::App* plan_command = campaign->add_subcommand(
      "plan", "Print the plan with its base case and every run, its lists and included files resolved; compute nothing");
  add_plan_argument(*plan_command, *a);
  plan_command->add_flag("--json", a->json, "As JSON, with the hash of each case");
  plan_command->callback([a] { print_plan(*a); });

  CLI::App* submit_command = campaign->add_subcommand(
      "submit", "Submit the runs that are not complete to Slurm as an array job, one task for each run, and return");
  add_plan_arguments(*submit_command, *a);
  submit_command->add_option("--executor", a->executor, "slurm")->check(CLI::IsMember({"slurm"}))->default_str("slurm");
  submit_command->add_flag("--retry-failed", a->retry_failed, "Also runs whose failure would repeat itself");
  submit_command->callback([a] { submit(planned(*a), *a, false); });

  CLI::App* task =
      campaign->add_subcommand("task", "Compute one run of a campaign's folder; the tasks of a Slurm array job call this command");
  task->add_option("folder", a->out, "Folder of the campaign")->required()->type_name("DIR");
  task->add_option("name", a->name, "Name of the run")->required();
  task->callback([a] { run_task(*a); });
}

}  // namespace mpm::app
