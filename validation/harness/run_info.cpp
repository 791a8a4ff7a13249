#include "validation/harness/run_info.hpp"

#include <fmt/format.h>

#include <fstream>
#include <thread>

namespace mpm::validation {

std::optional<double> time_budget(Level level) {
  switch (level) {
    case Level::quick: return 150.0;
    case Level::standard: return 1800.0;
    case Level::full: return std::nullopt;
  }
  return std::nullopt;
}

std::string describe_machine() {
  std::string model = "unknown processor", line;
  std::ifstream cpu("/proc/cpuinfo");
  while (std::getline(cpu, line))
    if (line.rfind("model name", 0) == 0) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  return fmt::format("{}, {} hardware threads", model, std::thread::hardware_concurrency());
}

}  // namespace mpm::validation
