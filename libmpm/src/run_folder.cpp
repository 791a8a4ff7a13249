#include "mpm/run_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "mpm/error.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/config.hpp"
#include "mpm/io/json_text.hpp"
#include "mpm/run.hpp"

namespace mpm {

DirectoryLock::DirectoryLock(const std::filesystem::path& directory) {
  const auto path = directory / ".lock";
  descriptor_ = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  if (descriptor_ < 0) throw file_error("cannot create", path, errno);
  constexpr int tries = 50;
  constexpr std::chrono::milliseconds pause(10);
  for (int i = 0; flock(descriptor_, LOCK_EX | LOCK_NB) != 0; ++i) {
    if (i < tries) {
      std::this_thread::sleep_for(pause);
      continue;
    }
    close(descriptor_);
    throw IoError(fmt::format("{}: another process is running in this directory; wait for it or choose another --out", directory.string()));
  }
}

DirectoryLock::~DirectoryLock() { close(descriptor_); }

bool is_locked(const std::filesystem::path& directory) {
  const auto path = directory / ".lock";
  const int descriptor = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  return locked;
}

std::optional<std::string> finished_results(const std::filesystem::path& directory, const Case& c) {
  if (!std::filesystem::exists(directory / "results.json")) return {};
  std::string results = read_json_text(directory / "results.json");
  const auto json = nlohmann::json::parse(results, nullptr, false);
  if (!json.is_object() || json.value("case_hash", nlohmann::json()) != case_hash_text(c) || !json.contains("duration_s")) return {};
  const double last = static_cast<double>(last_sample(c)) / c.output.series_per_second;
  if (!json["duration_s"].is_number() || std::abs(json["duration_s"].get<double>() - last) > 1e-9 * last) return {};
  return results;
}

}  // namespace mpm
