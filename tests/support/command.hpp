#pragma once
/// Runs a program as a user does, and keeps its output.

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "support/text.hpp"

namespace mpm::testing {

inline std::string content(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

/// Exit code (-1: ended by a signal), standard output, standard error.
struct Outcome {
  int code;
  std::string out, err;
};

/// @param command  for the shell, run in `folder`; it may redirect its own output
/// @param outputs  where out.txt and err.txt are kept
inline Outcome run_command(const std::string& command, const std::filesystem::path& folder, const std::filesystem::path& outputs) {
  const std::string out = (outputs / "out.txt").string(), err = (outputs / "err.txt").string();
  const int status = std::system(("cd '" + folder.string() + "' && { " + command + "\n} >'" + out + "' 2>'" + err + "'").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(out), content(err)};
}

}  // namespace mpm::testing
