#include "config_keys.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>

#include "mpm/impact/semi_empirical.hpp"
#include "mpm/io/config.hpp"

namespace mpm::config {

namespace {

// ---- which part of a draft a table fills -------------------------------------------------------------------------------------------
constexpr auto top = [](auto& d, std::size_t) -> auto& { return d.spec; };
constexpr auto material = [](auto& d, std::size_t) -> auto& { return d.spec.material; };
constexpr auto conveyor = [](auto& d, std::size_t) -> auto& { return *d.spec.conveyor; };
constexpr auto inflow = [](auto& d, std::size_t i) -> auto& { return d.spec.conveyor->inflow[i]; };
constexpr auto obstacle = [](auto& d, std::size_t) -> auto& { return *d.spec.obstacle; };
constexpr auto body = [](auto& d, std::size_t i) -> auto& { return d.spec.bodies[i]; };
constexpr auto wall = [](auto& d, std::size_t i) -> auto& { return d.spec.walls[i]; };
constexpr auto domain = [](auto& d, std::size_t) -> auto& { return d.spec.domain; };
constexpr auto numerics = [](auto& d, std::size_t) -> auto& { return d.spec.numerics; };
constexpr auto measurement = [](auto& d, std::size_t) -> auto& { return d.spec.measurement; };
constexpr auto output = [](auto& d, std::size_t) -> auto& { return d.spec.output; };
constexpr auto whole = [](auto& d, std::size_t) -> auto& { return d; };
constexpr auto segment = [](auto& d, std::size_t i) -> auto& { return d.segments[i]; };

// ---- bindings ----------------------------------------------------------------------------------------------------------------------
struct Binding {
  std::function<std::optional<Value>(const Draft&, std::size_t)> get;
  std::function<void(Draft&, std::size_t, const Value&)> set;
};

/// A member that is stored as it is written.
template <class Section, class Owner, class T>
Binding field(Section section, T Owner::*member) {
  return {[=](const Draft& d, std::size_t i) -> std::optional<Value> {
            const T& x = section(d, i).*member;
            if constexpr (std::is_same_v<T, int>) {
              return std::int64_t{x};
            } else if constexpr (requires { x.has_value(); }) {
              return x ? std::optional<Value>(*x) : std::nullopt;
            } else {
              return x;
            }
          },
          [=](Draft& d, std::size_t i, const Value& value) {
            T& x = section(d, i).*member;
            if constexpr (std::is_same_v<T, int>) {
              x = static_cast<int>(std::get<std::int64_t>(value));
            } else if constexpr (requires { x.has_value(); }) {
              x = std::get<typename T::value_type>(value);
            } else {
              x = std::get<T>(value);
            }
          }};
}

using Words = std::vector<std::string>;

/// An enumeration written as one of its words, in the order of the enumerators.
template <class Section, class Owner, class Enum>
Binding word(Section section, Enum Owner::*member, const Words& words) {
  return {[=](const Draft& d, std::size_t i) -> std::optional<Value> { return words.at(static_cast<std::size_t>(section(d, i).*member)); },
          [=](Draft& d, std::size_t i, const Value& value) {
            const auto at = std::find(words.begin(), words.end(), std::get<std::string>(value));
            section(d, i).*member = static_cast<Enum>(at - words.begin());
          }};
}

/// Leaves a key out of the written case while it has its default, so that cases which do not use it keep their hash.
Binding unless_default(const Binding& plain, const Value& preset) {
  return {[=](const Draft& d, std::size_t i) -> std::optional<Value> {
            const auto value = plain.get(d, i);
            return value == preset ? std::nullopt : value;
          },
          plain.set};
}

/// A key with one permitted value, which is stored nowhere.
Binding constant(const Value& only) {
  return {[=](const Draft&, std::size_t) -> std::optional<Value> { return only; }, [](Draft&, std::size_t, const Value&) {}};
}

/// An angle: degrees in the file, radians inside. Going back, the neighbour that returns to the same radians is taken.
template <class Section, class Owner, class T>
Binding angle(Section section, T Owner::*member) {
  constexpr double rad = std::numbers::pi / 180.0;
  return {[=](const Draft& d, std::size_t i) -> std::optional<Value> {
            const std::optional<double> exact = section(d, i).*member;
            if (!exact) return std::nullopt;
            const double degrees = *exact / rad;
            const double round = std::round(degrees * 1e9) / 1e9;  // as somebody would have written it
            for (const double candidate : {round, degrees, std::nextafter(degrees, -1e9), std::nextafter(degrees, 1e9)}) {
              if (candidate * rad == *exact) return candidate;
            }
            return degrees;
          },
          [=](Draft& d, std::size_t i, const Value& value) { section(d, i).*member = std::get<double>(value) * rad; }};
}

/// A wall's normal is stored with unit length; one that has it already keeps its bits.
Binding wall_normal() {
  Binding plain = field(wall, &WallSpec::normal);
  return {plain.get, [](Draft& d, std::size_t i, const Value& value) {
            const Vec3& n = std::get<Vec3>(value);
            constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();  // of normalising: a few ulp in the square
            const double length = n.stableNorm();
            d.spec.walls[i].normal = length == 0.0 || std::abs(n.squaredNorm() - 1.0) < rounding ? n : Vec3(n / length);
          }};
}

Binding mirror_axes() {
  return {[](const Draft& d, std::size_t) -> std::optional<Value> {
            Words axes;
            if (d.spec.domain.mirror_x) axes.emplace_back("x");
            if (d.spec.domain.mirror_y) axes.emplace_back("y");
            return axes;
          },
          [](Draft& d, std::size_t, const Value& value) {
            const auto& axes = std::get<Words>(value);
            d.spec.domain.mirror_x = std::count(axes.begin(), axes.end(), "x") > 0;
            d.spec.domain.mirror_y = std::count(axes.begin(), axes.end(), "y") > 0;
          }};
}

/// Speed of the belt: empty as long as nothing has set it.
Binding belt_speed() {
  return {[](const Draft& d, std::size_t) -> std::optional<Value> {
            return d.spec.conveyor->velocity > 0.0 ? std::optional<Value>(d.spec.conveyor->velocity) : std::nullopt;
          },
          [](Draft& d, std::size_t, const Value& value) { d.spec.conveyor->velocity = std::get<double>(value); }};
}

/// Width of the belt: the reader fills in W(xi) where the file leaves it out.
Binding belt_width() {
  return {[](const Draft& d, std::size_t) -> std::optional<Value> { return d.spec.conveyor->width; },
          [](Draft& d, std::size_t, const Value& value) {
            d.conveyor_width = std::get<double>(value);
            d.spec.conveyor->width = *d.conveyor_width;
          }};
}

// ---- conditions --------------------------------------------------------------------------------------------------------------------
const Condition always{"always", "", [](const Draft&, std::size_t) { return true; }};
const Condition by_hand{"no [conveyor]", "conveyor", [](const Draft& d, std::size_t) { return !d.spec.conveyor; }};
const Condition impact{"[conveyor] and [obstacle]", "conveyor",
                       [](const Draft& d, std::size_t) { return d.spec.conveyor.has_value() && d.spec.obstacle.has_value(); }};
const Condition window_feed{"feed = \"window\"", "conveyor.feed",
                            [](const Draft& d, std::size_t) { return d.spec.conveyor->feed == ConveyorSpec::Feed::window; }};
const Condition sheared_inflow{"inflow_slip_ratio below 1", "conveyor.inflow_slip_ratio",
                               [](const Draft& d, std::size_t) { return d.spec.conveyor->slip_ratio < 1.0; }};
const Condition coulomb_sidewall{"sidewall_contact = \"coulomb\"", "conveyor.sidewall_contact",
                                 [](const Draft& d, std::size_t) { return d.spec.conveyor->sidewall_contact == Contact::separable; }};
const Condition sliding_wall{"contact = \"slip\" or \"separable\"", "wall.contact",
                             [](const Draft& d, std::size_t i) { return d.spec.walls[i].contact != Contact::no_slip; }};
const Condition box_obstacle{"shape = \"box\"", "obstacle.shape",
                             [](const Draft& d, std::size_t) { return d.spec.obstacle->shape == ObstacleSpec::Shape::box; }};
const Condition deep_obstacle{"shape = \"box\" or \"wedge\"", "obstacle.shape",
                              [](const Draft& d, std::size_t) { return d.spec.obstacle->shape != ObstacleSpec::Shape::cylinder; }};
const Condition flip{"transfer = \"flip\"", "numerics.transfer",
                     [](const Draft& d, std::size_t) { return d.spec.numerics.transfer == Transfer::flip; }};

bool law_has(const MaterialSpec& law, const std::string& key) {
  const auto& models = schema_models();
  const auto model = std::find_if(models.begin(), models.end(), [&](const ModelInfo& m) { return m.name == law.model; });
  return model != models.end() && std::count(model->keys.begin(), model->keys.end(), key) > 0;
}

/// A key of [material] is used by the laws that list it.
Condition used_by_law(const std::string& name) {
  std::string text;
  for (const ModelInfo& model : schema_models()) {
    if (std::count(model.keys.begin(), model.keys.end(), name) == 0) continue;
    text += (text.empty() ? "model = \"" : " or \"") + model.name + "\"";
  }
  return {text, "material.model", [name](const Draft& d, std::size_t) { return law_has(d.spec.material, name); }};
}

// ---- ranges ------------------------------------------------------------------------------------------------------------------------
Range closed(double low, double high) { return {low, high, false, false}; }
/// Above 0 by a least value far below anything sensible: without it counts and quotients overflow.
Range positive(double high) { return closed(1e-9, high); }
Range below(double low, double high) { return {low, high, false, true}; }
// Wide enough for any laboratory or mountain, narrow enough that volumes, counts and energies stay far from overflow.
constexpr double longest = 1e5;  // m
constexpr double fastest = 1e3;  // m/s
const Range coordinate = closed(-longest, longest);
const Range speed = closed(-fastest, fastest);
const Range length = positive(longest);
const Range friction = closed(0.0, 10.0);

struct Rows {
  std::vector<Key> keys;
  std::string table;

