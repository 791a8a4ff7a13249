#include "libmpm/core/folded_wall.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <utility>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/grid_update.hpp"
#include "support/node_field.hpp"

namespace mpm {
namespace {

using testing::find_node;
using testing::for_each_node;
using testing::grid_of_blocks;
using testing::node_of;
using testing::random_node;
using testing::velocity_of;

constexpr double dx = 0.25;
constexpr double round_off = 1e-14;  ///< relative: sums of three nodes, each term with some roundings of 1.1e-16
const Index3 low = {-2, -2, -2}, high = {1, 1, 1};

/// A wall normal to an axis, `cells` from the origin: the material is at larger coordinates where `sign` is +1.
Wall wall_at(int axis, double sign, double cells, Contact contact, double friction = 0.0, const Vec3& velocity = Vec3::Zero()) {
  Vec3 point(0.1, -0.2, 0.3);
  point[axis] = dx * cells;
  return {point, sign * Vec3::Unit(axis), contact, friction, velocity, false, ContactRule::surface};
}

/// Nodes from their numbers; those more than `behind` cells behind the wall are empty.
template <class F>
Grid filled(const Wall& wall, F&& f, double behind = 1.5 + 1e-9) {
  Grid grid = grid_of_blocks(dx, low, high);
  for_each_node(grid, [&](Node& n, const Index3& at) {
    n = f(at);
    if ((dx * Vec3(at[0], at[1], at[2]) - wall.point).dot(wall.normal) < -behind * dx) n = Node{};
  });
  return grid;
}
Grid random_grid(const Wall& wall, unsigned seed = 1) {
  return filled(wall, [&](const Index3& at) { return random_node(at, seed); });
}

Impulse fold(Grid& grid, const Wall& wall, const MirrorPlanes& mirror = {}, double time = 0.0) {
  Impulse total;
  for (const Impulse& taken : apply_folded_wall(grid, wall, mirror, time, grid.own_blocks())) total += taken;
  return total;
}

/// What each column of nodes along the wall's normal gave to the wall, and its kinetic energy relative to the surface.
struct Column {
  Vec3 given = Vec3::Zero();
  double before = 0.0, after = 0.0, scale = 0.0;
};
std::map<std::pair<int, int>, Column> columns(Grid& before, Grid& after, int axis, const Vec3& surface = Vec3::Zero()) {
  std::map<std::pair<int, int>, Column> all;
  for_each_node(before, [&](Node& n, const Index3& at) {
    const Node& m = *find_node(after, at);
    const auto a = static_cast<std::size_t>((axis + 1) % 3), b = static_cast<std::size_t>((axis + 2) % 3);
    Column& column = all[{at[a], at[b]}];
    column.given += n[3] * (velocity_of(n) - velocity_of(m));
    column.before += 0.5 * n[3] * (velocity_of(n) - surface).squaredNorm();
    column.after += 0.5 * n[3] * (velocity_of(m) - surface).squaredNorm();
    column.scale += n[3] * velocity_of(n).norm();
  });
  return all;
}

/// Of the plane, in cells: on nodes, midway, on both sides of that, and between.
constexpr double places[] = {0.0, 0.1, 0.47, 0.5, 0.53, 0.625, 0.999, -3.25};
const Contact kinds[] = {Contact::no_slip, Contact::slip, Contact::separable};

// --- the plane and its neighbours ---------------------------------------------------------------------------------------

/// A mirror plane is an implementation of its own: core/mirror.hpp.
TEST(FoldedWall, OnAPlaneOfNodesIsTheMirrorImage) {
  const Wall wall = wall_at(0, 1.0, 0.0, Contact::slip);
  const auto pair = [](const Index3& at) {  // tangential velocities alike on both sides: the wall leaves them as they are
    Node n = random_node({std::abs(at[0]), at[1], at[2]}, 3);
    const Node own = random_node(at, 4);
    n[0] = own[0];
    return n;
  };
  const auto behind = 1.0 + 1e-9;  // a mirror plane knows one plane of nodes behind it
  Grid folded = filled(wall, pair, behind), mirrored = filled(wall, pair, behind);
  fold(folded, wall);
  for_each_node(mirrored, [](Node& n, const Index3&) { n *= Node{n[3], n[3], n[3], 1.0}; });
  add_mirror_images(mirrored, {true, false}, NodeFields(mirrored), mirrored.own_blocks());
  int compared = 0;
  for_each_node(folded, [&](Node& n, const Index3& at) {
    if (std::abs(at[0]) > 1) return;
    const Node& m = *find_node(mirrored, at);
    ++compared;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(n[i], m[i] / m[3], 5.0 * round_off) << at[0];
  });
  EXPECT_EQ(compared, 3 * 20 * 20);
  for_each_node(folded, [&](Node& n, const Index3& at) {
    if (at[0] == 0) {
      EXPECT_EQ(n[0], 0.0);
    }
    if (at[0] == 1) {
      EXPECT_EQ(n[0], -(*find_node(folded, {-1, at[1], at[2]}))[0]);
    }
  });
}

/// What second order needs: a velocity that is zero on the plane and linear across it is not touched, wherever the plane is.
TEST(FoldedWall, LetsAFieldThroughThatIsLinearFromThePlaneOn) {
  const Vec3 slope(3.0, -2.0, 1.5), sliding(0.7, -4.0, 2.0), surface(0.3, 0.2, -0.4);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      for (const double place : places) {
        for (const Contact contact : kinds) {
          const Wall wall = wall_at(axis, sign, place, contact, contact == Contact::no_slip ? 0.0 : 0.4, surface);
          const auto linear = [&](const Index3& at) {
            const double d = (dx * Vec3(at[0], at[1], at[2]) - wall.point).dot(wall.normal);
            Vec3 v = surface + slope * d;
            if (contact != Contact::no_slip) v += sliding - sliding[axis] * Vec3::Unit(axis);
            return node_of(v, random_node(at, 5)[3]);
          };
          Grid before = filled(wall, linear), after = filled(wall, linear);
          fold(after, wall);
          // 8 m/s, and a plane whose place in cells is rounded: 1e-16 of 4 m/s per cell
          for_each_node(before, [&](Node& n, const Index3& at) {
            EXPECT_LE((velocity_of(n) - velocity_of(*find_node(after, at))).norm(), 8.0 * round_off) << axis << ' ' << sign << ' ' << place;
          });
        }
      }
    }
  }
}

