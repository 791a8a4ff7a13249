/// Solves cases that `mpm-validate export` wrote with the plain step (tests/core/plain_step.hpp), a second formulation of the method that
/// shares no code with the library's step. Here it is a solver of its own: particles come from particles.csv, the scene from case.toml.
///
/// Laws: hencky_elastic, cohesive_cam_clay, weakly_compressible_fluid without viscosity, drucker_prager without cohesion, dilatancy and
/// rate dependence. Boundaries: half-spaces, and obstacles without mirror planes.
///
/// usage: plain-mpm EXPORTED RESULTS [RUN...]      then: mpm-validate grade CASE --results RESULTS

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/plain_step.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"

namespace {

using namespace mpm;
using nlohmann::json;
using Path = std::filesystem::path;

/// Indices of xx, yy, zz, xy, xz, yz.
constexpr std::array<std::pair<int, int>, 6> components{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
constexpr std::array component_names{"xx", "yy", "zz", "xy", "xz", "yz"};

plain::Law law_of(const MaterialParameters& material) {
  if (const auto* m = material.get_if<HenckyElastic>()) return plain::elastic(m->density, m->young_modulus, m->poisson_ratio);
  if (const auto* m = material.get_if<CamClay>()) {
    const double slope = m->critical_state_slope, beta = m->cohesion_beta, xi = m->hardening_xi, pc0 = m->preconsolidation_pressure;
    return slope > 0.0 ? plain::cam_clay(m->density, m->young_modulus, m->poisson_ratio, slope, beta, xi, pc0)
                       : plain::slippery_snow(m->density, m->young_modulus, m->poisson_ratio, beta, xi, pc0);
  }
  if (const auto* m = material.get_if<WeaklyCompressibleFluid>(); m != nullptr && m->viscosity == 0.0)
    return plain::fluid(m->density, m->bulk_modulus, m->tait_exponent, m->carries_tension);
  if (const auto* m = material.get_if<DruckerPrager>();
      m != nullptr && m->cohesion == 0.0 && m->dilatancy_angle == 0.0 && !m->limit_friction_angle) {
    const double sine = std::sin(m->friction_angle);
    const double slope = m->cone_matching == ConeMatching::simple_shear   ? std::sqrt(3.0) * std::tan(m->friction_angle)
                         : m->cone_matching == ConeMatching::plane_strain ? std::sqrt(3.0) * sine
                                                                          : 6.0 * sine / (3.0 - sine);
    return plain::drucker_prager(m->density, m->young_modulus, m->poisson_ratio, slope);
  }
  throw ConfigError(fmt::format("[material] model: plain-mpm has no law '{}' with these parameters; use another case", material.name()));
}

/// The particles of t = 0, in the order of the file. Law and places are those of the plain step.
std::vector<plain::Particle> read_particles(const Path& file, const plain::Law& law, const Vec3& offset) {
  const Table table = Table::read(file);
  std::vector<plain::Particle> all(table.rows());
  const auto fill = [&](const std::string& column, auto&& place) {
    const std::vector<double> values = table.numbers(column);
    for (std::size_t i = 0; i < all.size(); ++i) place(all[i]) = values[i];
  };
  for (int a = 0; a < 3; ++a) {
    fill(fmt::format("{}_m", "xyz"[a]), [a](plain::Particle& p) -> double& { return p.x[a]; });
    fill(fmt::format("v{}_m_s", "xyz"[a]), [a](plain::Particle& p) -> double& { return p.v[a]; });
    for (int b = 0; b < 3; ++b)
      fill(fmt::format("dv{}_d{}_1_s", "xyz"[a], "xyz"[b]), [a, b](plain::Particle& p) -> double& { return p.c(a, b); });
  }
  for (std::size_t k = 0; k < components.size(); ++k) {
    const auto [i, j] = components[k];
    fill(fmt::format("stress_{}_pa", component_names[k]), [i = i, j = j](plain::Particle& p) -> double& { return p.tau(i, j); });
  }
  fill("volume_m3", [](plain::Particle& p) -> double& { return p.volume; });
  fill("volume_ratio", [](plain::Particle& p) -> double& { return p.ratio; });
  fill("internal", [](plain::Particle& p) -> double& { return p.internal; });
  for (plain::Particle& p : all) {
    p.x += offset;
    p.tau = p.ratio * Mat3(p.tau.selfadjointView<Eigen::Upper>());  // the file has Cauchy's stress
    if (!law.pressure) p.b_e = law.elastic_state(p.tau);
  }
  return all;
}

/// A number of a particle by its column, in the coordinates of the case.
double value_of(const plain::Particle& p, const std::string& column, const Vec3& offset) {
  for (int a = 0; a < 3; ++a) {
    if (column == fmt::format("{}_m", "xyz"[a])) return p.x[a] - offset[a];
    if (column == fmt::format("v{}_m_s", "xyz"[a])) return p.v[a];
  }
  for (std::size_t k = 0; k < components.size(); ++k)
    if (column == fmt::format("stress_{}_pa", component_names[k])) return p.tau(components[k].first, components[k].second) / p.ratio;
  if (column == "volume_ratio") return p.ratio;
  if (column == "id") return static_cast<double>(p.id);
  throw IoError(fmt::format("case.json: results: plain-mpm does not know the column '{}'", column));
}

void write_state(const Path& file, const plain::Solver& solver, const json& wanted, const Vec3& offset) {
  std::vector<std::string> names;
  for (const json& column : wanted) names.push_back(column.at("name"));
  std::string text = csv_line(names);
  for (const plain::Particle& p : solver.particles) {
    std::vector<double> row;
    for (const std::string& name : names) row.push_back(value_of(p, name, offset));
    text += csv_line(row);
  }
  std::ofstream stream(file);  // not write_file, which forces each of hundreds of files to the disk
  if (!(stream << text) || !stream.flush()) throw IoError(fmt::format("cannot write '{}'; free space on the disk", file.string()));
}

/// One run, from t = 0 through its times.
void solve(const json& run, const Path& exported, const Path& results) {
  const std::string id = run.at("id");
  const Case c = read_case(exported / id / "case.toml");
  const CaseScene scene = make_scene(c);
  plain::Solver solver(scene, law_of(c.material), c.numerics.cell_size);
  solver.particles = read_particles(exported / id / "particles.csv", law_of(c.material), scene.offset);
  for (std::size_t i = 0; i < solver.particles.size(); ++i) solver.particles[i].id = i;
  for (const plain::Particle& p : solver.particles) solver.max_speed = std::max(solver.max_speed, p.v.norm());

  const json& wanted = run.at("results");
  const Path target = results / id;
  make_directory(target / "states");
  std::string forces = "time_s,boundary,force_x_n,force_y_n,force_z_n\n";
  std::size_t number = 0;
  double start = 0.0;
  for (const double end : wanted.at("times_s")) {
    const std::vector<Vec3> before = solver.impulses;
    while (end - solver.time > 1e-12 * end) {
      const json& given = run.at("time_step_s");
      const double left = end - solver.time, most = given.is_null() ? left / solver.stable_step() : left / given.get<double>();
      solver.step(left / std::max(1.0, given.is_null() ? std::ceil(most) : std::round(most)));
    }
    for (std::size_t b = 0; b < before.size(); ++b) {
      const Vec3 force = (solver.impulses[b] - before[b]) / (scene.mirror.parts() * (end - start));
      forces +=
          fmt::format("{},{},{},{},{}\n", end, run.at("boundaries").at(b).at("name").get<std::string>(), force.x(), force.y(), force.z());
    }
    start = end;
    if (wanted.contains("states"))
      write_state(target / "states" / fmt::format("{:04}.csv", ++number), solver, wanted["states"]["columns"], scene.offset);
  }
  write_file(target / "forces.csv", forces);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: plain-mpm EXPORTED RESULTS [RUN...]\n");
    return static_cast<int>(ExitCode::usage);
  }
  try {
    const Path exported = argv[1], results = argv[2];
    const std::vector<std::string> chosen(argv + 3, argv + argc);
    const json description = json::parse(read_file(exported / "case.json"));
    for (const json& run : description.at("runs"))
      if (chosen.empty() || std::ranges::find(chosen, run.at("id").get<std::string>()) != chosen.end()) solve(run, exported, results);
    write_file(results / "case.json", description.dump(1) + "\n");  // names the case and the level
    write_file(results / "solver.json", json{{"name", "plain_mpm"}, {"remark", "validation/foreign/plain_mpm.cpp"}}.dump() + "\n");
    return static_cast<int>(ExitCode::ok);
  } catch (const Error& error) {
    fmt::print(stderr, "plain-mpm: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "plain-mpm: {}\n", error.what());
    return static_cast<int>(ExitCode::internal);
  }
}
