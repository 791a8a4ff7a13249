#include "libmpm/core/surface_contact.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>

#include "libmpm/boundary/shapes/any_shape.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/folded_wall.hpp"
#include "support/node_field.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

using testing::find_node;
using testing::for_each_node;
using testing::grid_of_blocks;
using testing::node_of;
using testing::random_node;
using testing::velocity_of;

constexpr double dx = 0.25;
constexpr double round_off = 1e-13;  ///< of sums over some hundred nodes, relative to the sum of their sizes
constexpr double tall = 100.0;       ///< m
const Index3 low = {-3, -3, -1}, high = {4, 2, 1};

/// What is 1.4 dx or more inside has no material, as in a flow.
using Field = std::function<Node(const Index3&)>;
Grid filled(const Outline& outline, const Field& field, double deepest = 1.4, const Index3& shift = {0, 0, 0}) {
  Grid grid = grid_of_blocks(dx, low, high);
  for_each_node(grid, [&](Node& n, const Index3& at) {
    n = field({at[0] - shift[0], at[1] - shift[1], at[2] - shift[2]});
    if (outline.nearest(dx * Vec2(at[0], at[1])).distance < -deepest * dx) n = Node{};
  });
  return grid;
}

struct Named {
  std::string name;
  Outline outline;
  bool symmetric;  ///< about y = 0
};
std::vector<Named> outlines() {
  std::vector<Named> all = {{"BoxOnNodes", BoxShape{.width = 2.0, .depth = 1.5}.outline(), true},
                            {"BoxBetweenNodes", BoxShape{.width = 1.75, .depth = 1.1}.outline(), true},
                            {"ThreePointsWide", BoxShape{.width = 0.75, .depth = 1.5}.outline(), true}};
  for (const testing::TypicalShape& t : testing::typical_shapes()) all.push_back({t.name, outline_of(t.shape), t.outline().symmetric()});
  return all;
}
void PrintTo(const Named& n, std::ostream* out) { *out << n.name; }
bool has_edge_on_mirror_plane(const Outline& outline) {
  return !outline.circle() && std::ranges::any_of(outline.sides(), [](const auto& side) { return std::abs(side.from.y()) < 1e-9; });
}

SurfaceSolid solid_of(const Outline& outline, double friction = 0.0, double top = tall, MirrorPlanes mirror = {}) {
  return SurfaceSolid({.outline = outline, .top = top}, friction, Vec3(0.1, 0.2, 0.3), dx, mirror);
}

/// Normal velocity at a point of the surface in a layer of nodes; NaN where nodes are missing.
double approach(Grid& grid, const ContactStencil& stencil, const ContactRow& row, int layer) {
  double sum = 0.0;
  for (std::size_t e = row.first; e < row.first + row.count; ++e) {
    const ContactEntry& entry = stencil.entries[e];
    const auto& at = stencil.nodes[static_cast<std::size_t>(entry.node)].at;
    const Node& node = *find_node(grid, {at[0], at[1], layer});
    if (node[3] <= 0.0) return std::nan("");
    sum += -entry.normal.dot(velocity_of(node).head<2>());
  }
  return sum;
}

Vec2 centre_of(const Outline& outline) {
  Vec2 sum = Vec2::Zero();
  for (const Outline::Side& side : outline.sides()) sum += side.from;
  return sum / static_cast<double>(outline.sides().size());
}

double kinetic_energy(Grid& grid) {
  double sum = 0.0;
  for_each_node(grid, [&](Node& n, const Index3&) { sum += 0.5 * n[3] * velocity_of(n).squaredNorm(); });
  return sum;
}
double largest_change(Grid& before, Grid& after) {
  double largest = 0.0;
  for_each_node(before, [&](Node& n, const Index3& at) {
    largest = std::max(largest, (velocity_of(n) - velocity_of(*find_node(after, at))).norm());
  });
  return largest;
}

class SurfaceContact : public ::testing::TestWithParam<Named> {
 protected:
  const Outline& outline = GetParam().outline;
  const Field random = [](const Index3& at) { return random_node(at, 21); };
};
INSTANTIATE_TEST_SUITE_P(Outlines, SurfaceContact, ::testing::ValuesIn(outlines()), [](const auto& test) { return test.param.name; });