TEST(FoldedWall, LeavesAVelocityThatVanishesLinearlyOnThePlane) {
  for (const double place : places) {
    for (const Contact contact : {Contact::slip, Contact::no_slip}) {
      const Vec3 surface(0.5, -1.0, 2.0);
      const Wall wall = wall_at(1, -1.0, place, contact, 0.0, surface);
      Grid grid = random_grid(wall);
      fold(grid, wall);
      // through the first two nodes whose column reaches behind the wall: zero on the plane, and the third on the same line
      const int master = static_cast<int>(std::floor(place - 0.5 + 1e-9));
      const double d = place - master;
      for (int x = first_node(low[0]); x < first_node(high[0] + 2); ++x) {
        for (int z = first_node(low[0]); z < first_node(high[0] + 2); ++z) {
          Vec3 r[3];
          for (int k = 0; k < 3; ++k) r[k] = velocity_of(*find_node(grid, {x, master + k, z})) - surface;
          for (int i = 0; i < 3; ++i) {
            if (contact == Contact::slip && i != 1) continue;
            EXPECT_NEAR(r[1][i], (d - 1.0) / d * r[0][i], 10.0 * round_off) << place;
            EXPECT_NEAR(r[2][i], (d - 2.0) / d * r[0][i], 10.0 * round_off) << place;
          }
        }
      }
    }
  }
}

// --- what it takes ------------------------------------------------------------------------------------------------------

TEST(FoldedWall, BooksTheMomentumThatNodesLose) {
  const Vec3 surface(0.6, -0.3, 0.8);
  for (const MirrorPlanes& mirror : {MirrorPlanes{}, MirrorPlanes{true, false}, MirrorPlanes{true, true}}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        for (const Contact contact : kinds) {
          // with deep nodes behind, which act each for itself
          const Wall wall = wall_at(axis, sign, 1.3, contact, contact == Contact::no_slip ? 0.0 : 0.3, surface);
          const auto random = [](const Index3& at) { return random_node(at, 6); };
          Grid before = filled(wall, random, 100.0), after = filled(wall, random, 100.0);
          const Impulse recorded = fold(after, wall, mirror);
          const testing::Taken taken = testing::taken_between(before, after, mirror, wall.point);
          EXPECT_GT(recorded.linear.norm(), 0.0);
          EXPECT_LE((recorded.linear - taken.linear).norm(), round_off * taken.scale);
          EXPECT_LE((recorded.angular - taken.angular).norm(), round_off * taken.angular_scale);
          EXPECT_NEAR(recorded.work, -taken.linear.dot(surface), round_off * taken.scale * surface.norm());
        }
      }
    }
  }
}

