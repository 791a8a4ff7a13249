#pragma once
/// Measurements of a run again, from the frames that it stored: after a kill, with a newer version, or to check the run's own.
///
/// A frame holds what run-up, pressures and compaction need in double precision, so the figures at the times of frames are those of the run
/// up to the order of the sums. Forces are sums over steps and cannot come from frames: they are averaged from the run's series.csv over
/// the interval between two frames; momentum, energies and the rest of that file are taken over at the times of frames.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mpm/case.hpp"
#include "mpm/impact/results.hpp"
#include "mpm/solver.hpp"

namespace mpm {

/// How an impact is measured in a case, by the paper's procedure with the windows of [measurement]; empty without a conveyor or an
/// obstacle.
[[nodiscard]] std::optional<ImpactGeometry> impact_geometry(const Case& c);
/// Measures the impact of a state. Only blocks near the obstacle's axis are looked at: the strip reaches 3w/7 to each side.
[[nodiscard]] ImpactFrame measure_impact(const State& state, const Scene& scene, const ImpactGeometry& geometry);
/// The flow of a case with a conveyor; with M' where the law has one.
[[nodiscard]] ImpactFlow impact_flow(const Case& c);
/// profile.csv: z_m, pressure_pa, smoothed_pressure_pa, force_per_height_n_m, force_x_per_height_n_m; only the header without a steady
/// span.
void write_profile(const std::filesystem::path& path, const std::vector<ProfileRow>& profile);

struct PostResult {
  std::size_t frames = 0;
  std::optional<ImpactSummary> impact;         ///< cases with a conveyor and an obstacle
  std::string results_json;                    ///< content of results.json
  std::vector<std::filesystem::path> written;  ///< files, in the order in which they were written
};

/// Recomputes the measurements of a result folder (case.toml, frames; series.csv where there is one) and writes results.json, series.csv
/// and, for impacts, profile.csv to `out`. Those of them that the result folder itself lacks, because its run did not come to its end, are
/// written there, too; what is there is never touched.
///
/// results.json is the run's own, where there is one, with the figures of the impact replaced; `measured_from` is "frames" and `frames`
/// their number.
/// @throws IoError without frames, for damaged ones, or if they belong to another case than case.toml; ConfigError if `out` is the folder
/// itself
PostResult post_process(const std::filesystem::path& directory, const std::filesystem::path& out);

}  // namespace mpm
