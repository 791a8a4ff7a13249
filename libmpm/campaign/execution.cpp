#include "libmpm/campaign/execution.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <deque>
#include <fstream>
#include <iterator>
#include <numeric>
#include <sstream>
#include <string_view>
#include <system_error>
#include <thread>

#include "libmpm/base/error.hpp"
#include "libmpm/base/process.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/campaign/folder.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm {

// ---- On this machine -------------------------------------------------------------------------------------------------------------------

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

std::string utc_now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

/// Last line that is not empty and not the hint behind a wrong argument, or its end.
std::string last_line(const fs::path& file) {
  constexpr std::streamoff longest = 4096;  // bytes
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  in.seekg(-std::min<std::streamoff>(longest, in.tellg()), std::ios::end);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  text.erase(std::min(text.size(), text.rfind("Run with --help")));
  text.erase(text.find_last_not_of(" \n\r") + 1);
  return plain_text(std::string_view(text).substr(text.rfind('\n') + 1));  // npos + 1 = 0
}

/// Keeps the signals of a campaign back until the end of the scope, so that a child never runs the handlers of this process: what they note
/// is lost with exec.
class HeldSignals {
 public:
  HeldSignals() {
    sigset_t held;
    sigemptyset(&held);
    for (const int number : numbers) sigaddset(&held, number);
    pthread_sigmask(SIG_BLOCK, &held, &before_);
  }
  ~HeldSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

  /// In the child: until its program has handlers of its own, a stop ends it, and the wish for a checkpoint is of no effect.
  void release_in_child() const {
    for (const int number : numbers) std::signal(number, number == SIGUSR1 ? SIG_IGN : SIG_DFL);
    sigprocmask(SIG_SETMASK, &before_, nullptr);
  }

 private:
  static constexpr int numbers[] = {SIGINT, SIGTERM, SIGUSR1, SIGUSR2};
  sigset_t before_{};
};

