#include "libmpm/campaign/plan_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "libmpm/campaign/plan_blocks.hpp"
#include "libmpm/config/guard.hpp"
#include "libmpm/config/toml_text.hpp"

namespace mpm {

namespace {

std::string toml_string(const std::string& text) { return config::toml_text(toml::value<std::string>(text)); }

std::string toml_list(const std::vector<std::string>& words) {
  std::vector<std::string> quoted;
  for (const std::string& word : words) quoted.push_back(toml_string(word));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

}  // namespace

CampaignPlan parse_plan(std::string_view text, const std::filesystem::path& file) {
  PlanBlocks blocks = read_blocks(text, file);
  blocks.plan.runs = expand(blocks, file);
  return std::move(blocks.plan);
}

CampaignPlan read_plan(const std::filesystem::path& file) { return parse_plan(config::bounded_file_text(file), file); }

std::string write_plan(const CampaignPlan& plan) {
  std::string out =
      fmt::format("format_version = {}\ntitle = {}\nthreads = {}\nretries = {}\norder = {}\n", plan_format_version, toml_string(plan.title),
                  plan.threads, plan.retries, toml_string(plan.longest_first ? "longest_first" : "plan"));
  if (plan.ranks > 1) out += fmt::format("ranks = {}\n", plan.ranks);
  if (!plan.launcher.empty()) out += fmt::format("launcher = {}\n", toml_list(plan.launcher));
  std::vector<std::string> keep;
  if (plan.keep_frames) keep.emplace_back(toml_string("frames"));
  if (plan.keep_final) keep.emplace_back(toml_string("final"));
  if (plan.keep_checkpoint) keep.emplace_back(toml_string("checkpoint"));
  out += fmt::format("keep = [{}]\n", fmt::join(keep, ", "));
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
  base.insert("base", toml::parse(plan.base_text));
  out += fmt::format("\n{}\n", config::toml_text(base));
  for (const PlannedRun& run : plan.runs) {
    out += fmt::format("\n[[run]]\nname = {}\n", toml_string(run.name));
    std::vector<std::string> set;
    for (const Setting& x : run.settings) set.push_back(fmt::format("{} = {}", toml_string(x.key), x.value));
    if (!set.empty()) out += fmt::format("set = {{ {} }}\n", fmt::join(set, ", "));
  }
  return out;
}

}  // namespace mpm
