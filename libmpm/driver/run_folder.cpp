#include "libmpm/driver/run_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <thread>

#include "libmpm/base/error.hpp"
#include "libmpm/base/process.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/json.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

namespace {

constexpr const char *lock_file = ".lock", *owner_file = ".lock.owner", *successor_file = ".lock.successor";

/// Takes the lock. @return 0, or an errno value: EWOULDBLOCK if another process holds it, anything else if there are no locks
int lock_error(const Descriptor& file) {
  int reason = 0;
  do reason = flock(file.get(), LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
  while (reason == EINTR);
  return reason;
}

/// "host process"
std::string own_name() { return fmt::format("{} {}", host_name(), getpid()); }

/// The process that holds a directory by a file, as in own_name(); empty if there is none, or if it was one of this host and has ended.
std::string owner_of(const std::filesystem::path& owner) {
  std::error_code error;
  if (!std::filesystem::exists(owner, error)) return {};
  constexpr std::uintmax_t longest = 512;  // bytes
  const std::string name(trimmed(read_file(owner, longest), " \n"));
  const std::string here = host_name() + " ";
  if (!name.starts_with(here)) return name.empty() ? "an unknown process" : name;
  const auto process = parse_number(name.substr(here.size()));
  return process && *process > 0.0 && kill(static_cast<pid_t>(*process), 0) != 0 && errno == ESRCH ? "" : name;
}

/// Makes a file with own_name(). @return false if it exists
bool make_owner(const std::filesystem::path& path) {
  const Descriptor file(open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666));
  if (!file && errno == EEXIST) return false;
  if (!file) throw file_error("cannot create", path, errno);
  if (const int failure = file.write(own_name()); failure != 0) throw file_error("cannot write", path, failure);
  return true;
}

}  // namespace

DirectoryLock::DirectoryLock(const std::filesystem::path& directory) {
  const auto path = directory / lock_file;
  file_ = Descriptor(open(path.c_str(), O_CREAT | O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0666));
  if (!file_) throw file_error("cannot create", path, errno);
  constexpr int tries = 50;
  constexpr std::chrono::milliseconds pause(10);
  int reason = lock_error(file_);
  for (int i = 0; reason == EWOULDBLOCK && i < tries; ++i) {
    std::this_thread::sleep_for(pause);
    reason = lock_error(file_);
  }
  if (reason == EWOULDBLOCK)
    throw IoError(fmt::format("{}: another process is running in this directory; wait for it or choose another --out", directory.string()));
  if (reason == 0) return;
  const auto owner = directory / owner_file, successor = directory / successor_file;
  const auto refuse = [&](const std::filesystem::path& by) {
    const std::string other = owner_of(by);
    throw IoError(fmt::format(
        "{}: another process is running in this directory ('{}' names it: {}); wait for it, or delete that file if it has ended",
        directory.string(), by.string(), other.empty() ? "one that has ended" : other));
  };
  if (!make_owner(owner)) {
    if (!owner_of(owner).empty()) refuse(owner);
    // Of a process that has ended. Only one process at a time removes such a file, so that none removes that of a process which came first.
    if (!make_owner(successor)) refuse(successor);
    const bool taken = owner_of(owner).empty() && (remove_file(owner), make_owner(owner));
    remove_file(successor);
    if (!taken) refuse(owner);
  }
  owner_ = owner;
}

DirectoryLock::~DirectoryLock() {
  std::error_code error;
  if (!owner_.empty()) std::filesystem::remove(owner_, error);
}

std::string DirectoryLock::note() const {
  if (owner_.empty()) return {};
  return fmt::format("this file system has no locks: '{}' keeps other processes out; delete it if this one is killed on another machine",
                     owner_.string());
}

bool is_locked(const std::filesystem::path& directory) {
  const auto path = directory / lock_file;
  Descriptor file(open(path.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC));
  if (!file && errno == EACCES) file = Descriptor(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));  // of another user
  if (!file) return false;
  const int reason = lock_error(file);
  return reason == EWOULDBLOCK || (reason != 0 && !owner_of(directory / owner_file).empty());
}

void require_folder(const std::filesystem::path& directory) {
  if (!std::filesystem::is_directory(directory))
    throw IoError(fmt::format("{}: there is no such folder to go on in; without --resume a run starts there", directory.string()));
}

void require_no_results(const std::filesystem::path& directory) {
  const auto has = [&](const char* name) { return std::filesystem::exists(directory / name); };
  const bool finished = has("results.json") || has("final.h5"), interrupted = has_checkpoint(directory);
  if (!finished && !interrupted) return;
  const DirectoryLock lock(directory);  // a running process gives another message
  throw ConfigError(fmt::format("{} holds {}; choose another folder with --out, {} with --resume, or overwrite it with --force",
                                directory.string(), finished ? "the results of a run" : "the checkpoint of an interrupted run",
                                finished ? "extend it to a longer duration" : "continue it"));
}

