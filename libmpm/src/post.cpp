#include "mpm/post.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "mpm/build_info.hpp"
#include "mpm/error.hpp"
#include "mpm/impact/semi_empirical.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/config.hpp"
#include "mpm/io/json_text.hpp"
#include "mpm/io/snapshot.hpp"
#include "mpm/io/table.hpp"
#include "mpm/stress.hpp"

namespace mpm {
namespace {

using Json = nlohmann::ordered_json;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Columns of series.csv that are measured on frames; the others are taken over from the run.
const std::vector<std::string> impact_columns = {"runup_m", "runup_p99_m", "pressure_height_m", "impact_pressure_pa", "compaction"};
/// Of the others, those that are means over the interval before the row.
const std::vector<std::string> interval_columns = {"force_x_n", "force_y_n", "force_z_n", "moment_x_n_m", "moment_y_n_m", "moment_z_n_m"};

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The run's own series.csv, looked up at the times of frames.
class RunSeries {
 public:
  explicit RunSeries(const std::filesystem::path& path) {
    if (!std::filesystem::exists(path)) return;
    const Table table = Table::read(path, Table::LastLine::may_be_torn);
    time_ = table.numbers("time_s");
    for (const std::string& name : table.columns()) {
      if (name == "time_s" || contains(impact_columns, name)) continue;
      names_.push_back(name);
      values_.push_back(table.numbers(name));
    }
  }

  /// Names of the columns that are taken over.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

  /// Value of a column for a frame at `time` whose predecessor is at `before` (NaN for the first). Times of frames are times of rows, to
  /// the bit.
  [[nodiscard]] double at(std::size_t column, double before, double time) const {
    const std::vector<double>& values = values_[column];
    if (!contains(interval_columns, names_[column])) {
      const auto row = std::find(time_.begin(), time_.end(), time);
      return row == time_.end() ? unknown : values[static_cast<std::size_t>(row - time_.begin())];
    }
    // Rows are evenly spaced: the mean over the interval is the mean of its rows.
    double sum = 0.0;
    std::size_t rows = 0;
    for (std::size_t r = 0; r < time_.size(); ++r) {
      if (!(time_[r] > before && time_[r] <= time)) continue;
      sum += values[r];
      ++rows;
    }
    return rows > 0 ? sum / static_cast<double>(rows) : unknown;
  }

  /// @return components x, y, z of a column family such as "force" in "n"; NaN where the run has none
  [[nodiscard]] Vec3 vector_at(const std::string& name, const std::string& unit, double before, double time) const {
    Vec3 v = Vec3::Constant(unknown);
    for (int i = 0; i < 3; ++i) {
      const auto found = std::find(names_.begin(), names_.end(), fmt::format("{}_{}_{}", name, "xyz"[i], unit));
      if (found != names_.end()) v[i] = at(static_cast<std::size_t>(found - names_.begin()), before, time);
    }
    return v;
  }

 private:
  std::vector<double> time_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> values_;
};

ImpactFrame measure(const Snapshot& frame, const ImpactGeometry& geometry) {
  ImpactSample sample(geometry);
  const ParticleTable& p = frame.particles;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec3 position(p.position[3 * i], p.position[3 * i + 1], p.position[3 * i + 2]);
    double stress[6];
    std::copy_n(&p.stress[6 * i], 6, stress);
    sample.add(position, geometry.normal_component(position, stress), p.volume_ratio[i], frame.info.reference_density * p.volume[i]);
  }
  return sample.finish();
}

/// What is known of a run that wrote no results.json.
Json facts(const Case& c, const SnapshotInfo& last, std::size_t particles) {
  Json json;
  json["format_version"] = 1;
  json["title"] = c.title;
  json["case_hash"] = last.case_hash;
  json["version"] = last.version;
  json["duration_s"] = last.time;
  json["steps"] = last.step;
  json["particles_final"] = particles;
  return json;
}

}  // namespace

std::optional<ImpactGeometry> impact_geometry(const Case& c) {
  if (!c.conveyor || !c.obstacle) return std::nullopt;
  ImpactGeometry geometry = paper_geometry(c.conveyor->flow_height, c.obstacle->width, c.numerics.cell_size, c.material.density,
                                           c.conveyor->mirror_y || c.domain.mirror_y, c.measurement);
  geometry.set_obstacle(*c.obstacle);
  return geometry;
}

ImpactFrame measure_impact(const State& state, const Scene& scene, const ImpactGeometry& geometry) {
  ImpactSample sample(geometry);
  const double dx = state.grid.cell_size(), density = density_of(scene.material);
  const double furthest = geometry.box_inside + (geometry.plan ? geometry.plan->depth : 0.0);
  for (const auto b : state.grid.occupied_blocks()) {
    const Index3& c = state.grid.block(b).coordinate;
    const double low_x = (4.0 * c[0] + 0.5) * dx - scene.offset.x(), low_y = (4.0 * c[1] + 0.5) * dx - scene.offset.y();
    if (low_y > geometry.strip_half_width || low_y + 4.0 * dx < -geometry.strip_half_width || low_x > furthest) continue;
    const ParticleBin& bin = state.grid.block(b).particles;
    for (int s = 0; s < bin.count(); ++s) {
      const Particle& p = bin[s];
      const Vec3 x = Vec3(p.position[0], p.position[1], p.position[2]) - scene.offset;
      const bool inside = geometry.in_profile_box(x);
      sample.add(x, inside ? geometry.normal_component(x, p.stress) : 0.0, inside ? volume_ratio(scene.material, p) : 1.0,
                 density * p.volume);
    }
  }
  return sample.finish();
}

