#pragma once
/// The library never prints and never exits; it throws one of these. A user can act on
/// three kinds of error, each with its own remedy: edit the case, make the run stable, free the disk.
/// No exception crosses an OpenMP region: parallel loops record the error and the caller throws.

#include <stdexcept>
#include <string>

namespace mpm {

/// Exit codes of every program of the project.
enum class ExitCode : int {
  ok = 0,        ///< success
  failed = 1,    ///< a validation or a comparison failed
  usage = 2,     ///< command line or case file
  unstable = 3,  ///< NaN, inverted element, collapsed time step
  io = 4,        ///< file system
  internal = 5,  ///< an error of this program
};

/// Base class: carries the exit code that the command line reports.
class Error : public std::runtime_error {
 public:
  /// @param what  the message: what, where, the value, the remedy
  Error(ExitCode code, const std::string& what) : std::runtime_error(what), code_(code) {}
  [[nodiscard]] ExitCode code() const { return code_; }  ///< what the program returns

 private:
  ExitCode code_;
};

/// A case or an argument is wrong. The message says where, what, the value and the remedy.
struct ConfigError : Error {
  /// @param what  the message
  explicit ConfigError(const std::string& what) : Error(ExitCode::usage, what) {}
};
/// The computation became unstable; the message names particle, position and time.
struct UnstableError : Error {
  /// @param what  the message
  explicit UnstableError(const std::string& what) : Error(ExitCode::unstable, what) {}
};
/// A file could not be read or written.
struct IoError : Error {
  /// @param what  the message
  explicit IoError(const std::string& what) : Error(ExitCode::io, what) {}
};

}  // namespace mpm
