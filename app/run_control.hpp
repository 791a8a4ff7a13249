#pragma once
/// What the commands that compute share: the progress line, and signals that ask for a checkpoint or an end.

#include <chrono>
#include <string>

#include "libmpm/driver/run.hpp"

namespace mpm::app {

/// Progress on stderr: one line that is rewritten on a terminal, plain lines now and then elsewhere.
class ProgressLine {
 public:
  ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() { finish(); }

  void operator()(const Progress& p);
  /// Ends the line that is shown.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool open_ = false;  ///< the last line has no line break yet
  Clock::time_point shown_ = Clock::now() - std::chrono::hours(1);
};

/// A time as 12:34, as 1:23:45 from an hour on, in days from four days on, in years from two years on. @param seconds s
std::string clock_text(double seconds);

/// Prints a message to stderr. A message that cannot be written (the log's disk is full, the terminal is gone) must not end a run that can
/// continue.
void say(const std::string& text);

/// Prints the advice about a case (driver/advice.hpp) to stderr, one line each: "warning: what: why; remedy".
void print_advice(const Case& spec);

/// From now on SIGINT, SIGTERM, SIGUSR2 and the end of the terminal (SIGHUP, unless it is ignored) ask for a checkpoint and an end at the
/// next sample; SIGUSR1 asks for a checkpoint only. A closed pipe and the limit on file sizes are errors of the write, and do not end the
/// process.
void listen_to_signals();
/// The request since the last call; for RunOptions::poll.
Request pending_request();
/// Ends the process by the signal that asked for the end, so that its parent sees that it was stopped.
[[noreturn]] void end_by_signal();

}  // namespace mpm::app
