#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/setup.hpp"

namespace mpm::validation::sliding_block {
namespace {

/// A block on a floor or slope.
struct Run {
  std::string id, title;
  double degrees, speed;  ///< of the slope; m/s, at the start
  double rest_time;       ///< s: friction is fully mobilised well before; the end on a slope
  double duration;        ///< s
};

Case block_case(const CaseContext& context) {
  Case c = context.read_case();
  c.numerics.cell_size = context.choose(0.125, 0.0625, 0.0625);
  return c;
}

std::vector<Run> runs(const Case& c) {
  const double v0 = c.bodies.front().velocity.x();
  return {{"thrown", "thrown along the floor", 0.0, v0, v0 / (c.walls.front().friction * c.numerics.gravity), c.output.duration},
          {"slope-30", "thrown down a slope of 30°", 30.0, 1.0, 0.4, 0.4},
          {"slope-10", "left on a slope of 10°", 10.0, 0.0, 0.4, 0.4}};
}

Setup setup_of(Case c, const Run& run) {
  c.bodies.front().velocity = Vec3(run.speed, 0.0, 0.0);
  c.numerics.slope = run.degrees * std::numbers::pi / 180.0;
  c.output.duration = run.duration;
  std::vector<double> times = even_times(0.0, run.rest_time, 50);
  if (run.duration > run.rest_time) std::ranges::copy(even_times(run.rest_time, run.duration, 20), std::back_inserter(times));
  return {.id = run.id, .title = run.title, .spec = std::move(c), .times = std::move(times), .forces = true};
}

std::vector<Setup> setups(const CaseContext& context) {
  const Case c = block_case(context);
  std::vector<Setup> all;
  for (const Run& run : runs(c)) all.push_back(setup_of(c, run));
  return all;
}

/// What one block did.
struct Slide {
  std::vector<double> time{0.0}, distance{0.0};  ///< s, m; of the centre of mass, along the floor
  double speed = 0.0;                            ///< m/s, mean along the floor, at the end
  double rise = 0.0;                             ///< m; of the centre of mass, while the block slides
  double friction_error = 0.0;                   ///< largest |F_x / (mu F_z) - 1| between two instants while all of the block slides
  std::size_t particles = 0;
};

Slide slide(const CaseContext& context, const Run& run, const Setup& setup, CaseResult& result) {
  const double mu = setup.spec.walls.front().friction;
  const BodySpec& body = setup.spec.bodies.front();
  const Vec3 start = 0.5 * (body.min + body.max);
  Slide s;
  play(context, setup, [&](const Instant& now) {
    const MassCentre centre = mass_centre(now.particles);
    const Vec3& force = now.forces.front();
    s.time.push_back(now.time);
    s.distance.push_back(centre.position.x() - start.x());
    s.speed = centre.velocity.x();
    s.particles = now.particles.size();
    if (now.time < run.rest_time * (1.0 + 1e-12)) s.rise = centre.position.z() - start.z();
    if (now.time < 0.9 * run.rest_time && !(force.z() >= 0.0))
      s.friction_error = larger(s.friction_error, std::abs(force.x() / (-mu * force.z()) - 1.0));
    if (now.state != nullptr && run.id == "thrown" && now.index + 1 == setup.times.size()) {
      result.flows.push_back(flow_picture(context.directory(), *now.state, *now.scene,
                                          {.id = "rest",
                                           .field = FlowField::pressure,
                                           .title = "Block at rest",
                                           .caption = "The stop left it vibrating: nothing damps it.",
                                           .slice_half_width = 0.0}));
    }
    return true;
  });
  return s;
}

/// A face of an obstacle, and the way along it.
struct Face {
  std::string name;
  Vec3 normal, along;      ///< unit; out of the face, and the direction in which the block is thrown
  double rotation = 0.0;   ///< of the box about its vertical axis, rad
  double off_nodes = 0.0;  ///< cells, by which the face is off the planes of nodes
  ContactRule rule = ContactRule::surface;
};

/// The block of `base` thrown along a face of a box, with gravity into that face.
struct FaceSlide {
  double distance = 0.0, rise = 0.0;  ///< m; of the centre of mass, until rest; away from the face while it slides
  double friction_error = 0.0;        ///< largest |J_t / (mu J_n) - 1| of a step while all of the block slides
  double mean_friction = 0.0;         ///< sum of J_t over mu times the sum of J_n, in the same time
  double speed = 0.0;                 ///< m/s, at the end
  double largest_step = 0.0;          ///< s
  double turned = 0.0;                ///< m/s, largest speed across both directions: the box's rows and corners push nothing aside
};
FaceSlide slide_on_face(const Case& base, const Face& face, double rest_time) {
  constexpr double width = 4.0;  // m, of a square box: the block stays well away from its edges
  Case c = base;
  const double dx = c.numerics.cell_size, mu = base.walls.front().friction, g = base.numerics.gravity;
  const bool top = face.normal.z() > 0.5;
  c.walls.clear();
  c.obstacle = ObstacleSpec{};
  BoxShape box;
  box.width = box.depth = width + (top ? 0.0 : 2.0 * face.off_nodes * dx);
  box.rotation = face.rotation;
  c.obstacle->shape = box;
  if (top) c.obstacle->height = 1.0 + face.off_nodes * dx;
  c.obstacle->friction = mu;
  c.numerics.contact = face.rule;
  c.domain.min = Vec3(-4.0, -6.0, -6.0);
  c.domain.max = Vec3(12.0, 6.0, 6.0);
  // a block of the same size anywhere in free space, carried to its place afterwards, turned with the face
  const Vec3 size = c.bodies[0].max - c.bodies[0].min;
  c.bodies[0].min = Vec3(-2.0, -3.0, 2.0);
  c.bodies[0].max = c.bodies[0].min + size;
  c.bodies[0].velocity.setZero();
  CaseScene scene = make_scene(c);
  scene.gravity = -g * face.normal;
  const State lattice = make_state(c, scene);
  const double reach = 0.5 * box.width * (std::abs(std::cos(face.rotation)) + std::abs(std::sin(face.rotation)));
  const Vec3 middle = Vec3(reach, 0.0, top ? *c.obstacle->height : 1.0) + (top ? 0.0 : 0.5 * box.width) * face.normal;
  const Vec3 centre = middle + 0.5 * size.z() * face.normal - 0.5 * face.along;
  Mat3 turn;
  turn.col(0) = face.along;
  turn.col(1) = face.normal.cross(face.along);
  turn.col(2) = face.normal;
  const Vec3 velocity = base.bodies.front().velocity.x() * face.along;
  State state(dx, c.numerics.precision);
  state.next_id = lattice.next_id;
  lattice.grid.for_each_particle([&](Particle p) {
    const Vec3 at = centre + turn * (Vec3(p.position[0], p.position[1], p.position[2]) - c.bodies[0].min - 0.5 * size);
    for (int i = 0; i < 3; ++i) p.position[i] = at[i], p.velocity[i] = velocity[i];
    state.grid.insert(p);
  });
  state.grid.refresh();
  state.max_speed = velocity.norm();

  FaceSlide s;
  double pushed = 0.0, dragged = 0.0;
  const Vec3 across = turn.col(1);
  advance(state, scene, base.output.duration, [&](const StepReport& step) {
    const Totals now = totals(state, scene);
    const Vec3 v = now.momentum / now.mass;
    if (state.time <= rest_time) s.rise += step.dt * v.dot(face.normal);
    s.distance += step.dt * v.dot(face.along);
    s.speed = v.dot(face.along);
    s.turned = larger(s.turned, std::abs(v.dot(across)));
    s.largest_step = larger(s.largest_step, step.dt);
    const Vec3& impulse = step.impulses[*scene.obstacle].linear;
    const double normal = -impulse.dot(face.normal), drag = impulse.dot(face.along);
    if (state.time >= 0.9 * rest_time || normal <= 0.0) return;
    s.friction_error = larger(s.friction_error, std::abs(drag / (mu * normal) - 1.0));
    pushed += normal, dragged += drag;
  });
  s.mean_friction = dragged / (mu * pushed);
  return s;
}

/// Friction of the obstacle: its top, its sides, and sides at an angle to the grid.
void on_obstacle(const CaseContext& context, CaseResult& result, const Case& base, double rest_time, double rest_distance,
                 double ratio_bound) {
  const double turned = std::numbers::pi / 6.0;
  const Vec3 oblique_normal(-std::sin(turned), std::cos(turned), 0.0), oblique(std::cos(turned), std::sin(turned), 0.0);
  std::vector<Face> faces = {
      {"top of a box, off the nodes", Vec3::UnitZ(), Vec3::UnitX(), 0.0, 0.4, ContactRule::surface},
      {"side of a box, off the nodes", Vec3::UnitY(), Vec3::UnitX(), 0.0, 0.4, ContactRule::surface},
      {"side of a box, upwards", Vec3::UnitY(), Vec3::UnitZ(), 0.0, 0.0, ContactRule::surface},
      {"side at 30° to the grid", oblique_normal, oblique, turned, 0.0, ContactRule::surface},
      {"top of a box, contact on nodes", Vec3::UnitZ(), Vec3::UnitX(), 0.0, 0.0, ContactRule::nodal},
      {"side of a box, contact on nodes", Vec3::UnitY(), Vec3::UnitX(), 0.0, 0.0, ContactRule::nodal},
  };
  if (context.level() != Level::quick) {
    faces.push_back({"top of a box", Vec3::UnitZ(), Vec3::UnitX(), 0.0, 0.0, ContactRule::surface});
    faces.push_back({"side of a box", Vec3::UnitY(), Vec3::UnitX(), 0.0, 0.0, ContactRule::surface});
    faces.push_back({"front of a box", -Vec3::UnitX(), Vec3::UnitY(), 0.0, 0.0, ContactRule::surface});
    faces.push_back({"side at 30° to the grid, upwards", oblique_normal, Vec3::UnitZ(), turned, 0.0, ContactRule::surface});
  }
  std::vector<FaceSlide> all(faces.size());
  in_parallel(faces.size(), [&](std::size_t i) { all[i] = slide_on_face(base, faces[i], rest_time); });
  const double mu = base.walls.front().friction, v0 = base.bodies.front().velocity.x();
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const FaceSlide& s = all[i];
    const std::string& name = faces[i].name;
    result.check_relative(Label::verification, name + ": distance to rest, + μ times the rise", s.distance + mu * s.rise, rest_distance,
                          "m", v0 * s.largest_step / rest_distance, "one step of motion (symplectic Euler)");
    result.check_at_most(Label::verification, name + ": friction over μ times normal force in a step, largest deviation from 1",
                         s.friction_error, ratio_bound, "", 0.0,
                         "as on the floor: second order in the angle at which vibration turns the sliding direction");
    result.notes.push_back(
        fmt::format("{}: distance {:.4f} of v₀²/(2μg), rise {:.2f} mm; friction over μ times normal force: mean {:.5f}, largest "
                    "deviation of a step {:.1e}; speed across {:.1e} m/s.",
                    name, s.distance / rest_distance, 1e3 * s.rise, s.mean_friction, s.friction_error, s.turned));
  }
  context.log("faces of an obstacle");
}

void run(const CaseContext& context, CaseResult& result) {
  const Case c = block_case(context);
  const double mu = c.walls.front().friction, g = c.numerics.gravity, v0 = c.bodies.front().velocity.x(), height = 0.5;
  // Bound of what the block sinks under its weight, the first bounce included.
  const double sinking = c.material.density() * g * height * height / c.material.as<HenckyElastic>().young_modulus;
  const double shear_speed = std::sqrt(0.5 * c.material.as<HenckyElastic>().young_modulus /
                                       (1.0 + c.material.as<HenckyElastic>().poisson_ratio) / c.material.density());

  const double stop_time = v0 / (mu * g), stop_distance = 0.5 * v0 * stop_time;
  const double time_step = stable_time_step(make_material(c.material), c.numerics.cfl, c.numerics.cell_size, 0.0);
  const std::vector<Run> blocks = runs(c);
  const Slide thrown = slide(context, blocks[0], setup_of(c, blocks[0]), result);
  result
      .check_relative(Label::verification, "thrown: distance to rest, + μ times the rise of the block",
                      thrown.distance.back() + mu * thrown.rise, stop_distance, "m", v0 * time_step / stop_distance,
                      "one step of motion (symplectic Euler)")
      .in_summary(Quantity::run_out);
  result.check_at_most(Label::verification, "thrown: friction over μ times normal force, largest deviation from 1", thrown.friction_error,
                       std::pow(0.5 * height * std::sqrt(sinking / height * g / height) / (0.1 * v0), 2) + 1e-9, "", 0.0,
                       "nodes slip sideways by the block's own vibration: second order in its angle; round-off of sums");
  result.check_absolute(Label::verification, "thrown: speed at the end", thrown.speed, 0.0, "m/s", mu * g * height / shear_speed,
                        "the shear that friction had built up is released, and nothing damps it: Δτ = ρ c_S Δv");

  const Series exact = reference_curve("v₀t - μgt²/2", 0.0, 0.7, 70, [&](double time) {
    const double t = std::min(time, stop_time);
    return v0 * t - 0.5 * mu * g * t * t;
  });
  result.plots.push_back({.id = "distance",
                          .title = "Block thrown along a floor",
                          .x_label = "time [s]",
                          .y_label = "distance [m]",
                          .series = {exact, {"simulation", thrown.time, thrown.distance, Series::Style::simulation}},
                          .caption = fmt::format("μ = {}, v₀ = {} m/s.", mu, v0)});

  if (own_run(context)) {
    const double ratio_bound = std::pow(0.5 * height * std::sqrt(sinking / height * g / height) / (0.1 * v0), 2) + 1e-9;
    Case coarse = c;
    coarse.numerics.cell_size = 0.125;
    on_obstacle(context, result, coarse, stop_time, stop_distance, ratio_bound);
  }

  for (const Run& slope : {blocks[1], blocks[2]}) {
    const double angle = slope.degrees * std::numbers::pi / 180.0, duration = slope.duration;
    const Slide s = slide(context, slope, setup_of(c, slope), result);
    if (mu < std::tan(angle)) {
      const double acceleration = g * (std::sin(angle) - mu * std::cos(angle));
      result
          .check_absolute(Label::verification, fmt::format("{}: distance after {} s, + μ times the rise", slope.title, duration),
                          s.distance.back() + mu * s.rise, slope.speed * duration + 0.5 * acceleration * duration * duration, "m",
                          acceleration * duration * time_step, "one step of motion (symplectic Euler)")
          .in_summary(Quantity::run_out);
    } else {
      result.check_absolute(Label::verification, fmt::format("{}, where it holds: distance after {} s", slope.title, duration),
                            s.distance.back(), 0.0, "m", 2.0 * (1.0 + mu) * sinking,
                            "sinking and shearing under its own weight, doubled by the first bounce");
    }
  }
  result.notes.push_back(
      fmt::format("dx = {} m, {} particles, steps of {:.2g} s. While it slid the thrown block rose by {:.2g} mm, {:.2g} % of a cell: "
                  "contact holds back what "
                  "moves towards the floor, but pulls nothing back that has hopped. Its path became {:.2g} mm longer than v₀²/(2 μ g) by "
                  "this and by the time step.",
                  c.numerics.cell_size, thrown.particles, time_step, 1e3 * thrown.rise, 100.0 * thrown.rise / c.numerics.cell_size,
                  1e3 * (thrown.distance.back() - stop_distance)));
}

const Registration registered{{.title = "Sliding block with Coulomb friction", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::sliding_block
