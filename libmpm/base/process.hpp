#pragma once
/// This machine, and the start of other programs.

#include <unistd.h>

#include <array>
#include <string>
#include <vector>

namespace mpm {

/// Name of this machine, "?" if it is unknown.
inline std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "?";
}

/// The words of a command as execv() takes them: their addresses, then a null. @param words  must outlive the result
inline std::vector<char*> exec_arguments(std::vector<std::string>& words) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return arguments;
}

}  // namespace mpm
