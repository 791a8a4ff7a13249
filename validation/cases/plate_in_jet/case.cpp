#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/core/stress_update.hpp"
#include "libmpm/driver/case_file.hpp"
#include "validation/cases/plate_in_jet/free_streamlines.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/plane_jet.hpp"

namespace mpm::validation {
namespace {

constexpr double exit_near = 3.0, exit_far = 5.0;  ///< b from the axis: where the turned jet is measured

using Setting = PlaneJetSetting;

struct Measured {
  double ratio = 0.0;     ///< l/d
  double exact = 0.0;     ///< force over rho U^2 d
  BatchMean force{};      ///< over the exact one
  std::vector<double> y;  ///< middles of the rows of cells along the plate, over l/2
  std::vector<double> p;  ///< mean pressure in the row of cells before the plate, over rho U^2/2
  std::vector<double> p_exact;
  double angle = 0.0, angle_exact = 0.0;  ///< of the turned jet, degrees
  double speed = 0.0;                     ///< of it, over U
  std::vector<double> time, history;
  double particle_steps = 0.0;
};

/// Sums over the particles of some instants.
class FlowSums {
 public:
  FlowSums(double dx, double half_width) : dx_(dx), sum_(static_cast<std::size_t>(std::ceil(half_width / dx - 1e-9)), 0.0), count_(sum_) {}

  void add(const State& state, const CaseScene& scene, double b) {
    state.grid.for_each_particle([&](const Particle& p) {
      const double x = p.position[0] - scene.offset.x(), y = std::abs(p.position[1] - scene.offset.y());
      if (y > exit_near * b && y < exit_far * b) {
        exit_x_ += p.volume * p.velocity[0];
        exit_y_ += p.volume * std::abs(p.velocity[1]);
        exit_speed_ += p.volume * std::hypot(p.velocity[0], p.velocity[1]);
        exit_volume_ += p.volume;
      }
      const auto row = static_cast<std::size_t>(y / dx_);
      if (x < -dx_ || x > 0.0 || row >= sum_.size()) return;
      sum_[row] -= (p.stress[0] + p.stress[1] + p.stress[2]) / (3.0 * volume_ratio(scene.material, p));
      count_[row] += 1.0;
    });
  }
  [[nodiscard]] std::vector<double> pressure() const {
    std::vector<double> p;
    for (std::size_t i = 0; i < sum_.size(); ++i) p.push_back(sum_[i] / std::max(count_[i], 1.0));
    return p;
  }
  [[nodiscard]] double exit_angle() const { return std::atan2(exit_y_, exit_x_); }
  [[nodiscard]] double exit_speed() const { return exit_speed_ / exit_volume_; }