constexpr double speed = 20.0;  ///< m/s, of an impact

/// With the density of snow, in a step of a millisecond.
ContactImpulse apply_surface_contact(Grid& grid, const SurfaceSolid& solid) { return apply_surface_contact(grid, solid, 300.0, 0.0, 1e-3); }

/// The largest part of a point's impulse that its neighbour on the same side feels, at nodes of equal mass.
double largest_overlap(const ContactStencil& stencil) {
  double largest = 0.0;
  for (std::size_t r = 0; r + 1 < stencil.point_rows; ++r) {
    const ContactRow &row = stencil.rows[r], &next = stencil.rows[r + 1];
    double own = 0.0, common = 0.0;
    for (std::size_t e = row.first; e < row.first + row.count; ++e) {
      own += stencil.entries[e].normal.squaredNorm();
      for (std::size_t f = next.first; f < next.first + next.count; ++f) {
        if (stencil.entries[e].node == stencil.entries[f].node) common += stencil.entries[e].normal.dot(stencil.entries[f].normal);
      }
    }
    largest = std::max(largest, common / own);
  }
  return largest;
}

TEST_P(SurfaceContact, StopsWhatFliesAgainstTheSurface) {
  for (const double friction : {0.0, 0.3}) {
    const SurfaceSolid solid = solid_of(outline, friction);
    Grid grid = filled(outline, [](const Index3&) { return node_of({speed, 0.0, 0.0}, 1.0); });
    apply_surface_contact(grid, solid);
    double worst = 0.0, end = 0.0;
    int rows = 0;
    for (const ContactRow& row : solid.stencil().rows) {
      if (row.kind != ContactRow::Kind::point) continue;
      const double left = approach(grid, solid.stencil(), row, 2);
      if (std::isnan(left)) continue;
      ++rows;
      (row.edge.neighbour >= 0 ? end : worst) = std::max(row.edge.neighbour >= 0 ? end : worst, left);
    }
    EXPECT_GT(rows, 5);
    // A point and the next have a part of their nodes' weights in common, a half where they are a cell apart: what one gives disturbs the
    // next by that part, and each sweep takes it on by one point and by another such part. The first two sweeps know no caps: the sixth
    // power is left after the six that follow. The ends themselves stay open: that is what their cap is for.
    EXPECT_LE(worst, 1.3 * std::pow(largest_overlap(solid.stencil()), 6) * speed);
    EXPECT_LE(end, speed);
  }
}

TEST_P(SurfaceContact, BooksTheMomentumThatNodesLoseInAllAndByLayer) {
  for (const MirrorPlanes mirror : {MirrorPlanes{}, {false, true}}) {
    for (const double friction : {0.0, 0.4}) {
      if (mirror.y && !GetParam().symmetric) continue;
      const SurfaceSolid solid = solid_of(outline, friction, tall, mirror);
      Grid before = filled(outline, random, 100.0), after = filled(outline, random, 100.0);  // deep nodes, too
      const ContactImpulse recorded = apply_surface_contact(after, solid);
      const testing::Taken taken = testing::taken_between(before, after, mirror, solid.reference_point());
      EXPECT_GT(recorded.total().linear.norm(), 1.0);
      EXPECT_LE((recorded.total().linear - taken.linear).norm(), round_off * taken.scale);
      EXPECT_LE((recorded.total().angular - taken.angular).norm(), round_off * taken.angular_scale);
      EXPECT_EQ(recorded.total().work, 0.0);  // it is at rest
      std::map<int, Vec3> by_layer;
      for_each_node(before, mirror, [&](Node& n, const Index3& at, double share) {
        by_layer.try_emplace(at[2], Vec3::Zero()).first->second += share * n[3] * (velocity_of(n) - velocity_of(*find_node(after, at)));
      });
      Vec3 sum = Vec3::Zero();
      for (std::size_t k = 0; k < recorded.layers().layer.size(); ++k) {
        const auto found = by_layer.find(recorded.layers().first + static_cast<int>(k));
        const Vec3 expected = found == by_layer.end() ? Vec3::Zero() : found->second;
        EXPECT_LE((recorded.layers().layer[k] - expected).norm(), round_off * taken.scale);
        sum += recorded.layers().layer[k];
      }
      EXPECT_EQ(sum, recorded.total().linear);
      EXPECT_LE(recorded.layers().first, first_node(low[2]));
      EXPECT_GT(recorded.layers().first + static_cast<int>(recorded.layers().layer.size()), first_node(high[2] + 1) + 3);
    }
  }
}

