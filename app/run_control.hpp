#pragma once
/// Common parts of the commands that compute: the progress line, and signals that request a checkpoint or the end.

#include <chrono>
#include <string>

#include "libmpm/driver/run.hpp"

namespace mpm::app {

/// Progress on stderr: one line that is rewritten on a terminal, otherwise plain lines at intervals.
class ProgressLine {
 public:
  ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() { finish(); }

  void operator()(const Progress& p);
  /// The line of several runs, at the same intervals. @param time, duration  s, simulated. @param more  further text. @param left  s
  void show(double fraction, double time, double duration, const std::string& more, double left);
  /// Whether a line is due; until then there is no need to know the progress.
  [[nodiscard]] bool is_due() const;
  /// Prints a line of another kind.
  void message(const std::string& text);
  /// Ends the current line.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool open_ = false;  ///< the last line has no line break yet
  Clock::time_point shown_ = Clock::now() - std::chrono::hours(1);
};

/// A time as 12:34, as 1:23:45 from an hour on, in days from four days on, in years from two years on. @param seconds s
std::string clock_text(double seconds);

/// Prints a message to stderr. If that fails (the disk of the log is full, the terminal is closed), the run continues.
void say(const std::string& text);

/// Prints the advice about a case (driver/advice.hpp) to stderr, one line each: "warning: what: why; remedy".
void print_advice(const Case& spec);

/// From now on SIGINT, SIGTERM, SIGUSR2 and the end of the terminal (SIGHUP, unless it is ignored) request a checkpoint and the end at the
/// next sample; SIGUSR1 requests only a checkpoint. A closed pipe and the limit on file sizes give errors of the write, and do not end the
/// process.
void listen_to_signals();
/// The request since the last call; for RunOptions::poll.
Request pending_request();
/// Ends the process by the signal that stopped it, so that its parent can detect that.
[[noreturn]] void end_by_signal();

}  // namespace mpm::app