 private:
  double dx_;
  std::vector<double> sum_, count_;
  double exit_x_ = 0.0, exit_y_ = 0.0, exit_speed_ = 0.0, exit_volume_ = 0.0;
};

Measured run_jet(const Case& base, const Setting& s) {
  const double l = base.obstacle->width(), u = base.bodies[0].velocity.x(), density = base.material.density(), dx = l / s.cells;
  FlowSums sums(dx, 0.5 * l);
  const PlaneJetForce run =
      run_plane_jet(base, s, [&](const State& state, const CaseScene& scene, double b) { sums.add(state, scene, b); });
  const double b = run.half_thickness;
  Measured m;
  m.ratio = run.ratio;
  const PlateInJet exact(m.ratio);
  m.exact = exact.force();
  m.force = {run.mean.mean / m.exact, run.mean.standard_error / m.exact};
  m.time = run.time;
  for (const double f : run.force) m.history.push_back(f / m.exact);
  m.particle_steps = run.particle_steps;
  const std::vector<double> p = sums.pressure();
  for (std::size_t row = 0; row < p.size(); ++row) {
    // the whole of the row's cell counts, its edge row only up to the edge
    const double low = static_cast<double>(row) * dx, high = std::min(low + dx, 0.5 * l);
    constexpr int parts = 8;
    double mean = 0.0;
    for (int k = 0; k < parts; ++k) mean += exact.pressure((low + (k + 0.5) / parts * (high - low)) / (2.0 * b)) / parts;
    m.y.push_back((low + high) / l);
    m.p.push_back(p[row] / (0.5 * density * u * u));
    m.p_exact.push_back(mean);
  }
  constexpr double degrees = 180.0 / std::numbers::pi;
  m.angle = sums.exit_angle() * degrees;
  m.angle_exact = exact.exit_angle() * degrees;
  m.speed = sums.exit_speed() / u;
  return m;
}

std::vector<Measured> run_all(const CaseContext& context, const Case& base, const std::vector<Setting>& settings) {
  std::vector<Measured> all(settings.size());
  in_parallel(settings.size(), [&](std::size_t i) { all[i] = run_jet(base, settings[i]); });
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Setting& s = settings[i];
    context.log(fmt::format("{} cells, l/d {:.3f}, cfl {}, shift {} {}: force {:.4f} ({:.4f}) of the exact; {:.2g} particle-steps", s.cells,
                            all[i].ratio, s.cfl, s.shift_x, s.shift_y, all[i].force.mean, all[i].force.standard_error,
                            all[i].particle_steps));
  }
  return all;
}

/// What the issue of the plate asks for: 3 % at seven cells, 2 % at thirteen, 1 % at twenty-five.
double tolerance(int cells) { return cells >= 24 ? 0.01 : cells >= 12 ? 0.02 : 0.03; }

void check_force(CaseResult& result, const std::string& name, const Setting& s, const Measured& m) {
  result.check_relative(Label::verification, name + ": force over the exact one", m.force.mean, 1.0, "", tolerance(s.cells),
                        "3 % at five to seven cells, 2 % from twelve, 1 % from twenty-four on");
}

void run(const CaseContext& context, CaseResult& result) {
  const Case base = read_case(context.case_directory() / "case.toml");
  {  // the reference itself: its pressure carries its force
    const PlateInJet exact(0.75);
    double sum = 0.0;
    constexpr int parts = 20000;  // midpoints of tau: the integrand is smooth in it
    for (int k = 0; k < parts; ++k) {
      const double low = static_cast<double>(k) / parts, high = static_cast<double>(k + 1) / parts, tau = 0.5 * (low + high);
      sum += (1.0 - tau * tau) * (exact.place(high) - exact.place(low));
    }
    result.check_relative(Label::verification, "exact pressure summed over the plate against the momentum theorem, l/d = 0.75", sum,
                          exact.force(), "ρU²d", 1e-8, "midpoint rule with 20000 parts");
  }

  struct Named {
    std::string name;
    Setting setting;
  };
  std::vector<Named> runs = {{"7 cells", {.cells = 7}},
                             {"6 cells", {.cells = 6}},
                             {"7 cells, grid moved by half a cell across", {.cells = 7, .shift_y = 0.5}},
                             {"7 cells, grid moved by 0.3 and 0.4 cells", {.cells = 7, .shift_x = 0.3, .shift_y = 0.4}},
                             {"7 cells, CFL 0.2", {.cells = 7, .cfl = 0.2}},
                             {"7 cells, CFL 0.8", {.cells = 7, .cfl = 0.8}}};
  if (context.level() != Level::quick) {
    runs.push_back({"5 cells", {.cells = 5}});
    runs.push_back({"12 cells", {.cells = 12}});
    runs.push_back({"13 cells", {.cells = 13}});
    runs.push_back({"7 cells, CFL 0.1", {.cells = 7, .cfl = 0.1}});
    for (const double shift : {0.25, 0.75})
      runs.push_back({fmt::format("7 cells, grid moved by {} along", shift), {.cells = 7, .shift_x = shift}});
    for (const double ratio : {0.3, 0.5, 1.0, 2.0}) runs.push_back({fmt::format("7 cells, l/d {}", ratio), {.cells = 7, .ratio = ratio}});
    runs.push_back({"24 cells", {.cells = 24}});
    runs.push_back({"25 cells", {.cells = 25}});
  }
  std::vector<Setting> settings;
  for (const Named& n : runs) settings.push_back(n.setting);
  settings.push_back({.cells = 7, .transfer = Transfer::apic, .contact = ContactRule::nodal, .lattice = BodySpec::Lattice::aligned});
  const std::vector<Measured> all = run_all(context, base, settings);

  for (std::size_t i = 0; i < runs.size(); ++i) check_force(result, runs[i].name, runs[i].setting, all[i]);
  const Measured &seven = all[0], &old = all.back();
  double worst = 0.0;
  for (std::size_t row = 0; row + 1 < seven.p.size(); ++row) worst = std::max(worst, std::abs(seven.p[row] - seven.p_exact[row]));
  result.check_absolute(Label::verification, "7 cells: largest error of the pressure along the plate over ρU²/2, but for the edge row",
                        worst, 0.0, "", 0.1,
                        "10 % of the dynamic pressure; the aim of 5 % is not met: the pressure of neighbouring cells differs by more");
  result.notes.push_back(
      fmt::format("Not met: the pressure along the plate within 5 % of ρU²/2; the largest error is {:.1f} %.", 100.0 * worst));
  result.check_absolute(Label::verification, "7 cells: angle of the turned jet", seven.angle, seven.angle_exact, "°", 2.0,
                        "measured at 3 to 5 b from the axis, where the sheets are still curved");
  result.check_relative(Label::verification, "7 cells: speed of the turned jet over U", seven.speed, 1.0, "", 0.02,
                        "no head is lost along a stream line; 2 % for the sheet's slowest cells beside the plate");
  result.notes.push_back(fmt::format(
      "With nodal contact, APIC and an aligned lattice the force at seven cells is {:.3f} ({:.3f}) times the exact one, the jet leaves at "
      "{:.1f}° and {:.3f} U (exact {:.1f}°).",
      old.force.mean, old.force.standard_error, old.angle, old.speed, old.angle_exact));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    result.notes.push_back(fmt::format("{}: l/d {:.4f}, force over ρU²d {:.4f}, exact {:.4f}: {:.4f} (standard error {:.4f}).",
                                       runs[i].name, all[i].ratio, all[i].force.mean * all[i].exact, all[i].exact, all[i].force.mean,
                                       all[i].force.standard_error));
  }