ImpactFlow impact_flow(const Case& c) {
  ImpactFlow flow;
  flow.velocity = c.conveyor->velocity;
  flow.gravity = c.numerics.gravity;
  if (c.material.model == "cohesive_cam_clay") {
    flow.effective_friction = effective_friction(c.material.critical_state_slope, c.material.cohesion_beta);
  }
  return flow;
}

void write_profile(const std::filesystem::path& path, const std::vector<ProfileRow>& profile) {
  const std::vector<std::string> names = {"z_m", "pressure_pa", "smoothed_pressure_pa", "force_per_height_n_m", "force_x_per_height_n_m"};
  std::vector<std::vector<double>> columns(names.size());
  for (const ProfileRow& row : profile) {
    columns[0].push_back(row.z);
    columns[1].push_back(row.pressure);
    columns[2].push_back(row.smoothed);
    columns[3].push_back(row.force_per_height);
    columns[4].push_back(row.force_x_per_height);
  }
  write_table(path, names, columns);
}

PostResult post_process(const std::filesystem::path& directory, const std::filesystem::path& out) {
  const Case c = read_case(directory / "case.toml");
  make_directory(out);
  if (std::filesystem::equivalent(directory, out)) {
    throw ConfigError(
        fmt::format("'{}' is the result folder itself, and the run's own files are not overwritten; choose another folder for the output",
                    out.string()));
  }
  const std::string hash = case_hash_text(c);
  const std::vector<int> numbers = frame_numbers(directory);
  if (numbers.empty()) {
    throw IoError(fmt::format("{}: there are no frames to measure; run the case with output.frames_per_second > 0", directory.string()));
  }
  const RunSeries run(directory / "series.csv");
  const std::optional<ImpactGeometry> geometry = impact_geometry(c);

  std::vector<std::string> names = {"time_s"};
  if (geometry) names.insert(names.end(), impact_columns.begin(), impact_columns.end());
  names.insert(names.end(), run.names().begin(), run.names().end());
  std::vector<std::vector<double>> columns(names.size());
  ImpactSeries series;
  SnapshotInfo last;
  std::size_t last_particles = 0;
  double before = unknown;
  for (const int number : numbers) {
    const Snapshot frame = read_frame(frame_path(directory, number));
    if (frame.info.case_hash != hash) {
      throw IoError(fmt::format("'{}' belongs to a case with hash {}, case.toml beside it has {}; put the case.toml of the run back",
                                frame_path(directory, number).string(), frame.info.case_hash, hash));
    }
    const double time = frame.info.time;
    std::vector<double> row = {time};
    if (geometry) {
      const ImpactFrame impact = measure(frame, *geometry);
      row.insert(row.end(),
                 {impact.runup, impact.runup_p99, impact.pressure_height.value_or(unknown), impact.impact_pressure, impact.compaction});
      series.append(time, impact, run.vector_at("force", "n", before, time), run.vector_at("moment", "n_m", before, time));
    }
    for (std::size_t i = 0; i < run.names().size(); ++i) row.push_back(run.at(i, before, time));
    for (std::size_t i = 0; i < row.size(); ++i) columns[i].push_back(row[i]);
    before = time;
    last = frame.info;
    last_particles = frame.particles.size();
  }

  PostResult result;
  result.frames = numbers.size();
  const std::filesystem::path own_results = directory / "results.json";
  Json json = facts(c, last, last_particles);
  if (std::filesystem::exists(own_results)) {
    json = Json::parse(read_json_text(own_results), nullptr, false);
    if (!json.is_object())
      throw IoError(fmt::format("'{}' is not a JSON object; delete it and run `mpm post` again", own_results.string()));
  }
  json["measured_from"] = "frames";
  json["frames"] = result.frames;
  json["post_version"] = build_info().version;
  json["post_commit"] = build_info().commit;
  if (geometry) {
    result.impact = summarise(series, *geometry, impact_flow(c));
    result.impact->transient.reset();  // between two frames the force is only known as a mean: the run's own figures stand
    json.update(Json::parse(to_json(*result.impact)));
  }
  result.results_json = json.dump(2) + "\n";

  for (const auto& folder : {out, directory}) {
    const auto wanted = [&](const char* name) { return folder == out || !std::filesystem::exists(folder / name); };
    const auto written = [&](const char* name) { result.written.push_back(folder / name); };
    if (wanted("series.csv")) {
      write_table(folder / "series.csv", names, columns);
      written("series.csv");
    }
    if (geometry && wanted("profile.csv")) {
      write_profile(folder / "profile.csv", mean_profile(series, result.impact->span, *geometry));
      written("profile.csv");
    }
    if (wanted("results.json")) {
      write_file(folder / "results.json", result.results_json);
      written("results.json");
    }
  }
  return result;
}

}  // namespace mpm
