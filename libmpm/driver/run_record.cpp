#include "libmpm/driver/run_record.hpp"

#include <omp.h>
#include <sys/resource.h>

#include <algorithm>
#include <iterator>

#include "libmpm/driver/build_info.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/json.hpp"

namespace mpm {

namespace {

constexpr std::uint64_t results_format_version = 1;

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

Result about_execution(std::string name, Value value, std::string unit, std::string meaning) {
  return {std::move(name), std::move(value), std::move(unit), std::move(meaning), Nature::execution};
}

}  // namespace

std::vector<Result> RunRecord::summary(const Summary& end) const {
  const BuildInfo build = build_info();
  const RunProgress& p = *end.progress;
  std::vector<Result> results{
      about_execution("format_version", results_format_version, "", "version of the format of results.json"),
      about_execution("title", title_, "", "title of the case"),
      about_execution("case_hash", case_hash_, "", "hash of the resolved case, without title and duration"),
      about_execution("version", std::string(build.version), "", "version of the program"),
      about_execution("commit", std::string(build.commit), "", "git commit of the program"),
      about_execution("compiler", std::string(build.compiler), "", "compiler of the program"),
      about_execution("instruction_set", std::string(build.instruction_set), "", "widest vector instructions of the program"),
      about_execution("precision", std::string(name_of(end.state->grid.precision())), "", "precision of the particles: double or single"),
      about_execution("ranks", static_cast<std::uint64_t>(end.state->grid.ranks().size()), "", "processes that computed together"),
      about_execution("threads", std::uint64_t(omp_get_max_threads()), "", "threads, of each rank"),
      {"duration_s", end.state->time, "s", "simulated time"},
      about_execution("wall_time_s", p.wall_time, "s", "wall time; for a resumed run, the sum over all its parts"),
      about_execution("solver_time_s", p.step_time, "s", "part of the wall time that was spent in steps"),
      {"steps", end.state->step, "", "time steps"},
      {"particle_steps", p.particle_steps, "", "sum over the steps of the particles moved"},
      about_execution("million_particle_steps_per_s", p.speed(), "", "speed: million particle-steps per second of wall time"),
      about_execution("peak_memory_bytes", peak_memory_bytes(), "byte", "largest memory of the process; with several ranks, of rank 0")};
  std::ranges::move(checksums(end), std::back_inserter(results));
  return results;
}

std::vector<Result> checksums(const Summary& end) {
  std::vector<Result> sums{
      about_execution("series_crc32", checksum(table_text(end.series.names(), end.series.values())), "", "CRC-32 of series.csv")};
  if (!end.profile.empty()) sums.push_back(about_execution("profile_crc32", checksum(end.profile), "", "CRC-32 of profile.csv"));
  sums.push_back(about_execution(checksum_entry, std::string(no_checksum), "",
                                 "CRC-32 of results.json itself, with eight zeros in the place of this number"));
  return sums;
}

std::vector<Result> execution_from_frames(const std::string& title, const SnapshotInfo& last, std::size_t particles) {
  return {about_execution("format_version", results_format_version, "", "version of the format of results.json"),
          about_execution("title", title, "", "title of the case"),
          about_execution("case_hash", last.case_hash, "", "hash of the resolved case, without title and duration"),
          about_execution("version", last.version, "", "version of the program that computed the frames"),
          about_execution("precision", std::string(name_of(last.precision)), "", "precision of the particles: double or single"),
          {"duration_s", last.time, "s", "time of the last frame"},
          {"steps", static_cast<std::uint64_t>(last.step), "", "time steps up to it"},
          {"particles_final", std::uint64_t{particles}, "", "particles in it"}};
}

std::vector<Result> origin_in_frames(std::size_t frames) {
  const BuildInfo build = build_info();
  return {about_execution("measured_from", std::string("frames"), "", "'frames': measured again from the stored frames by mpm post"),
          about_execution("frames", std::uint64_t{frames}, "", "number of frames measured"),
          about_execution("post_version", std::string(build.version), "", "version of the program that measured them"),
          about_execution("post_commit", std::string(build.commit), "", "git commit of that program")};
}

}  // namespace mpm
