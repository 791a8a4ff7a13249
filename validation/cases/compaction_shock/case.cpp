#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "libmpm/base/error.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/convergence.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/particle_access.hpp"
#include "validation/harness/point_comparison.hpp"
#include "validation/harness/root.hpp"
#include "validation/harness/setup.hpp"
#include "validation/harness/shallow_flow.hpp"
#include "validation/harness/slender.hpp"

namespace mpm::validation::compaction_shock {
namespace {

/// A state of one-dimensional compression, e = -ln J.
struct Compressed {
  double compression = 0.0;     ///< e
  double stress = 0.0;          ///< axial, Cauchy, compression positive, Pa
  double elastic_energy = 0.0;  ///< J per m^3 of uncompressed snow
  [[nodiscard]] double volume_ratio() const { return std::exp(-compression); }
};

/// The path of one-dimensional compression: elastic up to the onset of yield, then plastic.
class OedometricPath {
 public:
  OedometricPath(const mpm::CamClay::Parameters& spec, double largest) : model_(reference_model(spec)) {
    const CamClay& m = model_;
    if (m.critical_state_slope == 0.0) {
      onset_ = m.preconsolidation_pressure / m.bulk_modulus;
      return;
    }
    ReferenceOptions options;
    options.samples_per_segment = 4000;
    const ReferencePath path = coaxial_reference(m, {ReferenceSegment::strain_increment(-largest, 2.0 / 3.0 * largest)}, options);
    if (path.events.size() != 1 || path.events[0].event != PathEvent::onset)
      throw ConfigError("compaction_shock: the oedometric path of this snow has events beyond the onset of yield");
    onset_ = path.events[0].time * largest;
    for (const ReferencePoint& r : path.points) {
      if (r.time * largest <= onset_) continue;
      points_.push_back({-r.eps_v, (r.p + 2.0 / 3.0 * r.q_signed) * std::exp(-r.eps_v),
                         r.p * r.p / (2.0 * m.bulk_modulus) + r.q * r.q / (6.0 * m.shear_modulus)});
    }
    points_.insert(points_.begin(), at(onset_));
  }
  [[nodiscard]] double onset() const { return onset_; }
  [[nodiscard]] Compressed at(double e) const {
    const CamClay& m = model_;
    if (m.critical_state_slope == 0.0) {
      const double p = e <= onset_ ? m.bulk_modulus * e : m.preconsolidation(exact::isotropic_compression(m, e));
      return {e, p * std::exp(e), p * p / (2.0 * m.bulk_modulus)};
    }
    if (e <= onset_) {
      const double modulus = m.bulk_modulus + 4.0 / 3.0 * m.shear_modulus;
      return {e, modulus * e * std::exp(e), 0.5 * modulus * e * e};
    }
    const auto above =
        std::lower_bound(points_.begin() + 1, points_.end() - 1, e, [](const Compressed& c, double x) { return c.compression < x; });
    const Compressed &a = *(above - 1), &b = *above;
    const double share = (e - a.compression) / (b.compression - a.compression);
    return {e, a.stress + share * (b.stress - a.stress), a.elastic_energy + share * (b.elastic_energy - a.elastic_energy)};
  }

