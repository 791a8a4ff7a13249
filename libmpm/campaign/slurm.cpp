#include "libmpm/campaign/slurm.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <memory>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm {

namespace {

/// One word of a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

/// The batch script: Slurm tasks are the ranks of a run; the first starts the others. A word that a shell would take apart is quoted.
/// @throws ConfigError for a control character
std::string slurm_script(const CampaignPlan& plan, const std::string& job_name, const SlurmJob& job, std::size_t tasks,
                         const std::filesystem::path& out, const std::filesystem::path& program, int at_once) {
  std::string text = "#!/bin/bash\n";
  const auto line = [&](const std::string& words) {  // what follows a line break in a name or a key would be a command of its own
    if (std::ranges::any_of(words, [](unsigned char c) { return std::iscntrl(c) != 0; }))
      throw ConfigError(
          fmt::format("the job script cannot hold a line break or a control character, as in '{}'; change [slurm], the name of "
                      "the plan or --out",
                      plain_text(words)));
    text += words + "\n";
  };
  const auto option = [&](const std::string& o) { line("#SBATCH " + o); };
  option(fmt::format("--job-name={}", quoted(job_name)));
  option(fmt::format("--array=1-{}{}", tasks, at_once > 0 ? fmt::format("%{}", at_once) : ""));
  option(fmt::format("--ntasks={}", plan.ranks));
  option(fmt::format("--cpus-per-task={}", plan.threads));
  option(fmt::format("--output={}", quoted((out / "slurm" / "%A_%a.log").string())));
  option("--open-mode=append");
  option("--requeue");
  option("--signal=B:TERM@60");  // a minute before the time limit: the run writes its checkpoint
  const SlurmSpec& s = plan.slurm;
  if (!s.partition.empty()) option(fmt::format("--partition={}", quoted(s.partition)));
  if (!s.account.empty()) option(fmt::format("--account={}", quoted(s.account)));
  if (!s.qos.empty()) option(fmt::format("--qos={}", quoted(s.qos)));
  if (!s.time_limit.empty()) option(fmt::format("--time={}", quoted(s.time_limit)));
  if (!s.memory.empty()) option(fmt::format("--mem={}", quoted(s.memory)));
  for (const std::string& o : s.options) option(o);
  line("set -eu");
  line(fmt::format("name=$(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" {})", quoted(job.tasks.string())));
  line(fmt::format("exec {} campaign task {} \"$name\"", quoted(program.string()), quoted(out.string())));
  return text;
}

}  // namespace

SlurmJob write_slurm_job(const CampaignPlan& plan, const std::string& job_name, std::span<const std::string> names,
                         const std::filesystem::path& out, const std::filesystem::path& program, int at_once) {
  make_directory(out / "slurm");
  int number = 1;
  while (std::filesystem::exists(out / "slurm" / fmt::format("job_{}.sh", number))) ++number;
  SlurmJob job{out / "slurm" / fmt::format("job_{}.sh", number), out / "slurm" / fmt::format("job_{}.tasks", number)};
  write_file(job.tasks, fmt::format("{}\n", fmt::join(names, "\n")));
  write_file(job.script, slurm_script(plan, job_name, job, names.size(), out, program, at_once));
  return job;
}

std::string submit_slurm_job(const SlurmJob& job, bool wait) {
  const std::string command = fmt::format("sbatch --parsable {}{} 2>&1", wait ? "--wait " : "", quoted(job.script.string()));
  std::FILE* pipe = popen(command.c_str(), "re");
  if (pipe == nullptr) throw file_error("cannot run sbatch on", job.script, errno);
  std::string output;
  for (std::array<char, 256> part{}; std::fgets(part.data(), part.size(), pipe) != nullptr;) output += part.data();
  const int status = pclose(pipe);
  output.erase(output.find_last_not_of(" \n") + 1);
  std::string first = output.substr(0, output.find_first_of(";\n"));
  const bool is_number = !first.empty() && first.find_first_not_of("0123456789") == std::string::npos;
  // with --wait the exit code is that of the tasks; the job was taken if it has a number
  if (is_number) return first;
  constexpr int not_found = 127;
  throw IoError(fmt::format("sbatch did not take {}: {}", job.script.string(),
                            WIFEXITED(status) && WEXITSTATUS(status) == not_found ? "there is no sbatch; is Slurm installed?" : output));
}

}  // namespace mpm
