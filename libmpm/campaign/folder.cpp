#include "libmpm/campaign/folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <system_error>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/plan.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm {

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

/// What does not match its checksums in a finished run, which is then computed again in its place; empty: nothing, or what cannot be read
/// at all, which status_of() reports.
std::string damage_of_finished(const fs::path& directory, const Case& c) {
  std::string damage;
  (void)answer_or_false([&] {
    const ResultsFile file(directory);
    if (fs::exists(directory / "case.toml") && !file.is_finished(c)) damage = file.damage();
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

double last_time(const fs::path& series) {
  if (!fs::exists(series)) return 0.0;
  std::string text = read_file(series);
  text.erase(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n'));
  const auto start = text.rfind('\n');
  return start == std::string::npos ? 0.0 : std::strtod(text.c_str() + start + 1, nullptr);
}

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

}  // namespace mpm
