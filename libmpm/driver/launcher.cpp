#include "libmpm/driver/launcher.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "libmpm/base/error.hpp"

namespace mpm {

namespace {

/// Path of a command. @throws ConfigError
std::string found_in_path(const std::string& command) {
  if (command.find('/') != std::string::npos) return command;
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::string candidate = (std::filesystem::path(folder) / command).string();
    if (access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  throw ConfigError(
      fmt::format("several ranks are started by {}, which is not installed (Debian: openmpi-bin, or `./run build mpi`)", command));
}

}  // namespace

std::vector<std::string> default_launcher() {
  std::vector<std::string> words = {"mpirun", "-np", ranks_placeholder, "--quiet", "--oversubscribe", "--bind-to", "none"};
  if (geteuid() == 0) words.emplace_back("--allow-run-as-root");
  return words;
}

std::vector<std::string> launcher_words(int ranks, const std::vector<std::string>& launcher) {
  if (ranks == 1) return {};
  std::vector<std::string> words = launcher.empty() ? default_launcher() : launcher;
  for (std::string& word : words) {
    if (const auto at = word.find(ranks_placeholder); at != std::string::npos)
      word.replace(at, std::string_view(ranks_placeholder).size(), std::to_string(ranks));
  }
  words.front() = found_in_path(words.front());
  return words;
}

}  // namespace mpm
