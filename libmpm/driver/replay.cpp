#include "libmpm/driver/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/driver/run_record.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/snapshot.hpp"
#include "libmpm/observe/observer_list.hpp"

namespace mpm {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// The run's own series.csv, evaluated at the times of frames.
class RunSeries {
 public:
  explicit RunSeries(const std::filesystem::path& path) {
    if (!std::filesystem::exists(path)) return;
    const Table table = Table::read(path, Table::LastLine::may_be_torn);
    time_ = table.numbers("time_s");
    for (const std::string& name : table.columns()) values_[name] = table.numbers(name);
  }

  /// Value of a column for a frame at `time` whose predecessor is at `before` (NaN for the first); NaN if the run has none. Times of frames
  /// equal times of rows exactly.
  [[nodiscard]] double at(const Column& column, double before, double time) const {
    const auto found = values_.find(column.name());
    if (found == values_.end()) return unknown;
    return column.kind == Column::Kind::instant ? at_time(found->second, time) : mean_over(found->second, before, time);
  }

 private:
  [[nodiscard]] double at_time(const std::vector<double>& values, double time) const {
    const auto row = std::ranges::find(time_, time);
    return row == time_.end() ? unknown : values[static_cast<std::size_t>(row - time_.begin())];
  }
  /// Rows are evenly spaced: the mean over the interval is the mean of its rows.
  [[nodiscard]] double mean_over(const std::vector<double>& values, double before, double time) const {
    double sum = 0.0;
    std::size_t rows = 0;
    for (std::size_t r = 0; r < time_.size(); ++r) {
      if (!(time_[r] > before && time_[r] <= time)) continue;
      sum += values[r];
      ++rows;
    }
    return rows > 0 ? sum / static_cast<double>(rows) : unknown;
  }

  std::vector<double> time_;
  std::map<std::string, std::vector<double>> values_;
};

/// Measures every frame of a folder. @return where the last one was
struct LastFrame {
  SnapshotInfo info;
  std::size_t particles = 0;
};
LastFrame measure_frames(const std::filesystem::path& directory, const std::vector<int>& numbers, const std::string& hash,
                         ObserverList& observers) {
  const RunSeries run(directory / "series.csv");
  LastFrame last;
  double before = unknown, spacing = unknown;
  for (const int number : numbers) {
    const Snapshot frame = read_snapshot(frame_path(directory, number), SnapshotKind::frame);
    if (frame.info.case_hash != hash) {
      throw IoError(fmt::format("'{}' belongs to a case with hash {}, case.toml beside it has {}; put the case.toml of the run back",
                                frame_path(directory, number).string(), frame.info.case_hash, hash));
    }
    if (frame.info.time - before > spacing * (1.0 + 1e-6)) {
      throw IoError(
          fmt::format("{}: a frame between t = {:.6g} and {:.6g} s is missing, and means would count the frames unequally; make "
                      "the run again, or keep frames at equal distances",
                      (directory / "frames").string(), before, frame.info.time));
    }
    if (std::isnan(spacing)) spacing = frame.info.time - before;
    (void)observers.sample(frame, [&](const Column& column) { return run.at(column, before, frame.info.time); });
    before = frame.info.time;
    last = {frame.info, frame.particles.size()};
  }
  return last;
}

/// The run's own results, if it finished, with the entries that were measured from frames replaced. Those that only the run can measure
/// stay if its steady interval is the same up to two frames; else only those that describe the computation do.
Results updated_results(const ResultsFile& own, const Case& c, const LastFrame& last, const Summary& end, const Results& measured) {
  const bool finished = own.results() && !own.results()->has("measured_from");
  const std::span<const double> time = end.series.time();
  const double two_frames = time.size() > 1 ? 2.0 * (time[1] - time[0]) : 0.0;
  const auto same = [&](const char* entry) {
    const double was = own.results()->number_or_nan(entry), is = measured.number_or_nan(entry);
    return std::isnan(was) ? std::isnan(is) : std::abs(is - was) <= two_frames * (1.0 + 1e-9);
  };
  Results results;
  for (const Result& entry : finished ? own.results()->entries() : std::vector<Result>()) {
    if (nature_of(entry.name) == Nature::execution || (same("steady_from_s") && same("steady_to_s"))) results.add(entry);
  }
  if (!finished) results.add(execution_from_frames(c.title, last.info, last.particles));
  results.replace(origin_in_frames(end.series.size()));
  results.replace(checksums(end));
  results.replace(measured.entries());
  return results;
}

}  // namespace

PostResult post_process(const std::filesystem::path& directory, const std::filesystem::path& out,
                        const std::vector<std::shared_ptr<Observer>>& observers) {
  const Case c = read_case(directory / "case.toml");
  const ResultsFile own(directory);
  own.require_undamaged();
  if (std::filesystem::exists(out / "case.toml")) {
    throw ConfigError(fmt::format(
        "'{}' is the folder of a run or of a case, whose files are not overwritten; choose another folder for the output", out.string()));
  }
  make_directory(out);
  const std::vector<int> numbers = frame_numbers(directory);
  if (numbers.empty()) {
    throw IoError(fmt::format(
        "{}: there are no frames to measure; run the case with output.frames_per_second > 0, or the campaign with keep = [\"frames\"]",
        directory.string()));
  }
  ObserverList list(make_observers(c, make_scene(c), observers));
  const LastFrame last = measure_frames(directory, numbers, case_hash_text(c), list);

  PostResult result;
  result.frames = numbers.size();
  const Summary end = list.summary(nullptr, nullptr);
  result.results = updated_results(own, c, last, end, list.results(end));

  const auto write = [&](const char* name, const std::string& text) {
    write_file(out / name, text);
    result.written.push_back(out / name);
  };
  write("series.csv", table_text(list.series().names(), list.series().values()));
  if (!end.profiles.empty()) {
    write("profile.csv", end.profile);
    write_profiles_over_time(out / "profiles.h5", end.series.time(), end.profiles);
    result.written.push_back(out / "profiles.h5");
  }
  write("results.json", result.results.to_json());
  if (c.obstacle) write("obstacle.json", obstacle_text(c));
  return result;
}

}  // namespace mpm
