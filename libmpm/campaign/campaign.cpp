#include "libmpm/campaign/campaign.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <sstream>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/campaign/stored_results.hpp"
#include "libmpm/config/file_problems.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/sampling.hpp"
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

}  // namespace

Campaign make_campaign(CampaignPlan plan) {
  Campaign campaign;
  SharedProblems problems;
  const std::string prefix = plan.file.empty() ? "--set " : plan.file + ": ";
  std::map<std::pair<std::string, double>, std::size_t> known;  // case and end -> index
  std::map<std::string, std::size_t> names;
  for (const PlannedRun& planned : plan.runs) {
    if (problems.full()) break;
    CampaignRun run{planned.name, planned.settings, {}, {}, {}, {}};
    try {
      run.spec = parse_case(plan.base_text, plan.base_name, overrides_of(plan, planned), prefix);
    } catch (const ConfigError& error) {
      problems.add(error.what(), planned.name);
      continue;
    }
    run.spec.title = plan.title.empty() ? run.name : fmt::format("{}: {}", plan.title, run.name);
    run.case_hash = case_hash_text(run.spec);
    run.cost = estimate(run.spec);
    if (!known.try_emplace({run.case_hash, Sampling(run.spec).end()}, campaign.runs.size()).second) {
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
  campaign.unused_rows = stored.rows();
  for (CampaignRun& run : campaign.runs) {
    run.stored_results = stored.of(run.spec, run.case_hash);
    if (run.stored_results) --campaign.unused_rows;
  }
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
