#include "python_script.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "libmpm/base/process.hpp"

namespace mpm::app {

std::optional<std::filesystem::path> find_script(const std::string& name) {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  for (const std::filesystem::path& candidate :
       {program.parent_path().parent_path() / "share/mpm/scripts" / name, std::filesystem::path(MPM_SCRIPT_DIR) / name}) {
    if (std::filesystem::exists(candidate, error)) return candidate;
  }
  return std::nullopt;
}

int run_script(const std::filesystem::path& script, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{python, script.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const std::vector<char*> argv = exec_arguments(words);
  const pid_t child = fork();
  if (child < 0) return 127;
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // a killed program leaves no script behind that writes into a folder which is not locked any more
    execv(python, argv.data());
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return 127;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

}  // namespace mpm::app
