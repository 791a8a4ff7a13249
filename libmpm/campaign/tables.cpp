
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "libmpm/campaign/folder.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/impact/steady.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

namespace {

/// Entries of results.json that results.csv has, although they describe the computation: what a row needs to be judged by itself.
constexpr std::array<std::string_view, 4> row_entries{"version", "commit", "precision", "steady_column"};
constexpr std::array<std::string_view, 2> stop_entries{"stop_when_steady", "stopped_when_steady"};  // if the plan has that rule

/// Entries of results.json that describe the computation, not the physics: columns of runs.csv, except for those that results.csv has and
/// those that need none.
std::vector<std::string> execution_columns() {
  std::vector<std::string> names = run_entries(Nature::execution);
  std::erase_if(names, [](const std::string& name) {
    const auto among = [&](const auto& entries) { return std::ranges::find(entries, name) != entries.end(); };
    return among(row_entries) || among(stop_entries) || name == "format_version" || name == "title" || name == "case_hash" ||
           name.ends_with("crc32");
  });
  return names;
}

std::string cell_of(const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* count = std::get_if<std::uint64_t>(&value)) return std::to_string(*count);
  return format_number(as_number(value).value_or(MeanEstimate::none));
}

/// The cell of an entry; empty where the run has none.
std::string cell_of(const Results& results, const std::string& name) {
  const Result* const result = results.find(name);
  return result == nullptr ? "" : cell_of(result->value);
}

/// The metrics of all runs, vectors by component: the names in the order in which they first appear, and for each run its cells by name.
struct Metrics {
  std::vector<std::string> names;
  std::vector<std::map<std::string, std::string>> cells;
};

Metrics metrics_of(const std::vector<RunStatus>& status) {
  Metrics m;
  for (const RunStatus& s : status) {
    std::map<std::string, std::string>& row = m.cells.emplace_back();
    for (const Result& r : s.results.components()) {
      if (nature_of(r.name) == Nature::execution) continue;
      if (std::ranges::find(m.names, r.name) == m.names.end()) m.names.push_back(r.name);
      row.emplace(r.name, cell_of(r.value));
    }
  }
  return m;
}

/// Keys of the plan's settings without an input column that vary between runs.
std::vector<std::string> other_varied_keys(const Campaign& campaign) {
  std::vector<std::string> keys;
  for (const CampaignRun& run : campaign.runs) {
    for (const Setting& s : run.settings) {
      if (std::ranges::find(keys, s.key) == keys.end()) keys.push_back(s.key);
    }
  }
  std::erase_if(keys, [&, inputs = inputs_of({})](const std::string& key) {
    if (std::ranges::any_of(inputs, [&](const RunInput& i) { return key == i.key; })) return true;
    const auto same = [&](const CampaignRun& r) {
      const auto& first = campaign.runs.front();
      return case_value(r.spec, key) == case_value(first.spec, key);
    };
    return std::ranges::all_of(campaign.runs, same);
  });
  return keys;
}

std::string results_table(const Campaign& campaign, const std::vector<RunStatus>& status) {
  std::vector<std::vector<RunInput>> inputs;  // of each run, those that a run has
  for (const CampaignRun& run : campaign.runs) inputs.push_back(inputs_of(run.spec));
  for (std::size_t k = inputs_of({}).size(); k-- > 0;) {
    if (std::ranges::any_of(inputs, [&](const auto& row) { return std::isfinite(row[k].value); })) continue;
    for (auto& row : inputs) row.erase(row.begin() + static_cast<std::ptrdiff_t>(k));
  }
  const std::vector<std::string> others = other_varied_keys(campaign);
  const Metrics metrics = metrics_of(status);
  std::vector<std::string> entries(row_entries.begin(), row_entries.end());
  if (std::ranges::any_of(campaign.runs, [](const CampaignRun& r) { return r.spec.output.stop_when_steady > 0.0; }))
    entries.insert(entries.end(), stop_entries.begin(), stop_entries.end());
  std::vector<std::string> head{"name", "run", "status", "case_hash"};
  head.insert(head.end(), entries.begin(), entries.end());
  for (const RunInput& input : inputs.empty() ? std::vector<RunInput>() : inputs.front()) head.emplace_back(input.column);
  head.insert(head.end(), others.begin(), others.end());
  head.insert(head.end(), metrics.names.begin(), metrics.names.end());
  head.emplace_back("cause");
  std::string text = csv_line(head);
  for (std::size_t i = 0; i < campaign.runs.size(); ++i) {
    const CampaignRun& run = campaign.runs[i];
    // what is under way now is no property of the run: the table does not depend on when it is written
    const RunState state = status[i].state == RunState::running ? RunState::to_do : status[i].state;
    std::vector<std::string> row{run.name, "runs/" + run.name, to_string(state), run.case_hash};
    for (const std::string& key : entries) row.push_back(cell_of(status[i].results, key));
    for (const RunInput& input : inputs[i]) row.push_back(format_number(input.value));
    for (const std::string& key : others) row.push_back(case_value(run.spec, key).value_or(""));
    for (const std::string& name : metrics.names) {
      const auto cell = metrics.cells[i].find(name);
      row.push_back(cell == metrics.cells[i].end() ? "" : cell->second);
    }
    row.push_back(state == RunState::failed ? status[i].cause() : "");
    text += csv_line(row);
  }
  return text;
}

std::string executions_table(const Campaign& campaign, const std::vector<RunStatus>& status) {
  std::vector<std::string> head{"name", "status",       "attempts",  "first_started", "last_ended",
                                "host", "last_outcome", "exit_code", "signal",        "cause"};
  const std::vector<std::string> entries = execution_columns();
  head.insert(head.end(), entries.begin(), entries.end());
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
    for (const std::string& key : entries) row.push_back(cell_of(status[i].results, key));
    text += csv_line(row);
  }
  return text;
}

}  // namespace

void write_campaign_tables(const std::filesystem::path& out, const Campaign& campaign, const std::vector<RunStatus>& status) {
  write_file(out / "results.csv", results_table(campaign, status));
  write_file(out / "runs.csv", executions_table(campaign, status));
}

}  // namespace mpm