TEST_P(SurfaceContact, NeverAddsKineticEnergy) {
  for (const double friction : {0.0, 0.4, 3.0}) {
    for (unsigned seed = 22; seed < 27; ++seed) {
      const Field field = [&](const Index3& at) { return random_node(at, seed); };
      Grid before = filled(outline, field), after = filled(outline, field);
      apply_surface_contact(after, solid_of(outline, friction));
      EXPECT_LE(kinetic_energy(after), kinetic_energy(before) * (1.0 + round_off)) << friction;
    }
  }
}

/// It pulls at nothing: the surface points give no impulse, and the extension sees nothing of a linear field.
TEST_P(SurfaceContact, LeavesALinearFieldAloneThatMovesAway) {
  const Vec2 middle = centre_of(outline);
  for (const double friction : {0.0, 0.4}) {
    const Field away = [&](const Index3& at) {
      const Vec2 r = dx * Vec2(at[0], at[1]) - middle;
      return node_of({3.0 * r.x(), 3.0 * r.y(), 1.0}, random_node(at, 28)[3]);
    };
    Grid before = filled(outline, away), after = filled(outline, away);
    const ContactImpulse recorded = apply_surface_contact(after, solid_of(outline, friction));
    EXPECT_LE(largest_change(before, after), 10.0 * round_off);  // up to 10 m/s
    EXPECT_LE(recorded.total().linear.norm(), 1e-10);            // kg m/s: a thousand nodes of 1 kg
  }
}

/// Away from the surface, each node at its own speed.
ContactImpulse let_go(const Outline& outline, double& change) {
  const Vec2 middle = centre_of(outline);
  const Field away = [&](const Index3& at) {
    const Vec2 r = dx * Vec2(at[0], at[1]) - middle;
    const Node n = random_node(at, 29);
    return node_of({(6.0 + n[0]) * r.x(), (6.0 + n[0]) * r.y(), n[2]}, n[3]);
  };
  Grid before = filled(outline, away), after = filled(outline, away);
  ContactImpulse recorded = apply_surface_contact(after, solid_of(outline, 0.4));
  change = largest_change(before, after);
  return recorded;
}

TEST_P(SurfaceContact, PullsAtNothingThatMovesAway) {
  double change = 0.0;
  const ContactImpulse recorded = let_go(outline, change);
  EXPECT_LE(recorded.total().linear.norm(), 1e-10);  // kg m/s: a thousand nodes of 1 kg and 10 m/s; what the extension gives has no sum
}

/// Not so yet: the extension acts whether the points press or not, and changes nodes by up to 8 m/s here, where a folded wall would let the
/// column go.
TEST_P(SurfaceContact, LeavesAloneWhatMovesAway) {
  double change = 0.0;
  let_go(outline, change);
  EXPECT_EQ(change, 0.0);
}

TEST_P(SurfaceContact, GivesTheSameBitsOnAnyNumberOfThreadsAndWhereverBlocksEnd) {
  for (const double friction : {0.0, 0.4}) {
    const SurfaceSolid solid = solid_of(outline, friction);
    const auto run = [&](int threads, int shift) {
      omp_set_num_threads(threads);
      Grid grid = filled(outline, random, 1.4, {0, 0, shift});
      ContactImpulse impulse = apply_surface_contact(grid, solid);
      omp_set_num_threads(1);
      return std::pair{std::move(grid), impulse};
    };
    auto [reference, one] = run(1, 0);
    for (const int threads : {1, 2, 3}) {
      for (int shift = 0; shift < 4; ++shift) {
        auto [grid, many] = run(threads, shift);
        for_each_node(grid, [&, &reference = reference](Node& n, const Index3& at) {
          const Node* r = find_node(reference, {at[0], at[1], at[2] - shift});
          if (r != nullptr) {
            EXPECT_EQ(velocity_of(n), velocity_of(*r)) << threads << ' ' << shift;
          }
        });
        if (shift == 0) {
          EXPECT_EQ(one.total().linear, many.total().linear);
          EXPECT_EQ(one.total().angular, many.total().angular);
          EXPECT_EQ(one.layers().layer, many.layers().layer);
        }
      }
    }
  }
}

