#pragma once
/// The case, program, machine and time of a run.

#include <string>

#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Entries of results.json about the case, the program, the machine and the time; comparisons of runs
/// ignore them.
class RunRecord : public Observer {
 public:
  /// @param case_hash  case_hash_text of driver/case_file.hpp
  RunRecord(std::string title, std::string case_hash) : title_(std::move(title)), case_hash_(std::move(case_hash)) {}

  [[nodiscard]] std::string name() const override { return "execution"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }
  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override;

 private:
  std::string title_, case_hash_;
};

/// Entries of results.json that follow from the frames alone.
/// @param particles  in the last frame
[[nodiscard]] std::vector<Result> execution_from_frames(const std::string& title, const SnapshotInfo& last, std::size_t particles);

/// Entries of results.json with the checksums of series.csv, profile.csv and of itself; Results::to_json fills in the last one.
[[nodiscard]] std::vector<Result> checksums(const Summary& end);

/// Entries of results.json that mark it as a replay of frames by `mpm post`.
/// @param frames  number of frames
[[nodiscard]] std::vector<Result> origin_in_frames(std::size_t frames);

}  // namespace mpm
