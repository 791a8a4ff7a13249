#pragma once
/// Small cases with every feature that acts across blocks, for tests that compare bits.

#include <ostream>
#include <utility>
#include <vector>

#include "support/ground.hpp"
#include "support/solver_states.hpp"

namespace mpm::testing {

struct NamedCase {
  const char* name;
  Case c;
  friend void PrintTo(const NamedCase& n, std::ostream* out) { *out << n.name; }
};

/// A body of some hundred to a thousand particles on a floor with friction, dx = 0.25 m.
inline Case body_on_floor(BodySpec::Shape shape, const Vec3& velocity) {
  Case c = empty_case();
  BodySpec body = box_body({-1.0, -1.0, 0.05}, {1.0, 1.0, 1.55}, velocity);
  body.shape = shape;
  c.bodies = {body};
  c.walls = {wall(Vec3::Zero(), Vec3::UnitZ(), Contact::separable, 0.4)};
  return c;
}

/// Transfers, laws, feeds, contact of both rules, both precisions, mirror planes, travelling walls, particles that leave.
inline std::vector<NamedCase> repeatable_cases() {
  std::vector<NamedCase> all = {{"avalanche_apic", small_avalanche(6.0)}, {"avalanche_flip_cohesion", small_avalanche(6.0)}};
  all[1].c.material = cam_clay_snow(0.8, 0.3);
  all[1].c.numerics.transfer = Transfer::flip;
  all.push_back({"bodies_and_walls", body_on_floor(BodySpec::Shape::cylinder, {3.0, 1.0, -4.0})});
  Case& bodies = all.back().c;
  bodies.bodies.push_back(box_body({1.0, -0.5, 0.5}, {2.0, 0.5, 1.0}, {-5.0, 0.0, 0.0}));  // they meet
  WallSpec piston = wall({-1.0, 0.0, 0.0}, {1.0, 0.2, 0.0}, Contact::slip);
  piston.velocity = Vec3(2.0, 0.0, 0.0);
  bodies.walls.push_back(piston);
  bodies.domain.max = Vec3(1.8, 5.0, 5.0);  // some leave
  all.push_back({"mirrored_sand", body_on_floor(BodySpec::Shape::cylinder, Vec3::Zero())});
  all.back().c.material = DruckerPrager::Parameters{};
  all.back().c.domain.mirror_x = all.back().c.domain.mirror_y = true;
  all.push_back({"mirrored_viscous_fluid", body_on_floor(BodySpec::Shape::box, Vec3::Zero())});
  all.back().c.material = WeaklyCompressibleFluid::Parameters{.viscosity = 50.0};
  all.back().c.domain.mirror_y = true;
  all.push_back({"avalanche_aflip_at_surfaces", small_avalanche(6.0)});
  all.push_back({"whole_avalanche_aflip_at_a_cylinder", small_avalanche(6.0)});
  all.back().c.conveyor->mirror_y = false;
  all.back().c.conveyor->width = 14.0;  // wider than the blocks that a round mast joins
  all.back().c.obstacle->shape = CylinderShape{.width = 0.8};
  all.back().c.obstacle->height = 0.6;  // of the flow's 1 m
  all.back().c.obstacle->base = 0.2;
  for (std::size_t n = all.size() - 2; n < all.size(); ++n) {
    Case& c = all[n].c;
    c.numerics.transfer = Transfer::aflip;
    c.numerics.contact = ContactRule::surface;
    c.conveyor->upstream_length = 0.5;  // it is at the obstacle soon
    c.obstacle->friction = 0.3;
  }
  all.push_back({"bodies_aflip_at_surfaces", all[2].c});
  all.back().c.numerics.transfer = Transfer::aflip;
  all.back().c.numerics.contact = ContactRule::surface;
  all.back().c.walls[1].normal = Vec3::UnitX();  // a piston along the grid
  for (const auto& [name, of] : {std::pair{"avalanche_in_single_precision", 5}, std::pair{"cohesion_flip_in_single_precision", 1},
                                 std::pair{"sand_in_single_precision", 3}}) {
    all.push_back({name, all[static_cast<std::size_t>(of)].c});
    all.back().c.numerics.precision = Precision::single_precision;
  }
  all.push_back({"avalanche_on_uneven_ground", all[6].c});
  all.back().c.conveyor->sidewall_contact = Contact::slip;
  all.back().c.terrain =
      ground_spec([](double x, double y) { return 1.2 * std::sin(0.3 * x) * std::cos(0.4 * y); }, 9.0, 0.75);  // over several blocks
  all.back().c.terrain->friction = 0.2;
  for (NamedCase& n : all) {
    n.c.output.series_per_second = 50.0;
    n.c.output.frames_per_second = 0.0;
    n.c.output.duration = 0.06;
  }
  return all;
}

/// The same, and features that matter only for owners of blocks.
inline std::vector<NamedCase> rank_cases() {
  std::vector<NamedCase> all = repeatable_cases();
  all.push_back({"strip_at_surfaces", all[5].c});
  all.back().c.conveyor->feed = ConveyorSpec::Feed::strip;
  all.push_back({"piston_through_blocks", all.back().c});
  Case& c = all.back().c;  // its columns of nodes pass from block to block
  c = body_on_floor(BodySpec::Shape::box, {0.0, 0.0, 0.0});
  c.numerics.transfer = Transfer::aflip;
  c.numerics.contact = ContactRule::surface;
  c.walls.push_back(wall({-1.5, 0.0, 0.0}, Vec3::UnitX(), Contact::separable));
  c.walls.back().velocity = Vec3(25.0, 0.0, 0.0);
  c.output = all[0].c.output;
  all.push_back({"mast_with_an_arm", all[6].c});
  all.back().c.obstacle = ObstacleSpec{.shape = BoxShape{.width = 0.5, .depth = 0.8}};
  all.back().c.arm = ArmSpec{.length = 3.0, .depth = 0.6, .base = 0.3, .height = 0.9};  // over several blocks, in the flow of 1 m
  all.push_back({"random_particles_shifted_against_the_grid", all[6].c});
  all.back().c.numerics.grid_offset = Vec3(0.3, 0.4, 0.45);
  all.back().c.conveyor->lattice = Lattice::random;
  return all;
}

}  // namespace mpm::testing