 private:
  CamClay model_;
  double onset_ = 0.0;
  std::vector<Compressed> points_;
};

/// A wave that the wall sends into the snow: the states before and behind it, and its speed in the uncompressed snow, m/s.
struct Wave {
  Compressed ahead, behind;
  double speed = 0.0;
};

/// The waves from rest to a state, fast ones first: the upper concave hull of stress over 1 - J. A chord of it is a shock (jump conditions
/// of mass and momentum), a part that runs along the path is a fan, here cut into many small waves.
class Waves {
 public:
  /// @param velocity  of the snow towards the wall, which stops it, m/s
  Waves(const OedometricPath& path, double density, double velocity, double largest) : density_(density), velocity_(velocity) {
    const double e = root_between([&](double x) { return passed(hull(path, x)) - velocity; }, 1e-4, largest);
    states_ = hull(path, e);
    for (std::size_t i = 1; i < states_.size(); ++i) waves_.push_back({states_[i - 1], states_[i], speed(states_[i - 1], states_[i])});
  }
  [[nodiscard]] const std::vector<Wave>& all() const { return waves_; }
  [[nodiscard]] const Wave& first() const { return waves_.front(); }
  [[nodiscard]] const Wave& last() const { return waves_.back(); }
  [[nodiscard]] const Compressed& behind() const { return states_.back(); }
  /// Velocity of the snow towards the wall behind a wave, m/s.
  [[nodiscard]] double velocity_behind(std::size_t wave) const {
    return velocity_ - passed({states_.begin(), states_.begin() + static_cast<long>(wave) + 2});
  }
  /// Kinetic and elastic energy of a column at a time, over its first energy; no wave has left the column.
  [[nodiscard]] double energy(double length, double time) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < waves_.size(); ++i) {
      const double layer = (waves_[i].speed - (i + 1 < waves_.size() ? waves_[i + 1].speed : 0.0)) * time;
      sum += layer * (0.5 * density_ * std::pow(velocity_behind(i), 2) + waves_[i].behind.elastic_energy);
    }
    const double first = 0.5 * density_ * velocity_ * velocity_;
    return (sum + (length - first_speed() * time) * first) / (length * first);
  }
  [[nodiscard]] double first_speed() const { return waves_.front().speed; }

 private:
  [[nodiscard]] double speed(const Compressed& a, const Compressed& b) const {
    return std::sqrt((b.stress - a.stress) / (density_ * (a.volume_ratio() - b.volume_ratio())));
  }
  /// Change of velocity over all waves, m/s.
  [[nodiscard]] double passed(const std::vector<Compressed>& states) const {
    double sum = 0.0;
    for (std::size_t i = 1; i < states.size(); ++i)
      sum += (states[i].stress - states[i - 1].stress) / (density_ * speed(states[i - 1], states[i]));
    return sum;
  }
  [[nodiscard]] static std::vector<Compressed> hull(const OedometricPath& path, double e) {
    constexpr int points = 2000;
    std::vector<Compressed> kept;
    const auto add = [&](const Compressed& c) {
      const auto below = [&](const Compressed& a, const Compressed& b) {  // b lies below the chord from a to c
        return (b.stress - a.stress) * (a.volume_ratio() - c.volume_ratio()) <=
               (c.stress - a.stress) * (a.volume_ratio() - b.volume_ratio());
      };
      while (kept.size() > 1 && below(kept[kept.size() - 2], kept.back())) kept.pop_back();
      kept.push_back(c);
    };
    add({});
    for (int i = 1; i <= points; ++i) {
      const double at = e * i / points, before = e * (i - 1) / points;
      if (before < path.onset() && path.onset() < at) add(path.at(path.onset()));
      add(path.at(at));
    }
    return kept;
  }
  double density_, velocity_;
  std::vector<Compressed> states_;
  std::vector<Wave> waves_;
};

struct Snow {
  std::string id, name;
  double slope, beta, xi;
  double velocity;  ///< m/s
};

struct Settings {
  Snow snow;
  int cells = 64;
  Transfer transfer = Transfer::aflip;
  double flip_ratio = 0.0;
};

/// Over the exact value, but for the fields and energies.
struct Measured {
  double cell = 0.0;
  double force = 0.0, stress = 0.0, density = 0.0, speed = 0.0, first_speed = 0.0;
  double energy = 0.0, energy_exact = 0.0;       ///< of the column, over its first energy
  double mass_jump = 0.0, momentum_jump = 0.0;   ///< sides of the jump conditions of the last wave, over one another
  std::vector<double> place, axial, compaction;  ///< X/L, kPa, rho/rho_0 of the particles at the end
};

constexpr std::size_t instants = 40;  ///< between the first and the last place of a wave

/// When the waves are judged, s: the first wave from a fifth of `middle` to it, the last one from there to `end`.
struct Times {
  double middle, end;
  Times(const Waves& exact, double length) {
    // The first wave comes back from the free end and meets the last one at 2 L/(U_1 + U_2).
    end = 0.8 * 2.0 * length / (exact.first().speed + exact.last().speed);
    middle = 0.5 * end;
    if (exact.first().speed * middle > length) throw ConfigError("compaction_shock: the precursor reaches the free end too soon");
  }
};