TEST(FoldedWall, NeverAddsKineticEnergyRelativeToTheSurface) {
  const Vec3 surface(0.6, -0.3, 0.8);
  for (const double place : places) {
    for (const Contact contact : kinds) {
      for (const double friction : {0.0, 0.3, 5.0}) {
        if (contact == Contact::no_slip && friction > 0.0) continue;
        const Wall wall = wall_at(2, 1.0, place, contact, friction, surface);
        Grid before = random_grid(wall, 7), after = random_grid(wall, 7);
        fold(after, wall);
        for (const auto& [at, column] : columns(before, after, 2, surface))
          EXPECT_LE(column.after, column.before * (1.0 + 10.0 * round_off)) << place << ' ' << friction;
      }
    }
  }
}

TEST(FoldedWall, LetsAColumnGoThatPullsAndHoldsOneThatPushes) {
  for (const double place : places) {
    const Wall slip = wall_at(2, 1.0, place, Contact::slip);
    Wall separable = slip;
    separable.contact = Contact::separable;
    const auto touching = [](const Index3& at) { return node_of(velocity_of(random_node(at, 8)), 1.0); };  // as much mass behind as before
    Grid before = filled(slip, touching), held = filled(slip, touching), after = filled(slip, touching);
    fold(held, slip);
    fold(after, separable);
    int let_go = 0, kept = 0;
    const auto slips = columns(before, held, 2);
    for_each_node(after, [&](Node& n, const Index3& at) {
      const Column& column = slips.at({at[0], at[1]});
      if (std::abs(column.given.z()) < round_off * column.scale) return;  // on the edge between both round-off decides
      const bool pulls = column.given.z() > 0.0;
      (pulls ? let_go : kept) += 1;
      EXPECT_EQ(velocity_of(n), velocity_of(*find_node(pulls ? before : held, at))) << place;  // to the bit
    });
    EXPECT_GT(let_go, 1000);
    EXPECT_GT(kept, 1000);
  }
}

/// Mass of a node over that in the bulk, if the material fills the space from a gap on: midpoint rule.
double share_of_bulk(double node_before_plane, double gap) {
  const int steps = 3000;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double y = 3.0 * (i + 0.5) / steps - 1.5, away = std::abs(y);
    if (node_before_plane + y < gap) continue;
    sum += (away < 0.5 ? 0.75 - away * away : 0.5 * (1.5 - away) * (1.5 - away)) * 3.0 / steps;
  }
  return sum;
}

TEST(FoldedWall, SeparableActsOnceMaterialIsWithinATenthOfACell) {
  for (const double place : places) {
    for (const double gap : {0.0, 0.05, 0.09, 0.11, 0.2, 0.5, 0.8}) {
      const Wall wall = wall_at(2, 1.0, place, Contact::separable);
      const auto approaching = [&](const Index3& at) { return node_of(-Vec3::UnitZ(), 3.0 * share_of_bulk(at[2] - place, gap)); };
      Grid before = filled(wall, approaching), after = filled(wall, approaching);
      fold(after, wall);
      const double stopped = -columns(before, after, 2).at({0, 0}).given.z();
      EXPECT_EQ(stopped > 0.01, gap < 0.1) << place << " " << gap << ": " << stopped;
    }
  }
}