void require_no_other_files(const std::filesystem::path& directory, std::initializer_list<const char*> names,
                            std::initializer_list<const char*> signs) {
  const auto there = [&](const char* name) { return std::filesystem::exists(directory / name); };
  const auto* const found = std::ranges::find_if(names, there);
  if (found == names.end() || std::ranges::any_of(signs, there)) return;
  throw ConfigError(fmt::format("'{}' is not of this program, and would be overwritten; choose another folder with --out",
                                (directory / *found).string()));
}

bool is_whole_run(const Results& results, const Case& c) {
  if (results.text("case_hash") != case_hash_text(c) || results.has("measured_from")) return false;
  if (results.has("steady_column") && results.text("steady_column") != c.measurement.steady_column()) return false;  // to be measured again
  const double last = Sampling(c).end(), missing = last - results.number_or_nan("duration_s");
  if (std::abs(missing) <= 1e-9 * last) return true;
  // it ended by a rule at least as strict as that of the case
  return missing > 0.0 && results.number_or_nan("stopped_when_steady") == 1.0 &&
         results.number_or_nan("stop_when_steady") <= c.output.stop_when_steady;
}

bool holds_case(const std::filesystem::path& directory, const std::string& case_hash) {
  if (!std::filesystem::exists(directory / "case.toml")) return false;
  try {
    return case_hash_text(read_case(directory / "case.toml")) == case_hash;
  } catch (const Error&) {  // from another version of this program, or incomplete
    return false;
  }
}

ResultsFile::ResultsFile(std::filesystem::path directory) : directory_(std::move(directory)) {
  if (!std::filesystem::exists(directory_ / "results.json")) return;
  text_ = read_json_text(directory_ / "results.json");
  results_ = Results::from_json(*text_);
}

std::string ResultsFile::damage() const {
  if (!exists()) return {};
  if (!results_) return "results.json is damaged";
  if (!is_intact(*text_)) return "results.json does not match its checksum";
  for (const auto& [entry, file] : {std::pair("series_crc32", "series.csv"), std::pair("profile_crc32", "profile.csv")}) {
    if (!results_->has(entry)) continue;
    if (!std::filesystem::exists(directory_ / file)) return fmt::format("{} is missing", file);
    if (results_->text(entry) != checksum(read_file(directory_ / file)))
      return fmt::format("{} does not match its checksum in results.json", file);
  }
  return {};
}

void ResultsFile::require_undamaged() const {
  if (const std::string what = damage(); !what.empty())
    throw IoError(fmt::format("{}: {}; compute it again with `mpm run --resume`", directory_.string(), what));
}

std::optional<Results> finished_results(const std::filesystem::path& directory, const Case& c) {
  const ResultsFile file(directory);
  return file.is_finished(c) ? file.results() : std::nullopt;
}

std::string obstacle_text(const Case& c) {
  const auto json_of = [](const UprightSolid& solid) {
    nlohmann::ordered_json json{{"outline_m", nlohmann::ordered_json::array()}, {"top_m", nullptr}};
    for (const Outline::Side& side : solid.outline.sides()) json["outline_m"].push_back({side.from.x(), side.from.y()});
    if (std::isfinite(solid.top)) json["top_m"] = solid.top;
    if (std::isfinite(solid.base)) json["base_m"] = solid.base;
    return json;
  };
  const std::vector<UprightSolid> solids = solids_of(c);
  nlohmann::ordered_json json = json_of(solids.front());
  if (solids.size() > 1) json["arm"] = json_of(solids.back());
  return json.dump() + "\n";
}

void write_case_files(const std::filesystem::path& directory, const Case& c) {
  write_file(directory / "case.toml", write_case(c));
  if (c.obstacle) write_file(directory / "obstacle.json", obstacle_text(c));
}

void write_profiles_over_time(const std::filesystem::path& path, std::span<const double> time, const std::vector<HeightProfile>& profiles) {
  hdf5::Writer file(path);
  file.dataset<double>("time_s", time);
  const HeightProfile& heights = profiles.front();
  file.dataset<double>(heights.column.name(), heights.mean);
  for (const HeightProfile& profile : profiles) {
    if (!profile.over_time.empty()) file.dataset<double>(profile.column.name(), profile.over_time, {time.size(), heights.mean.size()});
  }
  file.commit();
}

}  // namespace mpm