Setup shock_setup(const Case& base, const Settings& s, const Waves& exact) {
  Case c = base;
  const double length = c.bodies[0].max.x(), dx = length / s.cells;
  c.material = with_plasticity(c.material.as<mpm::CamClay>(), s.snow.slope, s.snow.beta, s.snow.xi);
  c.numerics.cell_size = dx;
  c.numerics.transfer = s.transfer;
  c.numerics.flip_ratio = s.flip_ratio;
  c.bodies[0].velocity = Vec3(-s.snow.velocity, 0.0, 0.0);
  set_side(c, 0.5 * dx, {1, 2});
  const Times when(exact, length);
  std::vector<double> times{0.2 * when.middle};
  std::ranges::copy(even_times(0.2 * when.middle, when.middle, instants), std::back_inserter(times));
  std::ranges::copy(even_times(when.middle, when.end, instants), std::back_inserter(times));
  return {.id = fmt::format("{}-cells{}", s.snow.id, s.cells),
          .title = fmt::format("{}, {} cells in the length", s.snow.name, s.cells),
          .spec = std::move(c),
          .times = std::move(times),
          .fields = {.position = false, .stress = true, .volume_ratio = true, .identity = true},
          .forces = true};
}

Measured hit(const CaseContext& context, const Settings& s, const Waves& exact) {
  const Setup setup = shock_setup(context.read_case(), s, exact);
  const Case& c = setup.spec;
  const double length = c.bodies[0].max.x(), side = c.bodies[0].max.y(), v = s.snow.velocity, density = c.material.density();
  const CaseScene scene = make_scene(c);
  const State lattice = setup.start(c, scene);
  const std::vector<Vec3> reference = reference_positions(lattice);
  const double area = side * side, start = totals(lattice, scene).kinetic_energy;
  const Times when(exact, length);
  const double before = exact.velocity_behind(exact.all().size() - 2);
  Measured m;
  m.cell = 1.0 / s.cells;
  // Speed at which the snow that is slower than a velocity grows, uncompressed: the slope of a line through all instants, because the
  // length moves by whole particles.
  const auto slower_than = [&](const Instant& now, double velocity) {
    double sum = 0.0;
    for (const ParticleRecord& p : now.particles) sum += -p.velocity.x() < velocity ? p.mass / (density * area) : 0.0;
    return sum;
  };
  std::vector<double> first_time, first_grown, last_time, last_grown;
  double impulse = 0.0, stress = 0.0, volume = 0.0, uncompressed = 0.0, weight = 0.0;
  play(context, setup, [&](const Instant& now) {
    if (now.index <= instants) {
      first_time.push_back(now.time);
      first_grown.push_back(slower_than(now, 0.5 * (v + exact.velocity_behind(0))));
    }
    if (now.index == instants && now.state != nullptr) {
      const Totals all = totals(*now.state, *now.scene);
      m.energy = (all.kinetic_energy + all.affine_energy + all.elastic_energy) / start;
    }
    if (now.index < instants) return true;
    last_time.push_back(now.time);
    last_grown.push_back(slower_than(now, 0.5 * before));
    if (now.index > instants) impulse += now.forces[0].x() * (now.time - now.before);
    if (now.index < 2 * instants) return true;
    for (const ParticleRecord& p : now.particles) {
      const double x = reference[p.id].x();
      m.place.push_back(x / length);
      m.axial.push_back(-1e-3 * p.stress[0]);
      m.compaction.push_back(1.0 / p.volume_ratio);
      if (x < 0.2 * exact.last().speed * when.end || x > 0.7 * exact.last().speed * when.end) continue;
      stress -= p.stress[0];
      volume += p.mass / density * p.volume_ratio;
      uncompressed += p.mass / density;
      weight += 1.0;
    }
    return true;
  });
  const double speed = fitted_line(last_time, last_grown).slope;
  m.first_speed = fitted_line(first_time, first_grown).slope / exact.first().speed;
  m.energy_exact = exact.energy(length, when.middle);
  m.speed = speed / exact.last().speed;
  m.force = -impulse / ((when.end - when.middle) * area * exact.behind().stress);
  stress /= weight;
  m.stress = stress / exact.behind().stress;
  m.density = uncompressed / volume * exact.behind().volume_ratio();
  const Compressed& ahead = exact.last().ahead;
  m.mass_jump = speed * (ahead.volume_ratio() - volume / uncompressed) / before;
  m.momentum_jump = (stress - ahead.stress) / (density * speed * before);
  return m;
}