TEST(FoldedWall, FrictionStaysInTheCoulombConeAndSticksWithinIt) {
  for (const Contact contact : {Contact::slip, Contact::separable}) {
    for (const double mu : {0.15, 0.7, 3.0}) {
      const Vec3 surface(0.5, 1.0, 0.0);
      const Wall smooth = wall_at(2, 1.0, 0.3, contact, 0.0, surface), rough = wall_at(2, 1.0, 0.3, contact, mu, surface),
                 sticky = wall_at(2, 1.0, 0.3, Contact::no_slip, 0.0, surface);
      Grid before = random_grid(smooth, 9), slid = random_grid(smooth, 9), rubbed = random_grid(smooth, 9), stuck = random_grid(smooth, 9);
      fold(slid, smooth);
      fold(rubbed, rough);
      fold(stuck, sticky);
      const auto smooth_columns = columns(before, slid, 2), rough_columns = columns(before, rubbed, 2),
                 sticky_columns = columns(before, stuck, 2);
      int slide = 0, stick = 0, free = 0;
      for (const auto& [at, column] : rough_columns) {
        const Vec3 all = sticky_columns.at(at).given;
        const double tolerance = round_off * column.scale, normal = -smooth_columns.at(at).given.z(), needed = std::hypot(all.x(), all.y()),
                     rubs = std::hypot(column.given.x(), column.given.y());
        EXPECT_NEAR(-column.given.z(), normal, tolerance) << "friction has no part in the normal impulse";
        if (normal <= tolerance) {  // pulled: no friction
          EXPECT_LE(rubs, tolerance + mu * std::abs(normal));
          ++free;
          continue;
        }
        EXPECT_LE(rubs, mu * normal + tolerance);
        EXPECT_NEAR(rubs, std::min(needed, mu * normal), tolerance);
        EXPECT_NEAR(column.given.x() * all.y(), column.given.y() * all.x(), tolerance * column.scale);  // along the slip
        (needed < mu * normal ? stick : slide) += 1;
        if (needed < mu * normal * (1.0 - 1e-9)) {
          for (int z = -1; z <= 1; ++z) {  // master 1, plane 0.3
            EXPECT_LE((velocity_of(*find_node(rubbed, {at.first, at.second, z})) - velocity_of(*find_node(stuck, {at.first, at.second, z})))
                          .norm(),
                      10.0 * round_off);
          }
        }
      }
      EXPECT_GT(slide, 10) << mu;
      EXPECT_GT(free, 10) << mu;
      if (mu > 0.5) {
        EXPECT_GT(stick, 10) << mu;
      }
    }
  }
}

// --- position and orientation ---------------------------------------------------------------------------------------------

TEST(FoldedWall, ActsAtTheTravellingSurface) {
  const Vec3 u(0.4, -0.7, 1.2);
  const double time = 0.35;
  for (const Contact contact : kinds) {
    const double friction = contact == Contact::no_slip ? 0.0 : 0.3;
    Wall moving = wall_at(2, 1.0, -1.0, contact, friction, u), resting = moving;
    moving.travels = true;
    resting.point.z() += time * u.z();
    resting.velocity = Vec3::Zero();
    Grid seen_moving = random_grid(resting, 10), seen_resting = random_grid(resting, 10);
    for_each_node(seen_moving, [&](Node& n, const Index3&) { n += Node{u.x(), u.y(), u.z(), 0.0}; });
    fold(seen_moving, moving, {}, time);
    fold(seen_resting, resting);
    for_each_node(seen_moving, [&](Node& n, const Index3& at) {
      EXPECT_LE((velocity_of(n) - u - velocity_of(*find_node(seen_resting, at))).norm(), 10.0 * round_off);
    });
  }
}

/// A belt whose speed varies with height: each column obeys its own surface.
TEST(FoldedWall, TakesTheSurfaceVelocityOfItsColumn) {
  Wall inlet = wall_at(0, 1.0, 0.3, Contact::no_slip);
  inlet.speed = [](double height, double time) { return height + 10.0 * time; };
  Grid grid = random_grid(inlet, 11);
  apply_folded_wall(grid, inlet, {}, 0.2, grid.own_blocks());
  for (int y = first_node(low[0]); y < first_node(high[0] + 2); ++y) {
    for (int z = first_node(low[0]); z < first_node(high[0] + 2); ++z) {
      const Vec3 surface(dx * z - inlet.point.z() + 2.0, 0.0, 0.0);
      const Vec3 a = velocity_of(*find_node(grid, {1, y, z})) - surface, b = velocity_of(*find_node(grid, {0, y, z})) - surface;
      EXPECT_LE((0.7 * b + 0.3 * a).norm(), 10.0 * round_off);  // zero at 0.3 cells
    }
  }
}