TEST_P(SurfaceContact, ActsOnTheLayersUpToItsTop) {
  const double top = 1.2 * dx;  // layer 1 is bounded by layer 0
  Grid before = filled(outline, random), after = filled(outline, random), tall_after = filled(outline, random);
  const ContactImpulse recorded = apply_surface_contact(after, solid_of(outline, 0.3, top));
  apply_surface_contact(tall_after, solid_of(outline, 0.3));
  for_each_node(after, [&](Node& n, const Index3& at) {
    if (at[2] == 1) return;
    EXPECT_EQ(velocity_of(n), velocity_of(*find_node(at[2] <= 0 ? tall_after : before, at))) << at[2];
  });
  for (std::size_t k = 0; k < recorded.layers().layer.size(); ++k) {
    const int layer = recorded.layers().first + static_cast<int>(k);
    EXPECT_EQ(recorded.layers().layer[k].isZero(0.0), layer > 1 || layer < first_node(low[2])) << layer;
  }
}

/// A uniform flow against the whole surface: a layer at top or underside takes the part of the layer inwards that its strip has, less where
/// the flow leaves along the side; gravity adds its pressure at the underside.
TEST_P(SurfaceContact, BoundsTheLayersAtItsTopAndAtItsUnderside) {
  const Field flow = [](const Index3&) { return node_of({speed, 0.0, 0.0}, 1.0); };
  for (const double depth : {0.0, 0.3, 0.5, 0.9, 0.1 * 3 / 0.1 - 3.0}) {  // the last by round-off
    constexpr int lowest = -3, highest = 3;
    const UprightSolid solid{.outline = outline, .base = (lowest - depth) * dx, .top = (highest + depth) * dx};
    const auto along_flow = [&](double gravity) {
      Grid grid = filled(outline, flow);
      std::map<int, double> by_layer;
      const LayerImpulses layers =
          apply_surface_contact(grid, SurfaceSolid(solid, 0.0, Vec3::Zero(), dx, {}), 300.0, gravity, 1e-3).layers();
      for (std::size_t k = 0; k < layers.layer.size(); ++k) by_layer[layers.first + static_cast<int>(k)] = layers.layer[k].x();
      return by_layer;
    };
    std::map<int, double> impulse = along_flow(0.0), heavy = along_flow(-500.0);
    const double inner = impulse[highest - 1];
    const EdgeBound edge = bound_by_depth(depth, depth + 1.0), outside = bound_by_depth(depth - 1.0, depth);
    EXPECT_DOUBLE_EQ(edge.at_rest, std::min(depth + 0.5, 1.0));
    EXPECT_GT(inner, 0.0);
    for (int layer = lowest + 1; layer < highest; ++layer) EXPECT_DOUBLE_EQ(impulse[layer], inner) << layer;
    for (const int end : {lowest, highest}) {
      EXPECT_LE(impulse[end], edge.at_rest * inner * (1.0 + round_off));
      EXPECT_GE(impulse[end], edge.free * inner * (1.0 - round_off));
      const int next = end > 0 ? end + 1 : end - 1;
      if (depth > 0.6) {
        EXPECT_LE(impulse[next], outside.at_rest * impulse[end] * (1.0 + round_off));
        EXPECT_GE(impulse[next], outside.free * impulse[end] * (1.0 - round_off));
      } else {
        EXPECT_EQ(impulse[next], 0.0);
      }
    }
    EXPECT_DOUBLE_EQ(impulse[lowest], impulse[highest]);
    EXPECT_DOUBLE_EQ(heavy[highest], impulse[highest]) << "the pressure falls towards the top";
    EXPECT_TRUE(heavy[lowest] > impulse[lowest] || (depth >= 0.5 && heavy[lowest] == impulse[lowest])) << "a whole strip is not bounded";
  }
}