struct Method {
  std::string name;
  Transfer transfer;
  double flip_ratio;
};

constexpr double largest = 1.5;  ///< compression that the oedometric path reaches

/// The state behind the shock, its speed and the energy of the column against the exact ones.
void check_state(CaseResult& result, const std::string& name, const std::string& method, const Waves& exact, double density,
                 const Measured& m, bool own) {
  const double stress = exact.behind().stress;
  const double tolerance = own ? 0.01 : 0.02;
  const std::string reason = own ? "1 %: aim; the viscosity of shocks leaves an overshoot of half a percent, on any grid"
                                 : "2 %: what a diffusion of dx²/dt leaves behind its wide front";
  const auto check = [&](const std::string& what, double value, Quantity quantity, double unit, double more = 0.0) {
    Check& c = result.check_relative(Label::verification, name + ": " + what, value, 1.0, "", tolerance + more, reason);
    if (method == "AFLIP" || !own) c.in_summary(quantity, 0.0, unit);
  };
  check("force on the wall over the exact one", m.force, Quantity::force, stress);
  check("axial stress behind the shock over the exact one", m.stress, Quantity::pressure, stress, own ? 0.0 : 0.01);
  check("density behind the shock over the exact one", m.density, Quantity::density, density / exact.behind().volume_ratio());
  check("speed of the shock over the exact one", m.speed, Quantity::speed, exact.last().speed);
  if (!own) return;
  result.check_absolute(Label::verification, name + ": energy of the column at half time, over its first energy", m.energy, m.energy_exact,
                        "", 0.02, "2 % of the first energy: what the wave fronts, some four cells wide, dissipate more than a jump");
}

/// Jump conditions of the last wave, which hold for any state behind it, and the speed of the elastic precursor.
void check_jumps(CaseResult& result, const std::string& name, const Snow& snow, const Measured& m) {
  result.check_relative(Label::verification, name + ": mass through the shock, U (J₁ − J₂) over the jump of velocity", m.mass_jump, 1.0, "",
                        0.02, "2 %: the front passes some 50 cells, its place is known to about one");
  result.check_relative(Label::verification, name + ": momentum, jump of stress over ρ0 U times the jump of velocity", m.momentum_jump, 1.0,
                        "", 0.03, "3 %: as the mass, and particles at one instant");
  if (snow.slope != 0.0) return;
  result.check_relative(Label::verification, name + ": speed of the elastic precursor over the exact one", m.first_speed, 1.0, "", 0.02,
                        "2 %: as the shock's place");
}

std::vector<int> grids_of(const CaseContext& context) {
  return context.choose<std::vector<int>>({32, 64, 128}, {32, 64, 128, 256}, {32, 64, 128, 256, 512});
}

const std::vector<Snow>& all_snows() {
  static const std::vector<Snow> snows = {{"m0-xi0.05", "M 0, ξ 0.05", 0.0, 0.15, 0.05, 8.0},
                                          {"m0-xi0.5", "M 0, ξ 0.5", 0.0, 0.15, 0.5, 8.0},
                                          {"m0.8-b0.3", "M 0.8, β 0.3, ξ 0.5", 0.8, 0.3, 0.5, 8.0}};
  return snows;
}

/// The runs that every solver makes: one for each snow and grid.
std::vector<Setup> setups(const CaseContext& context) {
  const Case base = context.read_case();
  const auto material = base.material.as<mpm::CamClay>();
  std::vector<Setup> all;
  for (const Snow& snow : all_snows()) {
    const OedometricPath path(with_plasticity(material, snow.slope, snow.beta, snow.xi), largest);
    const Waves exact(path, material.density, snow.velocity, largest);
    for (const int cells : grids_of(context)) all.push_back(shock_setup(base, {snow, cells}, exact));
  }
  return all;
}