  Key& add(std::string name, KeyType type, std::string unit, std::optional<Range> range, Binding binding, std::string description) {
    Key& key = keys.emplace_back();
    key.table = table;
    key.name = std::move(name);
    key.type = type;
    key.unit = std::move(unit);
    key.range = range;
    key.get = std::move(binding.get);
    key.set = std::move(binding.set);
    key.description = std::move(description);
    return key;
  }
};

/// A draft with one entry in every table: its values are the defaults.
Draft defaults() {
  Draft draft;
  for (const TableInfo& table : schema_tables()) add_entry(draft, table.name);
  return draft;
}

std::vector<Key> declare_keys() {
  using enum KeyType;
  const Words contacts{"no_slip", "slip", "separable"};
  const Words sidewalls{"no_slip", "slip", "coulomb"};
  const Words shapes{"box", "cylinder", "sphere"};
  const Words obstacles{"box", "cylinder", "wedge"};
  const Words feeds{"window", "strip"};
  const Words lattices{"staggered", "aligned"};
  const Words transfers{"apic", "flip"};
  const Words cones{"plane_strain", "triaxial_compression", "simple_shear"};
  constexpr double steepest = 89.0;  // deg
  Words models;
  for (const ModelInfo& model : schema_models()) models.push_back(model.name);

  Rows t;
  t.table = "";
  t.add("title", text, "", {}, field(top, &Case::title), "What the case is; stands above results and pictures");
  t.add("format_version", integer, "", {}, constant(std::int64_t{case_format_version}), "Version of the format of this file").choices = {
      std::to_string(case_format_version)};

  t.table = "material";
  t.add("model", choice, "", {}, field(material, &MaterialSpec::model), "Constitutive law").choices = models;
  t.add("density_kg_m3", number, "kg/m^3", closed(1.0, 1e5), field(material, &MaterialSpec::density), "Initial density rho_0");
  t.add("young_modulus_pa", number, "Pa", closed(1.0, 1e12), field(material, &MaterialSpec::young_modulus), "Young's modulus E");
  t.add("poisson_ratio", number, "", below(0.0, 0.5), field(material, &MaterialSpec::poisson_ratio), "Poisson's ratio nu");
  t.add("critical_state_slope", number, "", closed(0.0, 10.0), field(material, &MaterialSpec::critical_state_slope),
        "Slope M of the critical state line; 0 is an inviscid fluid");
  t.add("cohesion_beta", number, "", below(0.0, 1.0), field(material, &MaterialSpec::cohesion_beta),
        "Cohesion beta = tensile over compressive isotropic strength; at 1 the critical state would bear no pressure");
  t.add("hardening_xi", number, "", closed(2e-3, 1e3), field(material, &MaterialSpec::hardening_xi),
        "Hardening factor xi; large: hardly compressible");
  t.add("preconsolidation_pressure_pa", number, "Pa", closed(1e-3, 1e9), field(material, &MaterialSpec::preconsolidation_pressure),
        "Initial pre-consolidation pressure p_c0");
  t.add("cone_matching", choice, "", {}, word(material, &MaterialSpec::cone_matching, cones),
        "Test on which the cone agrees with the Mohr-Coulomb angles; simple_shear: tan(friction angle) = sqrt(J2)/p, as for mu(I)")
      .choices = cones;
  t.add("friction_angle_deg", number, "deg", positive(steepest), angle(material, &MaterialSpec::friction_angle), "Friction angle phi");
  t.add("cohesion_pa", number, "Pa", closed(0.0, 1e9), field(material, &MaterialSpec::cohesion), "Cohesion c");
  t.add("dilatancy_angle_deg", number, "deg", closed(0.0, steepest), angle(material, &MaterialSpec::dilatancy_angle),
        "Dilatancy angle psi, at most the friction angle; 0 shears at constant volume");
  const std::string rate_independent = "left out: no rate dependence";
  t.add("limit_friction_angle_deg", number, "deg", positive(steepest), angle(material, &MaterialSpec::limit_friction_angle),
        "mu(I): friction angle of infinitely fast shear, at least friction_angle_deg")
      .default_text = rate_independent;
  t.add("reference_inertial_number", number, "", positive(1e3), field(material, &MaterialSpec::reference_inertial_number),
        "mu(I): I_0, where half of the increase is reached")
      .default_text = rate_independent;
  t.add("grain_diameter_m", number, "m", positive(10.0), field(material, &MaterialSpec::grain_diameter), "mu(I): diameter d of grains")
      .default_text = rate_independent;
  t.add("grain_density_kg_m3", number, "kg/m^3", closed(1.0, 1e5), field(material, &MaterialSpec::grain_density),
        "mu(I): density rho_s of grains")
      .default_text = rate_independent;
  t.add("bulk_modulus_pa", number, "Pa", closed(1.0, 1e12), field(material, &MaterialSpec::bulk_modulus),
        "Bulk modulus K = density c^2; with a speed of sound c of ten times the fastest flow the density changes by about 1 %");
  t.add("tait_exponent", integer, "", closed(1.0, 20.0), field(material, &MaterialSpec::tait_exponent),
        "Exponent n of the equation of state p = K/n ((rho/rho_0)^n - 1); 1 is linear");
  t.add("viscosity_pa_s", number, "Pa s", closed(0.0, 1e9), field(material, &MaterialSpec::viscosity),
        "Dynamic viscosity; explicit: above density c cell_size / 2 it shortens the step to cfl density cell_size^2 / (2 viscosity)");
  t.add("carries_tension", boolean, "", {}, field(material, &MaterialSpec::carries_tension),
        "Whether pressure may be negative; if not, the fluid tears and recompacts before it carries pressure again");
  for (Key& key : t.keys) {
    if (key.table != "material" || key.name == "model" || key.name == "density_kg_m3") continue;
    key.used = used_by_law(key.name);
    if (key.name == "critical_state_slope" || key.name == "cohesion_beta" || key.name == "hardening_xi" ||
        key.name == "friction_angle_deg" || key.name == "bulk_modulus_pa") {
      key.required = key.used;
    }
  }

  t.table = "conveyor";
  t.add("froude_number", number, "", closed(1e-3, 1e2), field(whole, &Draft::froude_number),
        "Fr = v / sqrt(g H); gives the speed of the belt")
      .default_text = "left out: velocity_m_s is given instead (one of the two is required)";
  t.add("velocity_m_s", number, "m/s", positive(fastest), belt_speed(), "Speed v of the belt and of the incoming snow").default_text =
      "left out: froude_number is given instead (one of the two is required)";
  t.add("flow_height_m", number, "m", positive(1e3), field(conveyor, &ConveyorSpec::flow_height), "Height H of the incoming snow");
  t.add("width_m", number, "m", positive(1e4), belt_width(), "Width W of the belt, both halves").default_text =
      "left out: (6 + 3 log10(hardening_xi / 0.05)) times the obstacle's width; 12 times for a law without hardening_xi";
  t.add("feed", choice, "", {}, word(conveyor, &ConveyorSpec::feed, feeds),
        "window: a few metres around the obstacle, fresh snow enters at v; strip: the whole avalanche as particles")
      .choices = feeds;
  t.add("upstream_length_m", number, "m", positive(1e4), field(conveyor, &ConveyorSpec::upstream_length),
        "Inlet at x = -upstream_length_m; the obstacle's front face is x = 0")
      .used = window_feed;
  t.add("downstream_length_m", number, "m", positive(1e4), field(conveyor, &ConveyorSpec::downstream_length),
        "Outlet at x = +downstream_length_m")
      .used = window_feed;
  t.add("sidewall_contact", choice, "", {}, word(conveyor, &ConveyorSpec::sidewall_contact, sidewalls),
        "Moving side walls: no_slip drags the snow along, slip is frictionless, coulomb slides with sidewall_friction and may lift off")
      .choices = sidewalls;
  Key& sidewall_friction = t.add("sidewall_friction", number, "", friction, field(conveyor, &ConveyorSpec::sidewall_friction),
                                 "Coulomb coefficient of the side walls");
  sidewall_friction.used = sidewall_friction.required = coulomb_sidewall;
  t.add("lattice", choice, "", {}, word(conveyor, &ConveyorSpec::lattice, lattices),
        "How layers of particles follow one another: staggered shifts each across the flow and in height, so that no gaps open where the "
        "mast spreads the flow; aligned is the plain lattice, whose particles keep to the same lines")
      .choices = lattices;
  t.add("mirror_y", boolean, "", {}, field(conveyor, &ConveyorSpec::mirror_y), "Compute the half y >= 0 only; results are for the whole");

  Key& slip_ratio =
      t.add("inflow_slip_ratio", number, "", closed(0.0, 1.0), unless_default(field(conveyor, &ConveyorSpec::slip_ratio), 1.0),
            "Sheared inflow of depth mean v: u(z) = v (s + (1 - s)(1 + n)(z/H)^n) with s this ratio, u(0)/v, and n "
            "inflow_shear_exponent; below 1 with sidewall_contact = \"slip\"");
  slip_ratio.used = window_feed;
  slip_ratio.default_text = "1.0";
  Key& shear_exponent = t.add("inflow_shear_exponent", number, "", closed(0.1, 10.0),
                              unless_default(field(conveyor, &ConveyorSpec::shear_exponent), 1.0), "Exponent n of the sheared inflow");
  shear_exponent.used = sheared_inflow;
  shear_exponent.default_text = "1.0";

  t.table = "conveyor.inflow";
  t.add("time_s", number, "s", closed(0.0, 1e6), field(inflow, &InflowPoint::time), "Time of this row, above that of the row before")
      .required = always;
  t.add("velocity_m_s", number, "m/s", positive(fastest), field(inflow, &InflowPoint::velocity),
        "Speed of the incoming snow, of the belt and its side walls")
      .default_text = "left out: the conveyor's";
  t.add("flow_height_m", number, "m", positive(1e3), field(inflow, &InflowPoint::flow_height), "Height of the incoming snow").default_text =
      "left out: the conveyor's";
  t.add("density_ratio", number, "", closed(1.0, 2.0), field(inflow, &InflowPoint::density_ratio),
        "Density of the incoming snow over density_kg_m3: snow that was compacted, and so hardened, before it came. Above 1 with "
        "cohesive_cam_clay only");

  t.table = "obstacle";
  t.add(
       "shape", choice, "", {}, word(obstacle, &ObstacleSpec::shape, obstacles),
       "Rigid, upright, on the floor, its most upstream point at x = 0, its middle at y = 0. cylinder: vertical; wedge: isosceles triangle "
       "in plan, its edge against the flow")
      .choices = obstacles;
  t.add("width_m", number, "m", positive(1e4), field(obstacle, &ObstacleSpec::width),
        "Width w across the flow; diameter of a cylinder, base of a wedge");
  t.add("depth_m", number, "m", positive(1e4), field(obstacle, &ObstacleSpec::depth),
        "Depth along the flow; of a wedge from edge to base: half its angle is atan(width_m / (2 depth_m))")
      .used = deep_obstacle;
  Key& rotation = t.add("rotation_deg", number, "deg", closed(-90.0, 90.0), unless_default(angle(obstacle, &ObstacleSpec::rotation), 0.0),
                        "Turns the box about its vertical axis, counter-clockwise from above; unless it stays symmetric, with "
                        "mirror_y = false");
  rotation.used = box_obstacle;
  rotation.default_text = "0.0";
  t.add("height_m", number, "m", length, field(obstacle, &ObstacleSpec::height), "Height").default_text = "left out: taller than any jet";
  t.add("friction", number, "", friction, field(obstacle, &ObstacleSpec::friction), "Coulomb coefficient mu of snow on the obstacle");
  t.add("friction_ratio", number, "", closed(0.0, 1.0), field(whole, &Draft::friction_ratio),
        "Instead of friction: mu / tan(phi'), phi' the snow's own angle of friction (of Drucker-Prager, phi). What has no friction of its "
        "own, M = 0, then slides freely")
      .default_text = "left out: friction is used";

  t.table = "body";
  t.add("shape", choice, "", {}, word(body, &BodySpec::shape, shapes), "Cylinder (axis z) and sphere are inscribed in the box min_m..max_m")
      .choices = shapes;
  t.add("min_m", vector, "m", coordinate, field(body, &BodySpec::min), "Lower corner of the bounding box").required = always;
  t.add("max_m", vector, "m", coordinate, field(body, &BodySpec::max), "Upper corner of the bounding box").required = always;
  t.add("velocity_m_s", vector, "m/s", speed, field(body, &BodySpec::velocity), "Initial velocity");

  t.table = "wall";
  t.add("point_m", vector, "m", coordinate, field(wall, &WallSpec::point), "A point of the plane").required = always;
  t.add("normal", vector, "", closed(-1e6, 1e6), wall_normal(), "Normal of the plane, into the material; any length but zero").required =
      always;
  t.add("contact", choice, "", {}, word(wall, &WallSpec::contact, contacts),
        "no_slip: sticks; slip: stays on the plane and slides; separable: slides and may lift off")
      .choices = contacts;
  t.add("friction", number, "", friction, field(wall, &WallSpec::friction), "Coulomb coefficient mu").used = sliding_wall;
  t.add("velocity_m_s", vector, "m/s", speed, field(wall, &WallSpec::velocity), "Velocity of the wall");

  t.table = "domain";
  t.add("min_m", vector, "m", coordinate, field(domain, &DomainSpec::min), "Lower corner; particles that leave are removed and counted")
      .required = by_hand;
  t.add("max_m", vector, "m", coordinate, field(domain, &DomainSpec::max), "Upper corner; particles that leave are removed and counted")
      .required = by_hand;
  Key& mirror = t.add("mirror", axes, "", {}, mirror_axes(), "Symmetry planes through the origin: only x >= 0 (y >= 0) is computed");
  mirror.choices = {"x", "y"};
  mirror.used = by_hand;

  t.table = "numerics";
  t.add("cell_size_m", number, "m", closed(1e-4, 1e2), field(numerics, &NumericsSpec::cell_size), "Grid spacing dx");
  t.add("particles_per_cell", integer, "", {}, field(numerics, &NumericsSpec::particles_per_cell),
        "Particles of a full cell, a cube number")
      .choices = {"1", "8", "27", "64"};
  t.add("transfer", choice, "", {}, word(numerics, &NumericsSpec::transfer, transfers),
        "Velocities between grid and particles: affine (APIC), or a blend of PIC and FLIP")
      .choices = transfers;
  t.add("flip_ratio", number, "", closed(0.0, 1.0), field(numerics, &NumericsSpec::flip_ratio), "Share of FLIP in the blend; 0 is pure PIC")
      .used = flip;
  t.add("cfl", number, "", positive(1.0), field(numerics, &NumericsSpec::cfl), "Safety factor: dt = cfl dx / (c_P + largest speed)");
  t.add("gravity_m_s2", number, "m/s^2", closed(0.0, 1e3), field(numerics, &NumericsSpec::gravity), "Acceleration g of gravity");
  t.add("slope_deg", number, "deg", closed(-90.0, 90.0), angle(numerics, &NumericsSpec::slope),
        "Inclination: gravity acts along g (sin, 0, -cos)");
  t.add("grid_offset_cells", vector, "cells", closed(-1.0, 1.0), field(numerics, &NumericsSpec::grid_offset),
        "Shift of the whole scene against the grid; results do not move with it. 0 along an axis with a mirror plane");

  t.table = "measurement";
  t.add("bin_height_m", number, "m", length, field(measurement, &MeasurementSpec::bin_height), "Height of the pressure profile's bins")
      .default_text = "left out: cell_size_m / 2";
  t.add("filter_length_m", number, "m", length, field(measurement, &MeasurementSpec::filter_length),
        "Window of the Savitzky-Golay filter (degree 2) over the profile, an odd number of bins")
      .default_text = "left out: 13 bins";
  t.add("box_upstream_m", number, "m", length, field(measurement, &MeasurementSpec::box_upstream),
        "Depth of the measuring box before the obstacle's face")
      .default_text = "left out: 2.5 cell_size_m";
  t.add("box_inside_m", number, "m", closed(0.0, longest), field(measurement, &MeasurementSpec::box_inside),
        "Depth of the measuring box behind the face, for particles that stand slightly inside")
      .default_text = "left out: 0.5 cell_size_m";
  t.add("force_window_s", number, "s", positive(1e3),
        unless_default(field(measurement, &MeasurementSpec::force_window), MeasurementSpec{}.force_window),
        "Window of the moving mean over the force whose highest value is the filtered peak")
      .default_text = to_toml(MeasurementSpec{}.force_window);
  for (Key& key : t.keys) {
    if (key.table == "measurement") key.used = impact;
  }

  t.table = "output";
  t.add("duration_s", number, "s", positive(1e6), field(output, &OutputSpec::duration), "Simulated time").required = always;
  t.add("series_per_second", number, "1/s", positive(1e6), field(output, &OutputSpec::series_per_second),
        "Rows of series.csv per simulated second");
  t.add("frames_per_second", number, "1/s", closed(0.0, 1e4), field(output, &OutputSpec::frames_per_second),
        "Stored particle frames per simulated second; 0: none");
  t.add("checkpoint_minutes", number, "min", positive(1e5), field(output, &OutputSpec::checkpoint_minutes),
        "Wall-clock time between checkpoints");

  t.table = "path";
  t.add("steps_per_segment", integer, "", closed(1.0, 1e8), field(whole, &Draft::steps_per_segment),
        "Equal steps into which each segment is cut");

  t.table = "path.segments";
  const Range strain = closed(-10.0, 10.0);
  const std::string one_kind = "left out: the segment is given by other keys";
  t.add("d_eps_v", number, "", strain, field(segment, &SegmentDraft::d_eps_v),
        "Increment of volumetric Hencky strain, expansion positive (with d_eps_q; one of the two left out is 0)");
  t.add("d_eps_q", number, "", strain, field(segment, &SegmentDraft::d_eps_q),
        "Increment of deviatoric Hencky strain d_eps_q diag(1/2, 1/2, -1): axial shortening along z positive");
  t.add("velocity_gradient", matrix, "1/s", closed(-1e6, 1e6), field(segment, &SegmentDraft::velocity_gradient),
        "Constant velocity gradient l_ij = dv_i/dx_j by rows, over time_s");
  t.add("time_s", number, "s", positive(1e6), field(segment, &SegmentDraft::time), "Duration of a segment given by velocity_gradient");
  t.add("radial_stress_pa", number, "Pa", closed(-1e9, 1e9), field(segment, &SegmentDraft::radial_stress),
        "Kirchhoff stress held in x and y, compression positive (drained triaxial test, with d_eps_axial)");
  t.add("d_eps_axial", number, "", strain, field(segment, &SegmentDraft::d_eps_axial),
        "Increment of Hencky strain along z, extension positive");
  for (Key& key : t.keys) {
    if (key.table == "path.segments") key.default_text = one_kind;
  }

  const Draft draft = defaults();
  for (Key& key : t.keys) {
    if (key.used) key.used_when = key.used->text;
    if (key.required) key.required_when = key.required->text;
    const bool has_default = key.default_text.empty() && !(key.required && key.required->text == (key.used ? key.used->text : always.text));
    if (const auto value = has_default ? key.get(draft, 0) : std::nullopt) key.default_text = to_toml(*value);
  }
  return t.keys;
}

}  // namespace

const std::vector<Key>& keys() {
  static const std::vector<Key> table = declare_keys();
  return table;
}

void add_entry(Draft& draft, const std::string& table) {
  if (table == "conveyor") draft.spec.conveyor.emplace();
  if (table == "conveyor.inflow") draft.spec.conveyor->inflow.emplace_back();
  if (table == "obstacle") draft.spec.obstacle.emplace();
  if (table == "body") draft.spec.bodies.emplace_back();
  if (table == "wall") draft.spec.walls.emplace_back();
  if (table == "path.segments") draft.segments.emplace_back();
}

std::size_t entries(const Draft& draft, const std::string& table) {
  if (table == "conveyor") return draft.spec.conveyor ? 1 : 0;
  if (table == "conveyor.inflow") return draft.spec.conveyor ? draft.spec.conveyor->inflow.size() : 0;
  if (table == "obstacle") return draft.spec.obstacle ? 1 : 0;
  if (table == "body") return draft.spec.bodies.size();
  if (table == "wall") return draft.spec.walls.size();
  if (table == "path.segments") return draft.segments.size();
  return 1;
}

std::string key_path(const std::string& table_path, const std::string& name) { return table_path.empty() ? name : table_path + "." + name; }

double default_conveyor_width(const MaterialSpec& material, double obstacle_width) {
  return law_has(material, "hardening_xi") ? conveyor_width(material.hardening_xi, obstacle_width) : 12.0 * obstacle_width;
}

}  // namespace mpm::config

namespace mpm {

std::optional<double> internal_friction(const MaterialSpec& material) {
  if (config::law_has(material, "friction_angle_deg")) return std::tan(material.friction_angle);
  if (!config::law_has(material, "critical_state_slope")) return std::nullopt;
  constexpr double vertical = 3.0;  // M' at which phi' is 90 degrees
  const double friction = effective_friction(material.critical_state_slope, material.cohesion_beta);
  return friction < vertical ? std::tan(friction_angle(friction)) : std::numeric_limits<double>::infinity();
}

}  // namespace mpm
