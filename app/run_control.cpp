#include "run_control.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "libmpm/driver/advice.hpp"

namespace mpm::app {

namespace {

/// SIGINT, SIGTERM, SIGUSR2 and SIGHUP request a checkpoint and the end at the next sample; SIGUSR1 requests only a checkpoint.
std::atomic<int> stop_signal{0};
std::atomic<long long> stop_asked_at{0};  ///< ms on the monotonic clock
std::atomic<bool> checkpoint_wanted{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<long long>::is_always_lock_free, "set in a signal handler");

/// A second request ends the process at once, but one that follows within a second is the same request: `timeout` and some batch
/// systems signal the process and then its whole group, which must not prevent the checkpoint.
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

}  // namespace

std::string clock_text(double seconds) {
  constexpr double day = 86400.0, year = 365.25 * day;
  if (!std::isfinite(seconds)) return "unknown time";
  if (seconds >= 2.0 * year) return fmt::format("{:.3g} years", seconds / year);
  if (seconds >= 4.0 * day) return fmt::format("{:.0f} days", seconds / day);
  const long long s = std::llround(seconds);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60) : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

void say(const std::string& text) { std::fputs(text.c_str(), stderr); }

void print_advice(const Case& spec) {
  for (const Advice& advice : advise(spec)) say(fmt::format("warning: {}\n", advice.text()));
}

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) == 1) {}

void ProgressLine::operator()(const Progress& p) {
  if (!p.message.empty()) return message(p.message);
  if (p.time < p.duration && !is_due()) return;
  show(p.duration > 0.0 ? p.time / p.duration : 1.0, p.time, p.duration,
       fmt::format("step {}  dt {:.3g} s  {} particles  {:.1f} M particle-steps/s", p.step, p.dt, p.particles,
                   p.million_particle_steps_per_s),
       p.eta_s);
}

bool ProgressLine::is_due() const {
  return Clock::now() - shown_ >= (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000));
}

void ProgressLine::show(double fraction, double time, double duration, const std::string& more, double left) {
  shown_ = Clock::now();
  const std::string line =
      fmt::format("{:5.1f} %  t = {:.3f} of {:g} s  {}  {} left", 100.0 * fraction, time, duration, more, clock_text(left));
  say(fmt::format("{}{}{}", terminal_ ? "\r" : "", line, terminal_ ? "\033[K" : "\n"));
  open_ = terminal_;
}

void ProgressLine::message(const std::string& text) {
  say(fmt::format("{}{}\n", open_ ? "\r\033[K" : "", text));
  open_ = false;
}

void ProgressLine::finish() {
  if (open_) say("\n");
  open_ = false;
}

void listen_to_signals() {
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  std::signal(SIGUSR2, ask_to_stop);  // mpirun passes it on, and does not kill afterwards
  std::signal(SIGUSR1, ask_for_checkpoint);
  if (std::signal(SIGHUP, ask_to_stop) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // under nohup the run continues without the terminal
  std::signal(SIGXFSZ, SIG_IGN);                                                  // a file beyond the limit then gives an error of write()
  std::signal(SIGPIPE, SIG_IGN);                                                  // a closed pipe must not end the run
}

Request pending_request() {
  if (stop_signal != 0) return Request::stop;
  return checkpoint_wanted.exchange(false) ? Request::checkpoint : Request::none;
}

void end_by_signal() {
  std::signal(stop_signal, SIG_DFL);
  std::raise(stop_signal);
  std::abort();  // the signal ends the process
}

}  // namespace mpm::app