TEST_P(SurfaceContact, HoldsNodesBeyondTheReachOfItsRowsEachForItself) {
  for (const double friction : {0.0, 0.4}) {
    const SurfaceSolid solid = solid_of(outline, friction);
    const ContactStencil& stencil = solid.stencil();
    Grid before = filled(outline, random, 100.0), after = filled(outline, random, 100.0);
    apply_surface_contact(after, solid);
    int alone = 0;
    for (const auto& deep : stencil.deep) {
      if (std::ranges::any_of(stencil.entries, [&](const ContactEntry& e) { return e.node == deep.node; })) continue;
      const auto& at = stencil.nodes[static_cast<std::size_t>(deep.node)].at;
      for (int z = first_node(low[2]); z < first_node(high[2] + 2); ++z) {
        const Vec3 v = velocity_of(*find_node(before, {at[0], at[1], z}));
        const Vec3 held = contact_velocity(v, Vec3(deep.normal.x(), deep.normal.y(), 0.0), Vec3::Zero(), Contact::separable, friction);
        EXPECT_LE((velocity_of(*find_node(after, {at[0], at[1], z})) - held).norm(), round_off);  // of 9 m/s
        ++alone;
      }
    }
    if (GetParam().name == "BoxOnNodes" || GetParam().name == "Cylinder") {
      EXPECT_GT(alone, 0);
    }
  }
}

/// Vertical momentum that a column of nodes gained.
double column_impulse(Grid& before, Grid& after, const std::array<int, 2>& at) {
  double sum = 0.0;
  for_each_node(after, [&](Node& n, const Index3& node) {
    if (node[0] == at[0] && node[1] == at[1]) sum += n[3] * (n[2] - (*find_node(before, node))[2]);
  });
  return sum;
}

/// Snow beside a solid, whose B-splines reach nodes under its top: without any on the master of a column nothing lies on the face.
TEST_P(SurfaceContact, ItsTopLeavesAloneWhatIsBesideIt) {
  for (const double top : {dx, 1.3 * dx, 3.8 * dx}) {
    const SurfaceSolid solid = solid_of(outline, 0.4, top);
    const auto below = [&](const Index3& at) { return dx * at[2] > top + 0.4 * dx ? Node{} : random_node(at, 34); };
    Grid before = filled(outline, below), after = filled(outline, below);
    ContactImpulse recorded;
    apply_folded_faces(after, solid, {}, 300.0, 1e-3, recorded);
    int under = 0;
    for_each_node(after, [&](Node& n, const Index3& at) {
      EXPECT_EQ(velocity_of(n), velocity_of(*find_node(before, at))) << at[0] << ' ' << at[1] << ' ' << at[2];
      under += n[3] > 0.0 && outline.distance(dx * Vec2(at[0], at[1])) < 0.0 && dx * at[2] > top - 1.5 * dx;
    });
    EXPECT_GT(under, 0);
    EXPECT_EQ(recorded.total().linear, Vec3::Zero());
  }
}

