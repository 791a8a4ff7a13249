#pragma once
/// What the commands that compute share: the progress line, and signals that ask for a checkpoint or an end.

#include <chrono>
#include <string>

#include "mpm/run.hpp"

namespace mpm::app {

/// Progress on stderr: one line that is rewritten on a terminal, plain lines now and then elsewhere.
class ProgressLine {
 public:
  ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine() { finish(); }

  void operator()(const Progress& p);
  /// Ends the line that stands.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_;
  bool open_ = false;  ///< a line stands without its end
  Clock::time_point shown_ = Clock::now() - std::chrono::hours(1);
};

/// A time as 12:34, or 1:23:45 from an hour on. @param seconds s
std::string clock_text(double seconds);

/// From now on SIGINT and SIGTERM ask for a checkpoint and an end at the next sample; SIGUSR1 asks for a checkpoint only.
void listen_to_signals();
/// What was asked for since the last call; for RunOptions::poll.
Request pending_request();
/// Ends the process by the signal that asked for the end: whoever started it sees that it was stopped.
[[noreturn]] void end_by_signal();

}  // namespace mpm::app