  result.plots.push_back({"force",
                          "Force on the plate at seven cells, over the exact one",
                          "time [b/U]",
                          "force / exact force [-]",
                          {{"exact", {0.0, jet_means_to}, {1.0, 1.0}, Series::Style::reference},
                           {"contact at the surface, AFLIP, staggered", seven.time, seven.history, Series::Style::simulation},
                           {"contact on nodes, APIC, aligned", old.time, old.history, Series::Style::simulation}},
                          "",
                          false,
                          false});
  const PlateInJet exact(seven.ratio);
  Series line{"exact", {}, {}, Series::Style::reference};
  for (int k = 0; k <= 100; ++k) {
    const double tau = k / 100.0;
    line.x.push_back(exact.place(tau) / exact.place(1.0));
    line.y.push_back(1.0 - tau * tau);
  }
  result.plots.push_back({"pressure",
                          "Pressure along the plate at seven cells",
                          "y / (l/2) [-]",
                          "pressure / (ρU²/2) [-]",
                          {line,
                           {"contact at the surface, AFLIP, staggered", seven.y, seven.p, Series::Style::points},
                           {"contact on nodes, APIC, aligned", old.y, old.p, Series::Style::points}},
                          "Means over time of the row of cells before the plate.",
                          false,
                          false});
}

const Registration registered{{MPM_CASE_NAME, "A plate in a plane jet: free streamlines", MPM_CASE_DIRECTORY, run}};

}  // namespace
}  // namespace mpm::validation