/// The columns of nodes inside the outline obey the top as they would a separable wall, those at an edge a part of the way, others not.
TEST_P(SurfaceContact, FoldsTheColumnsOnItsTop) {
  for (const double top : {dx, 1.3 * dx, 3.8 * dx}) {
    for (const double friction : {0.0, 0.4}) {
      const SurfaceSolid solid = solid_of(outline, friction, top);
      const Wall wall{Vec3(0.0, 0.0, top), Vec3::UnitZ(), Contact::separable, friction, Vec3::Zero(), false, ContactRule::surface};
      const auto field = [&](const Index3& at) { return dx * at[2] < top - 1.5 * dx ? Node{} : random_node(at, 34); };
      Grid before = filled(outline, field, 100.0), after = filled(outline, field, 100.0), folded = filled(outline, field, 100.0);
      ContactImpulse recorded{.first = first_node(low[2]),
                              .sides = std::vector<Impulse>(static_cast<std::size_t>(4 * (high[2] + 2 - low[2])))};
      apply_folded_faces(after, solid, {}, 300.0, 1e-3, recorded);
      apply_folded_wall(folded, wall, {}, 0.0, folded.own_blocks());
      std::map<std::array<int, 2>, ContactStencil::Column> columns;
      for (const auto& c : solid.stencil().columns) columns[solid.stencil().nodes[static_cast<std::size_t>(c.node)].at] = c;
      int held = 0, in_part = 0;
      for_each_node(after, [&](Node& n, const Index3& at) {
        const auto column = columns.find({at[0], at[1]});
        const Vec3 v = velocity_of(n), free = velocity_of(*find_node(before, at)), whole = velocity_of(*find_node(folded, at));
        if (column == columns.end()) {
          EXPECT_EQ(v, free) << at[0] << ' ' << at[1] << ' ' << at[2];
        } else if (column->second.edge.neighbour < 0) {
          EXPECT_EQ(v, whole) << at[0] << ' ' << at[1] << ' ' << at[2];
          held += v != free;
        } else {
          const double part = whole == free ? 0.0 : (v - free).dot(whole - free) / (whole - free).squaredNorm();
          EXPECT_LE((v - free - part * (whole - free)).norm(), round_off * speed);
          EXPECT_GE(part, -round_off);
          EXPECT_LE(part, 1.0 + round_off);
          in_part += part > 0.0 && part < 1.0;
        }
      });
      EXPECT_GT(held, 5);
      EXPECT_GT(in_part, 0);
      for (const auto& [at, column] : columns) {  // impulse of the column over what it may take
        if (column.edge.neighbour < 0) continue;
        const auto& inner = solid.stencil().columns[static_cast<std::size_t>(column.edge.neighbour)];
        EXPECT_LE(column_impulse(before, after, at),
                  column.edge.at_rest * column_impulse(before, after, solid.stencil().nodes[static_cast<std::size_t>(inner.node)].at) +
                      round_off * speed);
      }
      const testing::Taken taken = testing::taken_between(before, after, {}, solid.reference_point());
      EXPECT_LE((recorded.total().linear - taken.linear).norm(), round_off * taken.scale);
      EXPECT_LE((recorded.total().angular - taken.angular).norm(), round_off * taken.angular_scale);
      Vec3 sum = Vec3::Zero();
      for (const Vec3& layer : recorded.layers().layer) sum += layer;
      EXPECT_LE((sum - recorded.total().linear).norm(), round_off * taken.scale);
    }
  }
}

/// A part of a symmetric field with the mirror plane y = 0, and the whole.
struct PartAndWhole {
  PartAndWhole(const Outline& outline, double friction) {
    const auto field = [](bool part) -> Field {
      return [part](const Index3& at) {
        if (part && at[1] < -1) return Node{};
        Vec3 v = velocity_of(random_node({at[0], std::abs(at[1]), at[2]}, 30)) + Vec3(speed, 0.0, 0.0);
        v[1] *= at[1] < 0 ? -1.0 : at[1] == 0 ? 0.0 : 1.0;
        return node_of(v, 1.0);
      };
    };
    Grid whole = filled(outline, field(false)), part = filled(outline, field(true));
    of_whole = apply_surface_contact(whole, solid_of(outline, friction)).total().linear;
    of_part = whole_force(apply_surface_contact(part, solid_of(outline, friction, tall, {false, true})).total().linear, {false, true});
    for_each_node(part, [&](Node& n, const Index3& at) {
      if (at[1] >= 0) difference = std::max(difference, (velocity_of(n) - velocity_of(*find_node(whole, at))).norm());
    });
  }
  Vec3 of_whole, of_part;
  double difference = 0.0;  ///< of the velocities of a node, m/s
};

/// The stencils are the same to round-off (test_contact_stencil.cpp). The solutions are not: both sweep over their rows in an order of
/// their own, the whole from one corner on and the part with every row and its image at once, and eight sweeps leave each as far from the
/// solution as OnAPlaneOfNodesIsTheFoldedWall says. With a hundred sweeps the difference is 1e-7 of the speed.
void expect_part_as_whole(const Outline& outline) {
  for (const double friction : {0.0, 0.4}) {
    const PartAndWhole both(outline, friction);
    EXPECT_LE(both.difference, 0.084 * speed);
    EXPECT_LE((both.of_part - both.of_whole).norm(), 0.02 * both.of_whole.norm());  // what a face has left to take, as in StopsWhatFlies...
  }
}

TEST(SurfaceContactOfPart, GivesWhatTheWholeGives) {
  int tried = 0;
  for (const Named& n : outlines()) {
    if (!n.symmetric || has_edge_on_mirror_plane(n.outline)) continue;  // the edge: below
    SCOPED_TRACE(n.name);
    expect_part_as_whole(n.outline);
    ++tried;
  }
  EXPECT_GE(tried, 4);
}