TEST(FoldedWall, IsTheSameAlongEveryAxisAndInBothDirections) {
  for (const Contact contact : kinds) {
    const double friction = contact == Contact::no_slip ? 0.0 : 0.3, place = 0.375;
    const auto node = [](const Index3& at) { return random_node(at, 12); };
    Wall reference_wall = wall_at(2, 1.0, place, contact, friction);
    reference_wall.velocity = Vec3(0.3, 0.2, 0.1);
    Grid reference = filled(reference_wall, node);
    fold(reference, reference_wall);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int sign : {1, -1}) {
        // component (axis + 1 + i) mod 3 of the turned world is component i of the first; its normal one changes sign with `sign`
        const auto back = [&](const Index3& at) {
          Index3 b;
          for (int i = 0; i < 3; ++i)
            b[static_cast<std::size_t>(i)] = (i == 2 ? sign : 1) * at[static_cast<std::size_t>((axis + 1 + i) % 3)];
          return b;
        };
        const auto turned = [&](const Vec3& v) {
          Vec3 t;
          for (int i = 0; i < 3; ++i) t[(axis + 1 + i) % 3] = (i == 2 ? sign : 1) * v[i];
          return t;
        };
        Wall wall = wall_at(axis, sign, sign * place, contact, friction);
        wall.velocity = turned(reference_wall.velocity);
        Grid grid = filled(wall, [&](const Index3& at) {
          const Node n = node(back(at));
          return node_of(turned(velocity_of(n)), n[3]);
        });
        fold(grid, wall);
        int compared = 0;
        for_each_node(grid, [&](Node& n, const Index3& at) {
          const Node* r = find_node(reference, back(at));
          if (r == nullptr) return;
          ++compared;
          EXPECT_LE((velocity_of(n) - turned(velocity_of(*r))).norm(), 5.0 * round_off) << axis << ' ' << sign;  // sums in another order
        });
        EXPECT_GT(compared, 5000);
      }
    }
  }
}

/// The plane's place among the blocks is not seen: a column through a border of blocks is one within.
TEST(FoldedWall, GivesTheSameBitsWhereverBlocksEnd) {
  for (const double sign : {1.0, -1.0}) {
    for (const Contact contact : kinds) {
      const double friction = contact == Contact::no_slip ? 0.0 : 0.3;
      const auto run = [&](int shift) {
        const Wall wall = wall_at(2, sign, shift + 0.375, contact, friction);  // exact in binary
        Grid grid = filled(wall, [&](const Index3& at) { return random_node({at[0], at[1], at[2] - shift}, 13); });
        fold(grid, wall);
        return grid;
      };
      Grid reference = run(0);
      for (const int shift : {1, 2, 3, -1}) {
        Grid shifted = run(shift);
        for_each_node(shifted, [&](Node& n, const Index3& at) {
          const Node* r = find_node(reference, {at[0], at[1], at[2] - shift});
          if (r != nullptr) {
            EXPECT_EQ(velocity_of(n), velocity_of(*r)) << shift;
          }
        });
      }
    }
  }
}

TEST(FoldedWall, IsForWallsAlongTheGridThatLeaveRoomForTheColumn) {
  const Wall floor = wall_at(2, 1.0, 0.0, Contact::slip);
  const auto lid = [](double cells) { return Boundary(wall_at(2, -1.0, cells, Contact::slip)); };
  const auto folds_with = [&](const Boundary& other) {
    const Boundary both[] = {floor, other};
    return folds(floor, both, {}, dx, 0.0);
  };
  EXPECT_TRUE(folds_with(lid(3.0)));
  EXPECT_FALSE(folds_with(lid(2.0))) << "both have the node between them for their master";
  EXPECT_TRUE(folds_with(lid(2.75)));
  EXPECT_FALSE(folds_with(lid(1.0))) << "the lid holds the master";
  EXPECT_TRUE(folds_with(wall_at(0, 1.0, 0.0, Contact::slip))) << "walls at right angles have columns of their own";
  EXPECT_TRUE(folds_with(wall_at(2, 1.0, 2.0, Contact::slip)));
  Wall closing = wall_at(2, -1.0, 3.0, Contact::slip, 0.0, {0.0, 0.0, -1.0});
  closing.travels = true;
  const Boundary press[] = {floor, closing};
  EXPECT_TRUE(folds(floor, press, {}, dx, 0.1));   // 2.6 cells left
  EXPECT_FALSE(folds(floor, press, {}, dx, 0.2));  // 2.2
  Wall oblique = floor, nodal = floor;
  oblique.normal = Vec3(0.1, 0.0, 1.0).normalized();
  nodal.rule = ContactRule::nodal;
  EXPECT_FALSE(folds(oblique, {}, {}, dx, 0.0));
  EXPECT_FALSE(folds(nodal, {}, {}, dx, 0.0));
  const Wall side = wall_at(1, -1.0, 1.25, Contact::slip);
  EXPECT_TRUE(folds(side, {}, {true, false}, dx, 0.0));
  EXPECT_FALSE(folds(side, {}, {false, true}, dx, 0.0)) << "its image beyond the mirror plane has the same master";
  EXPECT_TRUE(folds(wall_at(1, -1.0, 1.5, Contact::slip), {}, {false, true}, dx, 0.0));
}