void run(const CaseContext& context, CaseResult& result) {
  const Case c = context.read_case();
  const auto base = c.material.as<mpm::CamClay>();
  const std::vector<int> grids = grids_of(context);
  const std::vector<Snow>& snows = all_snows();
  const bool own = own_run(context);
  std::vector<Method> methods = {{"AFLIP", Transfer::aflip, 0.0}, {"APIC", Transfer::apic, 0.0}};
  if (context.level() != Level::quick) methods.push_back({"FLIP", Transfer::flip, 1.0});
  if (!own) methods = {{"result", Transfer::aflip, 0.0}};
  for (std::size_t k = 0; k < snows.size(); ++k) {
    const Snow& snow = snows[k];
    const OedometricPath path(with_plasticity(base, snow.slope, snow.beta, snow.xi), largest);
    const Waves exact(path, base.density, snow.velocity, largest);
    const double length = c.bodies[0].max.x(), end = 0.8 * 2.0 * length / (exact.first().speed + exact.last().speed);
    Plot stress{fmt::format("stress-{}", k), snow.name + ": axial stress on the finest grid", "X / L [-]", "axial stress [kPa]"};
    Plot density{fmt::format("density-{}", k), snow.name + ": density on the finest grid", "X / L [-]", "ρ / ρ0 [-]"};
    Series stress_line{"exact", {}, {}, Series::Style::reference}, density_line = stress_line;
    const auto corner = [&](double x, const Compressed& state) {
      stress_line.x.push_back(x), stress_line.y.push_back(1e-3 * state.stress);
      density_line.x.push_back(x), density_line.y.push_back(1.0 / state.volume_ratio());
    };
    corner(0.0, exact.behind());
    for (std::size_t i = exact.all().size(); i-- > 0;) {
      const double x = exact.all()[i].speed * end / length;
      if (x > 1.0) break;
      corner(x, exact.all()[i].behind), corner(x, exact.all()[i].ahead);
    }
    stress.series.push_back(stress_line);
    density.series.push_back(density_line);
    for (const Method& method : methods) {
      std::vector<double> cell, error;
      Measured finest;
      for (const int cells : grids) {
        finest = hit(context, {snow, cells, method.transfer, method.flip_ratio}, exact);
        cell.push_back(finest.cell), error.push_back(std::abs(finest.density - 1.0));
      }
      const std::string name = own ? snow.name + ", " + method.name : snow.name;
      if (method.transfer != Transfer::flip) {  // FLIP is shown for comparison
        check_state(result, name, method.name, exact, base.density, finest, own);
        check_jumps(result, name, snow, finest);
      }
      if (!own) {
        const double order = fitted_order(cell, error);
        result
            .check_order(Label::verification, name + ": order of the density behind the shock", order, 0.8, 3.0,
                         "the diffusion is of first order; behind the front the error falls faster than its width")
            .observed_order = order;
      }
      result.notes.push_back(
          fmt::format("{}: force {:.4f}, stress {:.4f}, density {:.4f} (errors {:.1e} to {:.1e}), speed {:.4f}, precursor {:.4f}; energy "
                      "{:.4f}, exact {:.4f}.",
                      name, finest.force, finest.stress, finest.density, error.front(), error.back(), finest.speed, finest.first_speed,
                      finest.energy, finest.energy_exact));
      if (method.name == "FLIP") continue;
      stress.series.push_back({method.name, finest.place, finest.axial, Series::Style::points});
      density.series.push_back({method.name, finest.place, finest.compaction, Series::Style::points});
    }
    result.notes.push_back(
        fmt::format("{}, exact: {} waves, the first at {:.2f} m/s, the last at {:.2f} m/s; axial stress {:.2f} kPa before and {:.2f} kPa "
                    "behind it, ρ/ρ0 {:.4f}.",
                    snow.name, exact.all().size(), exact.first().speed, exact.last().speed, 1e-3 * exact.last().ahead.stress,
                    1e-3 * exact.behind().stress, 1.0 / exact.behind().volume_ratio()));
    result.plots.push_back(std::move(stress));
    result.plots.push_back(std::move(density));
    context.log(snow.name);
  }
}

const Registration registered{{.title = "Compaction shock: snow on a wall", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::compaction_shock