/// Not so yet, and not with any number of sweeps: 32 % of the speed at nodes, 7 % of the force. At an edge on the mirror plane the ends of
/// two sides bound each other's impulse, so that both keep what they had after two sweeps.
TEST(SurfaceContactOfAWedge, DISABLED_GivesThePartWhatTheWholeGives) {
  expect_part_as_whole(WedgeShape{.width = 1.75, .depth = 1.75}.outline());
}

// --- one face -----------------------------------------------------------------------------------------------------------

/// A plate whose front face is turned by an angle; material only before the middle of that face.
struct Face {
  explicit Face(double angle, double place = 0.0) : outline(BoxShape{.width = 4.0, .depth = 2.0, .rotation = angle}.outline()) {
    outline.translate({place * dx, 0.0});
    const Vec2 a = outline.sides()[3].from, b = outline.sides()[3].to;  // the front
    middle = 0.5 * (a + b);
    along = (b - a).normalized();
    normal = Vec2(along.y(), -along.x());
  }
  /// Nodes up to 1.4 cells behind the face and five cells from its middle; its edges are three cells further.
  [[nodiscard]] Grid filled(const std::function<Vec3(const Vec3&)>& velocity, unsigned seed = 31, double mass = 0.0) const {
    Grid grid = grid_of_blocks(dx, low, high);
    for_each_node(grid, [&](Node& n, const Index3& at) {
      const Vec3 x = dx * Vec3(at[0], at[1], at[2]);
      const Vec2 r = x.head<2>() - middle;
      n = r.dot(normal) > -1.4 * dx && std::abs(r.dot(along)) < 5.0 * dx
              ? node_of(velocity(x), mass > 0.0 ? mass : random_node(at, seed)[3])
              : Node{};
    });
    return grid;
  }
  Outline outline;
  Vec2 middle, along, normal;
};

constexpr double angles[] = {0.0, 0.3, -0.8};

TEST(SurfaceContactOfAFace, LeavesAFlowAlongItAlone) {
  for (const double angle : angles) {
    for (const double place : {0.0, 0.3}) {
      const Face face(angle, place);
      const auto sliding = [&](const Vec3& x) { return Vec3(7.0 * face.along.x(), 7.0 * face.along.y(), 2.0 + x.z()); };
      Grid before = face.filled(sliding), after = face.filled(sliding);
      apply_surface_contact(after, solid_of(face.outline));
      EXPECT_LE(largest_change(before, after), round_off) << angle;
    }
  }
}

TEST(SurfaceContactOfAFace, FrictionStaysInTheCoulombConeAndTakesAllOfItFromWhatSlides) {
  for (const double angle : angles) {
    for (const double mu : {0.15, 0.6}) {
      const Face face(angle);
      const Vec3 n(face.normal.x(), face.normal.y(), 0.0), t(face.along.x(), face.along.y(), 0.0);
      const auto any = [&](const Vec3& x) {
        return Vec3(
            velocity_of(random_node({static_cast<int>(std::lround(x.x() / dx)), static_cast<int>(std::lround(x.y() / dx)), 0}, 32)) -
            4.0 * n);
      };
      // so fast that no point sticks, not even at light nodes in the first sweeps
      const auto sliding = [&](const Vec3&) -> Vec3 { return -3.0 * n + 80.0 * t + 60.0 * Vec3::UnitZ(); };
      for (const bool slides : {false, true}) {
        Grid grid = slides ? face.filled(sliding) : face.filled(any);
        const ContactImpulse recorded = apply_surface_contact(grid, solid_of(face.outline, mu));
        int layers = 0;
        for (const Vec3& layer : recorded.layers().layer) {
          const double normal = -layer.dot(n), scale = layer.norm();
          const Vec3 tangential = layer + normal * n;
          EXPECT_GE(normal, 0.0);
          EXPECT_LE(tangential.norm(), mu * normal + round_off * scale);  // of every point, so of their sum
          if (slides && scale > 0.0) {
            ++layers;
            EXPECT_LE((tangential - mu * normal * (0.8 * t + 0.6 * Vec3::UnitZ())).norm(), round_off * scale);
          }
        }
        if (slides) {
          EXPECT_GT(layers, 8);
        }
      }
    }
  }
}

