#include "libmpm/impact/conveyor.hpp"

#include <fmt/format.h>

#include <cmath>

#include "libmpm/base/error.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/impact/semi_empirical.hpp"

namespace mpm {

namespace {

constexpr double reservoir_cells = 2.0;  ///< snow kept behind the inlet: the support of a node on the inlet is 3/2 cells
constexpr double outlet_cells = 2.0;
constexpr int levels_off_lattice = 16;  ///< places in height of a staggered or random particle within its row

/// Snow kept behind the inlet; rows of a sheared inflow may be late by the distance that the fastest covers while the plug moves one
/// spacing.
double reservoir_length(const Inflow& inflow, double cell_size, double spacing) {
  return reservoir_cells * cell_size + (inflow.sheared() ? inflow.shear(1.0) * spacing : 0.0);
}

MaterialState<double> compressed(const AnyMaterial& material, MaterialState<double> state, double dl_zz) {
  Matrix3<double> dl{};
  dl.m[2][2] = dl_zz;
  std::visit([&](const auto& law) { law.update_stress(state, dl, 1.0); }, material);
  return state;
}

}  // namespace

std::vector<ColumnPoint> settled_column(const AnyMaterial& material, double weight, double height, int count, double density_ratio) {
  std::vector<ColumnPoint> column(static_cast<std::size_t>(count));
  MaterialState<double> state{{}, initial_internal_of(material) + std::log(density_ratio)};
  const double layer = height / count;
  for (int j = count - 1; j >= 0; --j) {
    const double target = -density_ratio * weight * (height - (j + 0.5) * layer);  // Cauchy sigma_zz
    const auto excess = [&](double dl) {
      const auto s = compressed(material, state, dl);
      return s.stress.zz / volume_ratio(material, s) - target;
    };
    double loose = 0.0, tight = -1e-6;  // bracket: sigma_zz falls as the column is compressed
    while (excess(tight) > 0.0) {
      tight *= 2.0;
      if (tight < -0.9)
        throw UnstableError(fmt::format("the material cannot carry its own weight over {:.3g} m: no confined equilibrium", height));
    }
    // Plain bisection on purpose: another method would change the last bits of the initial stresses, and so of every result.
    for (int i = 0; i < 80; ++i) {
      const double middle = 0.5 * (loose + tight);
      (excess(middle) > 0.0 ? loose : tight) = middle;
    }
    if (target < 0.0) state = compressed(material, state, tight);
    column[static_cast<std::size_t>(j)].state = state;
  }
  double below = 0.0;
  for (auto& point : column) {
    const double thickness = layer * density_ratio * volume_ratio(material, point.state);
    point.height = below + 0.5 * thickness;
    below += thickness;
  }
  return column;
}

ConveyorSource::ConveyorSource(const ConveyorSpec& conveyor, const AnyMaterial& material, const ConveyorSetting& setting)
    : material_(material), inflow_(conveyor) {
  spacing_ = setting.particle_spacing;
  density_ = density_of(material);
  weight_ = density_ * setting.gravity * std::cos(setting.slope);
  offset_ = setting.offset;
  ground_ = setting.ground;
  front_run_ = 1.0 / std::tan(conveyor.front_angle);
  endless_ = conveyor.feed == ConveyorSpec::Feed::window;
  mirror_y_ = conveyor.mirror_y;
  if (!endless_ && (inflow_.sheared() || !inflow_.steady()))
    throw ConfigError("[conveyor] feed = \"strip\": a strip moves as one; inflow that varies needs feed = \"window\"");
  if (inflow_.sheared() && (!inflow_.steady() || conveyor.sidewall_contact != Contact::slip))
    throw ConfigError("[conveyor] inflow_slip_ratio: sheared inflow is steady and needs sidewall_contact = \"slip\"");
  const double length = endless_ ? conveyor.upstream_length + reservoir_length(inflow_, setting.cell_size, spacing_)
                                 : conveyor_length(conveyor.velocity, setting.duration);
  release_at_ = -length;
  initial_layers_ = static_cast<std::uint64_t>(std::max(0.0, std::floor(length / spacing_ + 0.5)));
  half_count_ = std::max(1, static_cast<int>(std::lround(0.5 * conveyor.width / spacing_)));
  spacing_y_ = 0.5 * conveyor.width / half_count_;
  lattice_ = conveyor.lattice;
  levels_ = lattice_ == Lattice::aligned ? 1 : levels_off_lattice;
  if (lattice_ == Lattice::random) {
    for (long k = 0; k < random_period; ++k) {
      std::size_t points = 0;
      for (long i = 0; i < random_period; ++i)
        for (long j = 0; j < half_count_; ++j) points += random_points(i, j, k).size();
      share_[static_cast<std::size_t>(k)] = static_cast<double>(random_period * half_count_) / static_cast<double>(points);
    }
  }
  if (inflow_.steady()) column_ = column_at(0.0);
}

int ConveyorSource::rows(double time) const { return std::max(1, static_cast<int>(std::lround(inflow_.flow_height(time) / spacing_))); }

std::vector<Particle> ConveyorSource::column_at(double time) const {
  const int count = rows(time);
  const double height = inflow_.flow_height(time), velocity = inflow_.velocity(time), ratio = inflow_.density_ratio(time);
  const std::vector<ColumnPoint> settled = settled_column(material_, weight_, height, count * levels_, ratio);
  std::vector<Particle> column;
  column.reserve(settled.size());
  for (const ColumnPoint& point : settled) {
    const std::size_t rows_below = column.size() / static_cast<std::size_t>(levels_);
    const auto row = static_cast<double>(rows_below);
    Particle p{};
    p.position[2] = point.height;
    p.volume = spacing_ * spacing_y_ * height / count * ratio;
    p.velocity[0] = velocity * inflow_.mean_shear(row / count, (row + 1.0) / count);
    const Sym3<double>& s = point.state.stress;
    const double stress[6] = {s.xx, s.yy, s.zz, s.xy, s.xz, s.yz};
    std::copy(std::begin(stress), std::end(stress), p.stress);
    p.internal = point.state.internal;
    column.push_back(p);
  }
  return column;
}

Vec3 ConveyorSource::shift_of(std::uint64_t layer) const {
  if (lattice_ != Lattice::staggered) return Vec3::Zero();
  const std::uint64_t pair = layer / 2;
  const double across = r2_point(static_cast<double>(pair)).a - 0.5;
  return {0.0, layer % 2 == 0 ? across : -across, r2_point(static_cast<double>(layer)).b - 0.5};
}

/// Inserts particles of a row of layer `layer`, moved by `distance` from their positions at t = 0.
void ConveyorSource::insert_row(State& state, FluxTotals& entered, std::span<const Particle> column, int row, std::uint64_t layer,
                                double distance) const {
  const auto n = static_cast<double>(layer);
  const double x = -(n + 0.5) * spacing_ + distance;
  const Vec3 regular = shift_of(layer);
  for (int j = mirror_y_ ? 0 : -half_count_; j < half_count_; ++j) {
    const bool random = lattice_ == Lattice::random;
    const int from_middle = j < 0 ? -1 - j : j;  // the halves are mirror images of each other
    for (const Vec3& shift : random ? random_points(static_cast<long>(layer), from_middle, row) : std::span(&regular, 1)) {
      const int level = static_cast<int>(levels_ * (shift.z() + 0.5));
      Particle p = column[static_cast<std::size_t>(row * levels_ + level)];
      if (random) p.volume *= share_[static_cast<std::size_t>(row % random_period)];
      p.position[0] = x - spacing_ * shift.x();
      if (layer < initial_layers_ && p.position[0] > -front_run_ * p.position[2]) continue;
      p.position[1] = (j + 0.5) * spacing_y_;
      p.position[1] += spacing_y_ * (j < 0 ? -shift.y() : shift.y());
      if (ground_ != nullptr) {
        const HeightField::Surface below = ground_->at({p.position[0], p.position[1]});
        p.position[2] += below.height;
        p.velocity[2] = p.velocity[0] * below.slope.x();
      }
      for (int i = 0; i < 3; ++i) p.position[i] += offset_[i];
      p.id = state.next_id++;
      state.grid.insert(p);
      const double mass = density_ * p.volume;
      const Vec3 velocity = velocity_of(p);
      entered += FluxTotals{1, 0, mass, mass * velocity, 0.5 * mass * velocity.squaredNorm() + stored_energy(material_, p)};
    }
  }
}

void ConveyorSource::insert_layer(State& state, FluxTotals& entered) const {
  const double distance = inflow_.travelled(state.time);
  const std::vector<Particle> changing = inflow_.steady() ? std::vector<Particle>() : column_at(state.time);
  const std::vector<Particle>& column = inflow_.steady() ? column_ : changing;
  for (int row = 0; row < rows(state.time); ++row) insert_row(state, entered, column, row, state.source_count, distance);
  ++state.source_count;
}

std::uint64_t ConveyorSource::due(double rate, double distance) const {
  return static_cast<std::uint64_t>(std::floor((rate * distance - release_at_) / spacing_ + 0.5));
}

/// Inserts the rows of a sheared inflow that became due since the previous multiple of the spacing.
void ConveyorSource::insert_rows(State& state, FluxTotals& entered) const {
  const double before = static_cast<double>(state.source_count - initial_layers_) * spacing_, now = before + spacing_;
  const double gone = inflow_.travelled(state.time);
  const int count = rows(0.0);
  for (int k = 0; k < count; ++k) {
    const double rate = inflow_.mean_shear(static_cast<double>(k) / count, static_cast<double>(k + 1) / count);
    for (std::uint64_t layer = due(rate, before); layer < due(rate, now); ++layer) {
      insert_row(state, entered, column_, k, layer, rate * gone);
    }
  }
  ++state.source_count;
}

void ConveyorSource::fill(State& state) const {
  FluxTotals unused;
  while (state.source_count < initial_layers_) insert_layer(state, unused);
  state.max_speed = inflow_.velocity(0.0) * inflow_.shear(1.0);
}

FluxTotals ConveyorSource::release(State& state) const {
  FluxTotals entered;
  if (!endless_) return entered;
  const double gone = inflow_.travelled(state.time);
  if (inflow_.sheared()) {
    while (static_cast<double>(state.source_count - initial_layers_ + 1) * spacing_ <= gone) insert_rows(state, entered);
  } else {
    while (-(static_cast<double>(state.source_count) + 0.5) * spacing_ + gone >= release_at_) insert_layer(state, entered);
  }
  if (entered.count > 0) state.grid.refresh();
  return entered;
}

double window_length(const ConveyorSpec& conveyor, double cell_size) {
  return conveyor.upstream_length + conveyor.downstream_length + (reservoir_cells + outlet_cells) * cell_size;
}

ConstantFlow constant_flow(const ConveyorSpec& conveyor, double gravity, double duration) {
  if (conveyor.feed == ConveyorSpec::Feed::strip) {
    const double celerity = std::sqrt(gravity * conveyor.flow_height);
    return {.until = conveyor_length(conveyor.velocity, duration) / (conveyor.velocity + celerity)};
  }
  const Inflow inflow(conveyor);
  if (inflow.steady()) return {};
  const double last = conveyor.inflow.back().time;
  return {.from = last + conveyor.upstream_length / inflow.velocity(last)};
}

std::vector<Boundary> conveyor_walls(const ConveyorSpec& conveyor, ContactRule rule, bool floor) {
  const Inflow inflow(conveyor);
  const Vec3 belt(inflow.velocity(0.0), 0.0, 0.0), outlet(inflow.fastest(), 0.0, 0.0);
  /// A wall that moves with the entering snow, if its speed varies with time or height.
  const auto moving = [&](Wall wall, bool by_height) {
    if (!inflow.steady() || (by_height && inflow.sheared())) {
      wall.speed = [inflow, by_height](double height, double time) {
        return inflow.velocity(time) * (by_height ? inflow.shear(height / inflow.flow_height(time)) : 1.0);
      };
    }
    return wall;
  };
  std::vector<Boundary> walls;
  if (floor) walls.emplace_back(Wall{Vec3::Zero(), Vec3::UnitZ(), Contact::separable, 0.0, Vec3::Zero(), false, rule});
  const double half = 0.5 * conveyor.width;
  walls.emplace_back(
      moving(Wall{Vec3(0, half, 0), -Vec3::UnitY(), conveyor.sidewall_contact, conveyor.sidewall_friction, belt, false, rule}, false));
  if (!conveyor.mirror_y)
    walls.emplace_back(
        moving(Wall{Vec3(0, -half, 0), Vec3::UnitY(), conveyor.sidewall_contact, conveyor.sidewall_friction, belt, false, rule}, false));
  if (conveyor.feed == ConveyorSpec::Feed::window) {
    // always nodal: there is snow on both sides of the inlet, and a folded wall would mirror the window's velocities behind it
    walls.emplace_back(moving(Wall{Vec3(-conveyor.upstream_length, 0, 0), Vec3::UnitX(), Contact::slip, 0.0, belt, false}, true));
    const Wall end{Vec3(conveyor.downstream_length, 0, 0), -Vec3::UnitX(), Contact::separable, 0.0, outlet, false};
    walls.emplace_back(inflow.sheared() ? moving(end, true) : end);
  }
  return walls;
}

Eigen::AlignedBox3d conveyor_domain(const ConveyorSpec& conveyor, const ConveyorSetting& setting) {
  const double dx = setting.cell_size;
  const Inflow inflow(conveyor);
  const double fastest = inflow.fastest() * inflow.shear(1.0), head = 0.5 * fastest * fastest / std::max(setting.gravity, 1e-3);
  const double height = std::max(conveyor.flow_height, inflow.highest());
  const double late = inflow.sheared() ? inflow.shear(1.0) * setting.particle_spacing : 0.0;
  const bool window = conveyor.feed == ConveyorSpec::Feed::window;
  const double travel = conveyor.velocity * setting.duration;
  Vec3 min(window ? -conveyor.upstream_length - (reservoir_cells + 2.0) * dx - late
                  : -conveyor_length(conveyor.velocity, setting.duration) - 2.0 * height,
           -0.5 * conveyor.width - 2.0 * dx, -2.0 * dx);
  Vec3 max(window ? conveyor.downstream_length + outlet_cells * dx : travel + 20.0 * height, 0.5 * conveyor.width + 2.0 * dx,
           5.0 * height + 4.0 * head + 5.0);
  if (setting.ground != nullptr) {
    min.z() += setting.ground->lowest();
    max.z() += setting.ground->highest();
  }
  return {min, max};
}

}  // namespace mpm
