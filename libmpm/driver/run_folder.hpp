#pragma once
/// The folder of a run: whether a process works in it, and whether it holds the finished run of a case. Used by single runs and by
/// campaigns, which have one folder for each run and keep finished runs.

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/observe/results.hpp"

namespace mpm {

struct HeightProfile;

/// Excludes a second process from a directory (`.lock` in it); the system releases it when the process ends, even after a kill. On a file
/// system without such locks (some Lustre and NFS) the file `.lock.owner` with host and process number takes their place.
class DirectoryLock {
 public:
  /// Tries for half a second, because is_locked() of another process takes the lock for an instant.
  /// @throws IoError if another process holds it, or the file cannot be made
  explicit DirectoryLock(const std::filesystem::path& directory);
  ~DirectoryLock();

  /// What the user should know about the lock; empty if the file system has locks.
  [[nodiscard]] std::string note() const;

 private:
  Descriptor file_;
  std::filesystem::path owner_;  ///< the file that takes the place of the lock; empty if there is a lock
};

/// Whether a process works in a directory; false if the directory does not exist.
[[nodiscard]] bool is_locked(const std::filesystem::path& directory);

/// Refuses to go on with a run in a folder that does not exist: its name is mistyped. @throws IoError
void require_folder(const std::filesystem::path& directory);

/// Refuses a new run into a folder that would destroy results; call it before run_case() without `resume`.
/// @throws ConfigError if the folder holds results (results.json, final.h5) or a checkpoint: the message names --resume, --out and --force
/// @throws IoError if another process works there
void require_no_results(const std::filesystem::path& directory);

/// Refuses a folder of the user, as with --out .: one that holds a file of these names, which the program would overwrite, but none of the
/// signs that it has worked there. @throws ConfigError
void require_no_other_files(const std::filesystem::path& directory, std::initializer_list<const char*> names,
                            std::initializer_list<const char*> signs);

/// Writes case.toml, and with an obstacle obstacle.json: its outline in plan, so that programs that draw it need not know the shapes.
/// @throws IoError
void write_case_files(const std::filesystem::path& directory, const Case& c);

/// {"outline_m": [[x, y], ...], "top_m": z, "base_m": z, "arm": {...}}: corners counter-clockwise from above, those of the obstacle from
/// x = 0 on; top_m is null if it is taller than any jet, base_m absent if it stands on the ground; arm is one of the same kind, if there is
/// one. @param c  a case with an obstacle
[[nodiscard]] std::string obstacle_text(const Case& c);

/// Whether results are those of the finished run of a case: written by the run and not by `mpm post`, with the same hash, and with the same
/// duration or an end within it by output.stop_when_steady with no larger a limit.
[[nodiscard]] bool is_whole_run(const Results& results, const Case& c);

/// results.json of a folder, read once.
class ResultsFile {
 public:
  /// @throws IoError if there is one that cannot be read
  explicit ResultsFile(std::filesystem::path directory);

  [[nodiscard]] bool exists() const { return text_.has_value(); }                   ///< whether there is one
  [[nodiscard]] const std::optional<Results>& results() const { return results_; }  ///< empty: there are none in it, or no file
  /// Which of results.json, series.csv and profile.csv does not match its checksum, for a message. Empty: none, or there is no
  /// results.json.
  [[nodiscard]] std::string damage() const;
  /// @throws IoError with the damage, if there is any
  void require_undamaged() const;
  /// Whether the folder holds the finished run of this case (is_whole_run) without damage.
  [[nodiscard]] bool is_finished(const Case& c) const { return results_ && is_whole_run(*results_, c) && damage().empty(); }

 private:
  std::filesystem::path directory_;
  std::optional<std::string> text_;
  std::optional<Results> results_;
};

/// The results of a folder, if it holds the finished run of this case without damage.
[[nodiscard]] std::optional<Results> finished_results(const std::filesystem::path& directory, const Case& c);

/// Whether case.toml of a folder is the case with this hash; false if it is missing or cannot be read.
[[nodiscard]] bool holds_case(const std::filesystem::path& directory, const std::string& case_hash);

/// profiles.h5: time_s, z_m and, with a row for each sample and a column for each height, the quantities over height and time.
/// @param profiles  the first holds the heights, as mean
void write_profiles_over_time(const std::filesystem::path& path, std::span<const double> time, const std::vector<HeightProfile>& profiles);

}  // namespace mpm