/// Docstring of contact_stencil.hpp: on a plane of nodes the points and the extension are the mirror image, which a folded wall is exactly.
TEST(SurfaceContactOfAFace, OnAPlaneOfNodesIsTheFoldedWall) {
  const Face face(0.0);
  const auto field = [&](const Vec3& x) { return Vec3(speed + 4.0 * std::sin(9.0 * x.x()), 2.0, 1.0); };
  const Wall wall{Vec3::Zero(), -Vec3::UnitX(), Contact::slip, 0.0, Vec3::Zero(), false, ContactRule::surface};
  Grid solid = face.filled(field, 0, 1.0), folded = face.filled(field, 0, 1.0);
  apply_surface_contact(solid, solid_of(face.outline));
  apply_folded_wall(folded, wall, {}, 0.0, folded.own_blocks());
  double worst = 0.0;
  for_each_node(solid, [&](Node& n, const Index3& at) {
    if (n[3] <= 0.0) return;
    if (std::abs(at[1]) <= 2) worst = std::max(worst, (velocity_of(n) - velocity_of(*find_node(folded, at))).norm());
  });
  // Points (1/8, 3/4, 1/8) and extension (1, -2, 1) are solved in turn; the cosine of the angle between them is
  // 1.25 / sqrt(0.594 6) = 0.662, and sweeps in alternating direction turn from one to the other once each: 0.662^6 = 8.4 % of the
  // speed are left.
  EXPECT_LE(worst, 0.084 * speed);
}

TEST(SurfaceContactOfAFace, LeavesMaterialAloneThatHardlyTouchesIt) {
  const Face face(0.0);
  const auto run = [&](double nearest) {  // nodes of one plane, one cell before the face: an eighth of a point's weight; or nodes on it
    Grid grid = face.filled([](const Vec3&) { return Vec3(speed, 0.0, 0.0); }, 33);
    for_each_node(grid, [&](Node& n, const Index3& at) {
      if (at[0] > nearest) n = Node{};
    });
    return grid;
  };
  Grid before = run(-1), after = run(-1);
  const ContactImpulse recorded = apply_surface_contact(after, solid_of(face.outline));
  EXPECT_EQ(largest_change(before, after), 0.0);
  EXPECT_TRUE(recorded.total().linear.isZero(0.0));
  Grid touching = run(0);
  EXPECT_GT(apply_surface_contact(touching, solid_of(face.outline)).total().linear.x(), 1.0);
}

TEST(SurfaceContactOfAFace, TakesNothingWhereThereIsNoMaterial) {
  Grid nowhere(dx), elsewhere = grid_of_blocks(dx, {10, 10, 10}, {10, 10, 10}), empty = grid_of_blocks(dx, low, high);
  for (Grid* grid : {&nowhere, &elsewhere, &empty}) {
    const ContactImpulse recorded = apply_surface_contact(*grid, solid_of(Face(0.0).outline));
    EXPECT_TRUE(recorded.total().linear.isZero(0.0));
    for (const Vec3& layer : recorded.layers().layer) EXPECT_TRUE(layer.isZero(0.0));
  }
}

TEST(ContactImpulseOfRanks, IsTheSumByLayerWhateverLayersEachHas) {
  ContactImpulse one, other, sum;
  one.side(3).linear = Vec3(3.0, 0.0, 0.0);
  one.side(1).linear = Vec3(1.0, 0.0, 0.0);  // below the first
  other.side(3).linear = Vec3(0.0, 4.0, 0.0);
  other.side(5).linear = Vec3(0.0, 5.0, 0.0);
  other.faces[0] = {{5, Impulse{.linear = Vec3(0.0, 0.0, 6.0)}}};
  sum += one;
  sum += other;
  const LayerImpulses layers = sum.layers();
  EXPECT_EQ(layers.first, 1);
  EXPECT_EQ(layers.layer,
            (std::vector{Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0), Vec3(3.0, 4.0, 0.0), Vec3(0.0, 0.0, 0.0), Vec3(0.0, 5.0, 6.0)}));
  EXPECT_EQ(sum.total().linear, Vec3(4.0, 9.0, 6.0));
}

}  // namespace
}  // namespace mpm
