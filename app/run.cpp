/// `mpm run`: computes a case into a directory.

#include "mpm/run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <ctime>
#include <memory>

#include "case_arguments.hpp"
#include "commands.hpp"
#include "mpm/estimate.hpp"
#include "mpm/io/config.hpp"

namespace mpm::app {

namespace {

std::string clock_text(double seconds) {
  const long long s = std::llround(seconds);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60) : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// Progress on stderr: one line that is rewritten on a terminal, plain lines now and then elsewhere.
class ProgressLine {
 public:
  void operator()(const Progress& p) {
    if (!p.message.empty()) {
      fmt::print(stderr, "{}{}\n", open_ ? "\r\033[K" : "", p.message);
      open_ = false;
      return;
    }
    const auto now = Clock::now();
    const bool last = p.time >= p.duration;
    if (!last && now - shown_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000))) return;
    shown_ = now;
    const double percent = p.duration > 0.0 ? 100.0 * p.time / p.duration : 100.0;
    const std::string line =
        fmt::format("{:5.1f} %  t = {:.3f} of {:g} s  step {}  dt {:.3g} s  {} particles  {:.1f} M particle-steps/s  {} left", percent,
                    p.time, p.duration, p.step, p.dt, p.particles, p.million_particle_steps_per_s, clock_text(p.eta_s));
    fmt::print(stderr, "{}{}{}", terminal_ ? "\r" : "", line, terminal_ ? "\033[K" : "\n");
    open_ = terminal_;
  }

  /// Ends the line that stands.
  void finish() {
    if (open_) fmt::print(stderr, "\n");
    open_ = false;
  }

  ProgressLine() = default;
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() { finish(); }

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_ = isatty(STDERR_FILENO) == 1;
  bool open_ = false;  ///< a line stands without its end
  Clock::time_point shown_ = Clock::now() - std::chrono::hours(1);
};

/// SIGINT and SIGTERM ask for a checkpoint and an end at the next sample; SIGUSR1 asks for a checkpoint only.
std::atomic<int> stop_signal{0};
std::atomic<long long> stop_asked_at{0};  ///< ms on the monotonic clock
std::atomic<bool> checkpoint_wanted{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<long long>::is_always_lock_free, "set in a signal handler");

/// A second request ends the process at once, but one that follows within a second is the same request: `timeout` and some batch
/// systems signal the process and then its whole group, and the checkpoint must not be lost to that.
void ask_to_stop(int number) {
  constexpr long long same_request = 1000;  // ms
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  const long long now = t.tv_sec * 1000LL + t.tv_nsec / 1000000;
  if (stop_signal == 0) {
    stop_signal = number;
    stop_asked_at = now;
  } else if (now - stop_asked_at > same_request) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
}

void ask_for_checkpoint(int) { checkpoint_wanted = true; }

Request pending_request() {
  if (stop_signal != 0) return Request::stop;
  return checkpoint_wanted.exchange(false) ? Request::checkpoint : Request::none;
}

struct RunArguments {
  CaseArguments input;
  std::filesystem::path out;
  int threads = 0;
  bool resume = false;
};

void run(const RunArguments& arguments) {
  const Case spec = read_case(arguments.input.file, arguments.input.overrides);
  require_memory(estimate(spec), physical_memory_bytes());

  RunOptions options;
  options.out = arguments.out.empty() ? std::filesystem::path("out") / arguments.input.file.stem() : arguments.out;
  options.threads = arguments.threads;
  options.resume = arguments.resume;
  const auto progress = std::make_shared<ProgressLine>();
  options.on_progress = [progress](const Progress& p) { (*progress)(p); };
  options.poll = pending_request;
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  std::signal(SIGUSR1, ask_for_checkpoint);
  const RunResult result = run_case(spec, options);
  progress->finish();
  if (!result.finished) {
    fmt::print(stderr, "stopped at t = {:.4g} s; go on with --resume --out {}\n", result.time, options.out.string());
    std::signal(stop_signal, SIG_DFL);  // whoever started this sees that it was stopped
    std::raise(stop_signal);
  }
  fmt::print(stderr, "results in {}\n", options.out.string());
  fmt::print("{}\n", result.results_json);
}

}  // namespace

void add_run(CLI::App& app) {
  CLI::App* command = app.add_subcommand("run", "Compute a case; writes the results to a directory and prints results.json");
  const auto arguments = std::make_shared<RunArguments>();
  add_case_arguments(*command, arguments->input);
  command->add_option("--out", arguments->out, "Directory of the results (default: out/<name of the case file>)")->type_name("DIR");
  constexpr int most_threads = 1024;
  command->add_option("--threads", arguments->threads, "Number of threads (default: all cores)")
      ->check(CLI::Range(1, most_threads))
      ->type_name("N");
  command->add_flag("--resume", arguments->resume, "Go on from the last checkpoint, or extend a finished run to a longer duration");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace mpm::app
