#include "mpm/impact/conveyor.hpp"

#include <fmt/format.h>

#include <cmath>

#include "mpm/error.hpp"
#include "mpm/impact/semi_empirical.hpp"
#include "mpm/scene.hpp"
#include "mpm/stress.hpp"

namespace mpm {

namespace {

constexpr double reservoir_cells = 2.0;  ///< snow kept behind the inlet: the support of a node on the inlet is 3/2 cells
constexpr double outlet_cells = 2.0;
constexpr int staggered_levels = 16;                       ///< of a particle within its share of the flow height
constexpr double plastic_number = 1.32471795724474602596;  ///< the real root of g^3 = g + 1

double fraction(double x) { return x - std::floor(x); }

MaterialState<double> compressed(const AnyMaterial& material, MaterialState<double> state, double dl_zz) {
  Matrix3<double> dl{};
  dl.m[2][2] = dl_zz;
  std::visit([&](const auto& law) { law.update_stress(state, dl, 1.0); }, material);
  return state;
}

}  // namespace

std::vector<ColumnPoint> settled_column(const AnyMaterial& material, double weight, double height, int count) {
  std::vector<ColumnPoint> column(static_cast<std::size_t>(count));
  MaterialState<double> state{{}, initial_internal_of(material)};
  const double layer = height / count;
  for (int j = count - 1; j >= 0; --j) {
    const double target = -weight * (height - (j + 0.5) * layer);  // Cauchy sigma_zz
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
    for (int i = 0; i < 80; ++i) {
      const double middle = 0.5 * (loose + tight);
      (excess(middle) > 0.0 ? loose : tight) = middle;
    }
    if (target < 0.0) state = compressed(material, state, tight);
    column[static_cast<std::size_t>(j)].state = state;
  }
  double below = 0.0;
  for (auto& point : column) {
    const double thickness = layer * volume_ratio(material, point.state);
    point.height = below + 0.5 * thickness;
    below += thickness;
  }
  return column;
}

ConveyorFeed::ConveyorFeed(const Case& c, const AnyMaterial& material) {
  const ConveyorSpec& conveyor = *c.conveyor;
  const double dx = c.numerics.cell_size;
  spacing_ = lattice_spacing(c.numerics);
  velocity_ = conveyor.velocity;
  density_ = c.material.density;
  offset_ = dx * c.numerics.grid_offset;
  endless_ = conveyor.feed == ConveyorSpec::Feed::window;
  const double length = endless_ ? conveyor.upstream_length + reservoir_cells * dx : conveyor_length(conveyor.velocity, c.output.duration);
  release_at_ = -length;
  initial_layers_ = static_cast<std::uint64_t>(std::max(0.0, std::floor(length / spacing_ + 0.5)));

  const int layers_z = std::max(1, static_cast<int>(std::lround(conveyor.flow_height / spacing_)));
  const int half_count = std::max(1, static_cast<int>(std::lround(0.5 * conveyor.width / spacing_)));
  spacing_y_ = 0.5 * conveyor.width / half_count;
  const double gravity_z = c.numerics.gravity * std::cos(c.numerics.slope);
  const int levels = conveyor.lattice == ConveyorSpec::Lattice::staggered ? staggered_levels : 1;
  const auto column = settled_column(material, c.material.density * gravity_z, conveyor.flow_height, layers_z * levels);
  for (int level = 0; level < levels; ++level) {
    std::vector<Particle> layer;
    double elastic_energy = 0.0;
    for (int k = 0; k < layers_z; ++k) {
      const ColumnPoint& point = column[static_cast<std::size_t>(k * levels + level)];
      for (int j = conveyor.mirror_y ? 0 : -half_count; j < half_count; ++j) {
        Particle p{};
        p.position[1] = (j + 0.5) * spacing_y_;
        p.position[2] = point.height;
        p.volume = spacing_ * spacing_y_ * conveyor.flow_height / layers_z;
        p.velocity[0] = velocity_;
        const Sym3<double>& s = point.state.stress;
        const double stress[6] = {s.xx, s.yy, s.zz, s.xy, s.xz, s.yz};
        std::copy(std::begin(stress), std::end(stress), p.stress);
        p.internal = point.state.internal;
        layer.push_back(p);
        elastic_energy += stored_energy(material, p);
      }
    }
    layers_.push_back(std::move(layer));
    elastic_energy_.push_back(elastic_energy);
  }
}

void ConveyorFeed::insert_layer(State& state, Passage& passage) const {
  const double n = static_cast<double>(state.fed_layers);
  const double x = -(n + 0.5) * spacing_ + velocity_ * state.time;
  const bool staggered = layers_.size() > 1;
  const double shift_y = staggered ? spacing_y_ * (fraction(0.5 + n / plastic_number) - 0.5) : 0.0;
  const auto level = static_cast<std::size_t>(
      staggered ? static_cast<double>(layers_.size()) * fraction(0.5 + n / (plastic_number * plastic_number)) : 0.0);
  for (Particle p : layers_[level]) {
    p.position[0] = x;
    p.position[1] += p.position[1] > 0.0 ? shift_y : -shift_y;  // the halves stay mirror images of each other
    for (int i = 0; i < 3; ++i) p.position[i] += offset_[i];
    p.id = state.next_id++;
    state.grid.insert(p);
    const double mass = density_ * p.volume;
    const Vec3 velocity(p.velocity[0], p.velocity[1], p.velocity[2]);
    passage += Passage{1, 0, mass, mass * velocity, 0.5 * mass * velocity.squaredNorm()};
  }
  passage.energy += elastic_energy_[level];
  ++state.fed_layers;
}

void ConveyorFeed::fill(State& state) const {
  Passage unused;
  while (state.fed_layers < initial_layers_) insert_layer(state, unused);
  state.max_speed = velocity_;
}

Passage ConveyorFeed::release(State& state) const {
  Passage passage;
  if (!endless_) return passage;
  while (-(static_cast<double>(state.fed_layers) + 0.5) * spacing_ + velocity_ * state.time >= release_at_) insert_layer(state, passage);
  if (passage.count > 0) state.grid.refresh();
  return passage;
}

std::vector<Boundary> conveyor_walls(const ConveyorSpec& conveyor) {
  const Vec3 belt(conveyor.velocity, 0.0, 0.0);
  std::vector<Boundary> walls;
  walls.emplace_back(Wall{Vec3::Zero(), Vec3::UnitZ(), Contact::separable, 0.0, Vec3::Zero(), false});
  const double half = 0.5 * conveyor.width;
  walls.emplace_back(Wall{Vec3(0, half, 0), -Vec3::UnitY(), conveyor.sidewall_contact, conveyor.sidewall_friction, belt, false});
  if (!conveyor.mirror_y)
    walls.emplace_back(Wall{Vec3(0, -half, 0), Vec3::UnitY(), conveyor.sidewall_contact, conveyor.sidewall_friction, belt, false});
  if (conveyor.feed == ConveyorSpec::Feed::window) {
    walls.emplace_back(Wall{Vec3(-conveyor.upstream_length, 0, 0), Vec3::UnitX(), Contact::slip, 0.0, belt, false});
    walls.emplace_back(Wall{Vec3(conveyor.downstream_length, 0, 0), -Vec3::UnitX(), Contact::separable, 0.0, belt, false});
  }
  return walls;
}

void conveyor_domain(const Case& c, Vec3& min, Vec3& max) {
  const ConveyorSpec& conveyor = *c.conveyor;
  const double dx = c.numerics.cell_size;
  const double head = 0.5 * conveyor.velocity * conveyor.velocity / std::max(c.numerics.gravity, 1e-3);
  const double height = conveyor.flow_height;
  const bool window = conveyor.feed == ConveyorSpec::Feed::window;
  const double travel = conveyor.velocity * c.output.duration;
  min = Vec3(window ? -conveyor.upstream_length - (reservoir_cells + 2.0) * dx
                    : -conveyor_length(conveyor.velocity, c.output.duration) - 2.0 * height,
             -0.5 * conveyor.width - 2.0 * dx, -2.0 * dx);
  max = Vec3(window ? conveyor.downstream_length + outlet_cells * dx : travel + 20.0 * height, 0.5 * conveyor.width + 2.0 * dx,
             5.0 * height + 4.0 * head + 5.0);
}

}  // namespace mpm