/// Runs in the child between fork and exec, where few functions are allowed. Never returns.
[[noreturn]] void become(char* const* arguments, const char* output, pid_t parent, int stop, const HeldSignals& held) {
  setpgid(0, 0);
  held.release_in_child();
  prctl(PR_SET_PDEATHSIG, stop);
  if (getppid() != parent) _exit(1);  // the parent ended before the line above
  const int nothing = open("/dev/null", O_RDWR), log = open(output, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW, 0666);
  if (nothing < 0 || log < 0) _exit(static_cast<int>(ExitCode::io));
  dup2(nothing, STDIN_FILENO);
  dup2(nothing, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execv(arguments[0], arguments);
  constexpr int not_found = 127;  // the exit code of a shell
  _exit(not_found);
}

/// Path of a launcher's program. @throws ConfigError
std::string found_in_path(const std::string& command) {
  if (command.find('/') != std::string::npos) return command;
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::string candidate = (fs::path(folder) / command).string();
    if (access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  throw ConfigError(
      fmt::format("several ranks are started by {}, which is not installed (Debian: openmpi-bin, or `./run build mpi`)", command));
}

/// The words before the command line of a run on several ranks; none for one rank. The ranks share the cores of this machine or of this
/// Slurm job, and are not bound to cores, because several runs may share a machine. @throws ConfigError
std::vector<std::string> launcher_words(const CampaignPlan& plan) {
  if (plan.ranks == 1) return {};
  std::vector<std::string> words = plan.launcher;
  if (words.empty()) {
    words = {"mpirun", "-np", ranks_placeholder, "--quiet", "--oversubscribe", "--bind-to", "none"};
    if (geteuid() == 0) words.emplace_back("--allow-run-as-root");
  }
  for (std::string& word : words) {
    if (const auto at = word.find(ranks_placeholder); at != std::string::npos)
      word.replace(at, std::string_view(ranks_placeholder).size(), std::to_string(plan.ranks));
  }
  words.front() = found_in_path(words.front());
  return words;
}

/// Sent to a launcher, it asks the ranks for a checkpoint and an end: mpirun and srun pass it on. After SIGTERM mpirun kills them soon;
/// a longer delay (odls_base_sigkill_timeout) would also delay the end after a rank has failed.
constexpr int stop_through_launcher = SIGUSR2;

/// A running process.
struct Child {
  std::size_t run;
  pid_t process;
};

class Pool {
 public:
  Pool(const Campaign& campaign, const std::vector<std::size_t>& runs, const ExecutionOptions& options)
      : campaign_(campaign),
        options_(options),
        launcher_(launcher_words(campaign.plan)),
        stop_(launcher_.empty() ? SIGTERM : stop_through_launcher),
        failures_(campaign.runs.size(), 0) {
    for (const std::size_t i : runs) {
      const RunStatus status = status_of(options.out, campaign.runs[i]);
      if (status.state == RunState::done) {
        attempt(i, [&] { tidy_run(options.out, campaign.plan, campaign.runs[i]); });
      } else if (!status.damage.empty()) {
        fail(i, status.damage);
      } else if (status.hopeless() && !options.retry_failed) {
        say(fmt::format("{}: failed before, and would again: {}", campaign.runs[i].name, status.cause()));
      } else {
        waiting_.push_back(i);
      }
    }
    if (!campaign.plan.longest_first) return;
    std::ranges::stable_sort(waiting_, std::greater{}, [&](std::size_t i) { return campaign.runs[i].cost.particle_steps; });
  }

  ExecutionReport go() {
    constexpr std::chrono::milliseconds pause(50);
    for (;;) {
      listen();
      reap();
      if (!stopping_) start_some();
      if (children_.empty() && (stopping_ || waiting_.empty())) break;
      std::this_thread::sleep_for(pause);
    }
    report_.finished = !stopping_;
    return report_;
  }

 private:
  void say(const std::string& line) const {
    if (options_.say) options_.say(line);
  }

  void fail(std::size_t i, const std::string& why) {
    ++report_.failed;
    say(fmt::format("{}: failed: {}", campaign_.runs[i].name, why));
  }

  /// Does something in the folder of one run. A file there that cannot be used is the failure of this run alone. @return whether it worked
  template <class Action>
  bool attempt(std::size_t i, Action&& action) {
    try {
      action();
      return true;
    } catch (const Error& error) {
      fail(i, error.what());
    } catch (const std::system_error& error) {  // of the file system
      fail(i, error.what());
    }
    return false;
  }

  void listen() {
    const Request request = options_.poll ? options_.poll() : Request::none;
    if (request == Request::checkpoint) {
      for (const Child& c : children_) kill(c.process, SIGUSR1);
    }
    if (request == Request::stop && !stopping_) {
      stopping_ = true;
      say(fmt::format("stopping: {} runs write their checkpoints", children_.size()));
      for (const Child& c : children_) kill(c.process, stop_);
    }
  }

  void reap() {
    for (std::size_t i = 0; i < children_.size();) {
      int status = 0;
      const pid_t ended = waitpid(children_[i].process, &status, WNOHANG);
      if (ended == 0 || (ended < 0 && errno == EINTR)) {
        ++i;
        continue;
      }
      const std::size_t run = children_[i].run;
      children_.erase(children_.begin() + static_cast<std::ptrdiff_t>(i));
      attempt(run, [&] { record(run, status); });
      if (options_.on_change) options_.on_change();
    }
  }

  void start_some() {
    if (Clock::now() < look_again_) return;
    for (std::size_t k = 0; k < waiting_.size() && children_.size() < static_cast<std::size_t>(options_.jobs);) {
      const std::size_t i = waiting_[k];
      const CampaignRun& run = campaign_.runs[i];
      if (is_locked(run_directory(options_.out, run))) {  // by a process of an earlier campaign or of another executor
        if (std::ranges::find(waited_for_, i) == waited_for_.end()) say(fmt::format("{}: another process works on it; waiting", run.name));
        waited_for_.push_back(i);
        look_again_ = Clock::now() + std::chrono::milliseconds(500);
        ++k;
        continue;
      }
      waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(k));
      bool done = false;
      int attempts = 0;
      const bool ready = attempt(i, [&] {
        done = finished_results(run_directory(options_.out, run), run.spec).has_value();
        if (done)
          tidy_run(options_.out, campaign_.plan, run);  // completed by that other process in the meantime
        else
          attempts = begin_attempt(run);
      });
      if (ready && !done) start(i, attempts);
    }
  }

  /// Prepares the folder, and records that an attempt begins. @return its number, from 1
  int begin_attempt(const CampaignRun& run) {
    const fs::path directory = run_directory(options_.out, run);
    prepare_run(options_.out, run);
    std::vector<Attempt> attempts = read_attempts(directory, run);
    attempts.push_back({});
    attempts.back().started = utc_now();
    attempts.back().host = host_name();
    write_attempts(directory, run, attempts);
    return static_cast<int>(attempts.size());
  }

  void start(std::size_t i, int attempts) {
    const CampaignRun& run = campaign_.runs[i];
    const fs::path directory = run_directory(options_.out, run);
    std::vector<std::string> words = launcher_;
    words.insert(words.end(), {options_.program.string(), "run", (directory / "case.toml").string(), "--out", directory.string(),
                               "--threads", std::to_string(campaign_.plan.threads), "--resume"});
    const std::vector<char*> arguments = exec_arguments(words);
    const std::string output = (directory / "stderr.log").string();
    const HeldSignals held;
    const pid_t parent = getpid(), child = fork();
    if (child < 0) throw IoError(fmt::format("cannot start a process for {}: {}; use fewer --jobs", run.name, std::strerror(errno)));
    if (child == 0) become(arguments.data(), output.c_str(), parent, stop_, held);
    children_.push_back({i, child});
    say(fmt::format("{}: {}", run.name, attempts > 1 ? fmt::format("goes on (attempt {})", attempts) : "started"));
  }

  /// Records the outcome of a run, and decides whether to repeat it.
  void record(std::size_t i, int status) {
    const CampaignRun& run = campaign_.runs[i];
    const fs::path directory = run_directory(options_.out, run);
    std::vector<Attempt> attempts = read_attempts(directory, run);
    if (attempts.empty()) attempts.push_back({});
    Attempt& a = attempts.back();
    a.ended = utc_now();
    constexpr int by_signal = 128;  // and its number: the exit code of a launcher whose program a signal has ended
    if (WIFSIGNALED(status))
      a.signal = WTERMSIG(status);
    else if (!launcher_.empty() && WEXITSTATUS(status) > by_signal)
      a.signal = WEXITSTATUS(status) - by_signal;
    else
      a.exit_code = WEXITSTATUS(status);
    bool again = false;
    if (finished_results(directory, run.spec)) {
      a.outcome = "done";
      tidy_run(options_.out, campaign_.plan, run);
      say(fmt::format("{}: done", run.name));
    } else if (stopping_ && (a.signal == stop_ || a.signal == SIGTERM || a.signal == SIGINT)) {
      a.outcome = "stopped";
    } else {
      a.outcome = "failed";
      const std::string words = last_line(directory / "stderr.log");
      a.cause = a.signal           ? fmt::format("ended by signal {} ({}){}{}", *a.signal, strsignal(*a.signal),
                                       *a.signal == SIGKILL ? ", perhaps out of memory" : "", words.empty() ? "" : ": " + words)
                : a.exit_code == 0 ? "ended well, but left no results.json of this case"
                                   : fmt::format("exit code {}: {}", *a.exit_code, words);
      a.final = a.exit_code == static_cast<int>(ExitCode::unstable);
      const bool refused = a.exit_code == static_cast<int>(ExitCode::usage);  // now: by its threads, or the memory of this machine
      again = !a.final && !refused && failures_[i]++ < campaign_.plan.retries;
      report_.failed += again ? 0 : 1;
      say(fmt::format("{}: failed{}: {}", run.name, again ? ", is tried again" : "", a.cause));
    }
    write_attempts(directory, run, attempts);
    if (again) waiting_.push_front(i);
  }

  const Campaign& campaign_;
  const ExecutionOptions& options_;
  std::vector<std::string> launcher_;  ///< command that precedes that of a child
  int stop_;                           ///< signal that makes a child write its checkpoint and end
  std::deque<std::size_t> waiting_;    ///< in the order of their start
  std::vector<Child> children_;
  std::vector<int> failures_;            ///< of each run, in this call
  std::vector<std::size_t> waited_for_;  ///< runs for which a message reported that another process works on them
  Clock::time_point look_again_ = Clock::now();
  bool stopping_ = false;
  ExecutionReport report_;
};

}  // namespace

ExecutionReport execute(const Campaign& campaign, const std::vector<std::size_t>& runs, const ExecutionOptions& options) {
  return Pool(campaign, runs, options).go();
}

int default_jobs(const CampaignPlan& plan) {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / (plan.ranks * plan.threads));
}

void require_memory(const Campaign& campaign, int jobs, double limit_bytes) {
  std::vector<double> need;
  for (const CampaignRun& run : campaign.runs) need.push_back(run.cost.memory_bytes);
  std::ranges::sort(need, std::greater{});
  need.resize(std::min(need.size(), static_cast<std::size_t>(jobs)));
  const double sum = std::accumulate(need.begin(), need.end(), 0.0);
  if (sum <= limit_bytes) return;
  const std::string what = need.size() == 1 ? "the largest run needs" : fmt::format("the {} largest runs together need", need.size());
  throw ConfigError(fmt::format("{} about {:.3g} GB, this machine has {:.3g} GB; {}", what, sum / 1e9, limit_bytes / 1e9,
                                need.size() == 1 ? "take a larger numerics.cell_size_m or less snow" : "give a smaller --jobs"));
}

// ---- Through Slurm ---------------------------------------------------------------------------------------------------------------------

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