/// update_grid on velocities that the nodes already have.
BoundaryImpulses update(Grid& grid, std::span<const Boundary> boundaries, const MirrorPlanes& mirror = {}) {
  for_each_node(grid, [](Node& n, const Index3&) { n *= Node{n[3], n[3], n[3], 1.0}; });
  return update_grid(grid, {.boundaries = boundaries, .mirror = mirror}, 1e-3, 0.0).total(one_rank());
}

TEST(FoldedWall, FallsBackToNodesBetweenWallsThatAreTooClose) {
  Wall floor = wall_at(2, 1.0, 0.0, Contact::separable, 0.3), lid = wall_at(2, -1.0, 1.0, Contact::slip);
  const auto run = [&](ContactRule rule) {
    floor.rule = lid.rule = rule;
    Grid grid = random_grid(floor, 14);
    const Boundary both[] = {floor, lid};
    const auto impulses = update(grid, both).impulses;
    return std::pair{std::move(grid), impulses};
  };
  auto [surface, by_surface] = run(ContactRule::surface);
  auto [nodal, by_nodes] = run(ContactRule::nodal);
  for_each_node(surface, [&nodal = nodal](Node& n, const Index3& at) { EXPECT_EQ(velocity_of(n), velocity_of(*find_node(nodal, at))); });
  for (std::size_t b = 0; b < 2; ++b) EXPECT_EQ(by_surface[b].linear, by_nodes[b].linear);
}

// --- mirror planes ------------------------------------------------------------------------------------------------------

/// A part of a symmetric field on nodes, bounded by a floor and side walls, against the whole. @param half_width  cells: of the walls
class FoldedAlongAMirror : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(HalfWidths, FoldedAlongAMirror, ::testing::Values(4.25, 2.5, 2.0, 1.5, 1.25, 1.0),
                         [](const auto& test) { return "Percent" + std::to_string(std::lround(100.0 * test.param)); });

TEST_P(FoldedAlongAMirror, GivesThePartWhatTheWholeGives) {
  for (int axis = 0; axis < 2; ++axis) {
    for (const Contact contact : kinds) {
      const auto a = static_cast<std::size_t>(axis);
      const double friction = contact == Contact::no_slip ? 0.0 : 0.3;
      const Boundary floor = wall_at(2, 1.0, -0.3, Contact::separable, 0.4), right = wall_at(axis, -1.0, GetParam(), contact, friction),
                     left = wall_at(axis, 1.0, -GetParam(), contact, friction);
      const auto symmetric = [&](const Index3& at) {
        Index3 image = at;
        image[a] = std::abs(at[a]);
        Node n = random_node(image, 15);
        n[axis] *= at[a] < 0 ? -1.0 : at[a] == 0 ? 0.0 : 1.0;
        if (std::abs(at[a]) > GetParam() + 1.5 || at[2] < -1) n = Node{};
        return n;
      };
      const MirrorPlanes mirror{axis == 0, axis == 1};
      Grid whole = grid_of_blocks(dx, low, high), part = grid_of_blocks(dx, low, high);
      for_each_node(whole, [&](Node& n, const Index3& at) { n = symmetric(at); });
      for_each_node(part, [&](Node& n, const Index3& at) { n = at[a] < -1 ? Node{} : symmetric(at); });
      const Boundary all[] = {floor, right, left}, computed[] = {floor, right};
      const auto of_whole = update(whole, all).impulses, of_part = update(part, computed, mirror).impulses;
      double largest = 0.0;
      for_each_node(part, [&](Node& n, const Index3& at) {
        if (at[a] < -1) return;
        const Vec3 difference = velocity_of(n) - velocity_of(*find_node(whole, at));
        largest = std::max(largest, difference.norm());
      });
      EXPECT_LE(largest, 20.0 * round_off) << "axis " << axis << ", contact " << static_cast<int>(contact);  // two walls in turn, 9 m/s
      const double scale = 5.0 * 20.0 * 20.0;                                                                // kg m/s: of a wall's nodes
      EXPECT_LE((whole_force(of_part[0].linear, mirror) - of_whole[0].linear).norm(), round_off * scale);
      EXPECT_LE((of_part[1].linear - of_whole[1].linear).norm(), round_off * scale);
    }
  }
}

}  // namespace
}  // namespace mpm
