#include "libmpm/campaign/plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <optional>

#include "libmpm/config/toml_text.hpp"

namespace mpm {

const std::map<std::string, std::string>& common_labels() {
  static const std::map<std::string, std::string> labels{
      {"material.model", ""},
      {"material.critical_state_slope", "m"},
      {"material.cohesion_beta", "beta"},
      {"material.hardening_xi", "xi"},
      {"conveyor.froude_number", "fr"},
      {"conveyor.velocity_m_s", "v"},
      {"conveyor.flow_height_m", "h"},
      {"conveyor.feed", ""},
      {"obstacle.width_m", "w"},
      {"obstacle.friction", "mu"},
      {"obstacle.friction_ratio", "mur"},
      {"obstacle.shape", ""},
      {"numerics.cell_size_m", "dx"},
      {"numerics.slope_deg", "slope"},
      {"numerics.transfer", ""},
      {"numerics.particles_per_cell", "ppc"},
      {"output.duration_s", "t"},
  };
  return labels;
}

std::string file_name_part(const std::string& text) {
  std::string part;
  for (const char c : text) {
    const bool safe = (std::isalnum(static_cast<unsigned char>(c)) != 0) || c == '.' || c == '_' || c == '+' || c == '-';
    if (safe) {
      part += c;
    } else if (!part.empty() && part.back() != '-') {
      part += '-';
    }
  }
  while (part.ends_with('-')) part.pop_back();
  return part;
}

std::string name_problem(const std::string& name) {
  constexpr std::size_t longest = 200;
  const bool usable = !name.empty() && name.size() <= longest && name == file_name_part(name) && name.front() != '.' && name.front() != '-';
  if (usable) return {};
  return fmt::format("\"{}\" names no folder; use 1 to {} letters, digits, '.', '_', '+' and '-', and do not begin with '.' or '-'",
                     config::one_line(name), longest);
}

namespace {

std::string toml_string(const std::string& text) { return config::toml_text(toml::value<std::string>(text)); }

std::string toml_list(const std::vector<std::string>& words) {
  std::vector<std::string> quoted;
  for (const std::string& word : words) quoted.push_back(toml_string(word));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

}  // namespace

std::string write_plan(const CampaignPlan& plan) {
  std::string out =
      fmt::format("format_version = {}\ntitle = {}\nthreads = {}\nretries = {}\norder = {}\n", plan_format_version, toml_string(plan.title),
                  plan.threads, plan.retries, toml_string(plan.longest_first ? "longest_first" : "plan"));
  if (plan.ranks > 1) out += fmt::format("ranks = {}\n", plan.ranks);
  if (!plan.launcher.empty()) out += fmt::format("launcher = {}\n", toml_list(plan.launcher));
  std::vector<std::string> keep;
  if (plan.keep_frames) keep.emplace_back("frames");
  if (plan.keep_final) keep.emplace_back("final");
  if (plan.keep_checkpoint) keep.emplace_back("checkpoint");
  out += fmt::format("keep = {}\n", toml_list(keep));
  if (!plan.stored_results.empty()) {
    std::vector<std::string> paths;
    for (const std::filesystem::path& path : plan.stored_results) paths.push_back(path.string());
    out += fmt::format("stored_results = {}\n", toml_list(paths));
  }
  const SlurmSpec& s = plan.slurm;
  if (s != SlurmSpec{}) {
    out += fmt::format("\n[slurm]\npartition = {}\naccount = {}\nqos = {}\ntime_limit = {}\nmemory = {}\noptions = {}\n",
                       toml_string(s.partition), toml_string(s.account), toml_string(s.qos), toml_string(s.time_limit),
                       toml_string(s.memory), toml_list(s.options));
  }
  toml::table base;
  toml::table tables = toml::parse(plan.base_text);
  const std::array<std::string, 2> files = {"conveyor.inflow_csv", "terrain.file"};  // relative to the base, and this plan is elsewhere
  const auto beside_base = [&](const std::string& name) {
    return (std::filesystem::absolute(plan.base_name).parent_path() / name).string();
  };
  for (const std::string& key : files) {
    if (auto* const name = tables.at_path(key).as_string()) *name = beside_base(name->get());
  }
  base.insert("base", std::move(tables));
  out += fmt::format("\n{}\n", config::document_text(base));
  for (const PlannedRun& run : plan.runs) {
    out += fmt::format("\n[[run]]\nname = {}\n", toml_string(run.name));
    std::vector<std::string> set;
    for (const Setting& x : run.settings) {
      const auto file = std::ranges::find(files, x.key) != files.end() ? toml::parse("value = " + x.value)["value"].value<std::string>()
                                                                       : std::optional<std::string>();
      set.push_back(fmt::format("{} = {}", toml_string(x.key), file ? toml_string(beside_base(*file)) : x.value));
    }
    if (!set.empty()) out += fmt::format("set = {{ {} }}\n", fmt::join(set, ", "));
  }
  return out;
}

}  // namespace mpm
