#include "libmpm/boundary/contact_stencil.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <tuple>

#include "libmpm/boundary/shapes/any_shape.hpp"
#include "support/typical_shapes.hpp"

namespace mpm {
namespace {

constexpr double dx = 0.25;
using Kind = ContactRow::Kind;
using Place = std::array<int, 2>;

/// Outlines at several places on the grid.
struct Named {
  std::string name;
  Outline outline;
  bool symmetric;  ///< about y = 0
};
Outline moved(Outline outline, const Vec2& by) {
  outline.translate(by);
  return outline;
}
std::vector<Named> outlines() {
  std::vector<Named> all = {{"BoxOnNodes", BoxShape{.width = 2.0, .depth = 1.0}.outline(), true},
                            {"BoxBetweenNodes", BoxShape{.width = 1.75, .depth = 1.1}.outline(), true},
                            {"ThinBox", BoxShape{.width = 0.3, .depth = 0.1}.outline(), true},
                            {"SharpWedge", WedgeShape{.width = 1.0, .depth = 2.0}.outline(), true},
                            {"ThinCylinder", CylinderShape{.width = 0.3}.outline(), true}};
  for (const testing::TypicalShape& t : testing::typical_shapes()) all.push_back({t.name, outline_of(t.shape), t.outline().symmetric()});
  for (std::size_t i = 0, count = all.size(); i < count; ++i)
    all.push_back({all[i].name + "Moved", moved(all[i].outline, dx * Vec2(0.3, -0.7)), false});
  return all;
}
template <class Chosen>
std::vector<Named> outlines(Chosen&& chosen) {
  std::vector<Named> all = outlines();
  std::erase_if(all, [&](const Named& n) { return !chosen(n); });
  return all;
}

class Stencil : public ::testing::TestWithParam<Named> {
 protected:
  const Outline& outline = GetParam().outline;
  const ContactStencil whole = contact_stencil(outline, dx, {});
};
std::string name_of(const ::testing::TestParamInfo<Named>& test) { return test.param.name; }
INSTANTIATE_TEST_SUITE_P(Outlines, Stencil, ::testing::ValuesIn(outlines()), name_of);
// Tests of some outlines only.
class StencilOfAPolygon : public Stencil {};
INSTANTIATE_TEST_SUITE_P(Outlines, StencilOfAPolygon, ::testing::ValuesIn(outlines([](const Named& n) { return !n.outline.circle(); })),
                         name_of);
class StencilOfACircle : public Stencil {};
INSTANTIATE_TEST_SUITE_P(Outlines, StencilOfACircle,
                         ::testing::ValuesIn(outlines([](const Named& n) { return n.outline.circle().has_value(); })), name_of);
class SymmetricStencil : public Stencil {};
INSTANTIATE_TEST_SUITE_P(Outlines, SymmetricStencil, ::testing::ValuesIn(outlines([](const Named& n) { return n.symmetric; })), name_of);
void PrintTo(const Named& n, std::ostream* out) { *out << n.name; }

/// f(entry, its node) for the entries of a row.
template <class F>
void for_entries(const ContactStencil& stencil, const ContactRow& row, F&& f) {
  for (std::size_t e = row.first; e < row.first + row.count; ++e) {
    const ContactEntry& entry = stencil.entries[e];
    f(entry, stencil.nodes[static_cast<std::size_t>(entry.node)]);
  }
}
/// sum g_k v_k.n of a field of velocities.
template <class F>
double value_of(const ContactStencil& stencil, const ContactRow& row, F&& velocity) {
  double sum = 0.0;
  for_entries(stencil, row, [&](const ContactEntry& e, const auto& node) { sum += e.normal.dot(velocity(node.at)); });
  return sum;
}
Vec2 normal_of(const ContactStencil& stencil, const ContactRow& row) {
  Vec2 sum = Vec2::Zero();
  for_entries(stencil, row, [&](const ContactEntry& e, const auto&) { sum += e.normal; });
  return sum;
}
std::vector<std::size_t> rows_of(const ContactStencil& stencil, Kind kind) {
  std::vector<std::size_t> rows;
  for (std::size_t r = 0; r < stencil.rows.size(); ++r) {
    if (stencil.rows[r].kind == kind) rows.push_back(r);
  }
  return rows;
}
std::array<long, 2> key(const Vec2& x) { return {std::lround(1e9 * x.x()), std::lround(1e9 * x.y())}; }  // in nanometres

/// A linear field, and round-off for its sums: values up to 20 m/s, weights with an error of some 1e-16 times up to 10 cells.
Vec2 linear(const Vec2& x) { return Vec2(1.0 + 3.0 * x.x() - 2.0 * x.y(), -2.0 + 0.5 * x.x() + 4.0 * x.y()); }
constexpr double round_off = 1e-12;

TEST_P(StencilOfAPolygon, GivesTheVelocityAtAPointOnAFlatSide) {
  const auto rows = rows_of(whole, Kind::point);
  ASSERT_FALSE(rows.empty());
  for (const std::size_t r : rows) {
    const ContactRow& row = whole.rows[r];
    double weight = 0.0;
    Vec2 normal = Vec2::Zero(), tangent = Vec2::Zero();
    for_entries(whole, row, [&](const ContactEntry& e, const auto&) {
      weight += e.vertical;
      normal += e.normal;
      tangent += e.tangent;
      EXPECT_GT(e.vertical, 0.0);
    });
    EXPECT_NEAR(weight, 1.0, round_off);
    EXPECT_NEAR(normal.norm(), 1.0, round_off);
    EXPECT_LE((tangent - Vec2(-normal.y(), normal.x())).norm(), round_off);
    const auto near = outline.nearest(row.point + 1e-6 * normal);
    EXPECT_NEAR(outline.nearest(row.point).distance, 0.0, 1e-12) << "on the surface";
    EXPECT_LE((near.normal - normal).norm(), 1e-6) << "its own normal";
    EXPECT_NEAR(value_of(whole, row, [](const Place& at) { return linear(dx * Vec2(at[0], at[1])); }), normal.dot(linear(row.point)),
                round_off);
  }
}

TEST_P(StencilOfACircle, SeesTheNormalVelocityOfEachNode) {
  const Vec2 centre = outline.circle()->centre;
  const auto from_centre = [&](const Place& at) -> Vec2 { return dx * Vec2(at[0], at[1]) - centre; };
  const auto rows = rows_of(whole, Kind::point);
  ASSERT_FALSE(rows.empty());
  for (const std::size_t r : rows) {
    const ContactRow& row = whole.rows[r];
    const Vec2 normal = (row.point - centre).normalized();
    EXPECT_NEAR((row.point - centre).norm(), outline.circle()->radius, 1e-12) << "on the surface";
    double weight = 0.0, outward = 0.0;
    for_entries(whole, row, [&](const ContactEntry& e, const auto& node) {
      weight += e.vertical;
      EXPECT_GT(e.vertical, 0.0);
      const Vec2 away = from_centre(node.at);
      const Vec2 direction = away.norm() > 0.5 * dx ? Vec2(away.normalized()) : normal;  // no direction of its own at the centre
      outward += e.vertical * direction.dot(away);
      EXPECT_LE((e.normal - e.vertical * direction).norm(), round_off);
      EXPECT_LE((e.tangent - e.vertical * Vec2(-direction.y(), direction.x())).norm(), round_off);
    });
    EXPECT_NEAR(weight, 1.0, round_off);
    EXPECT_NEAR(value_of(whole, row, from_centre), outward, round_off) << "a flow away from the axis is seen in full";
    if (outline.circle()->radius < 2.0 * dx) continue;  // else nodes that take part are near the centre
    const auto along = [&](const Place& at) -> Vec2 {
      const Vec2 x = from_centre(at);
      return std::exp(3.0 * x.x()) * Vec2(-x.y(), x.x());
    };
    EXPECT_NEAR(value_of(whole, row, along), 0.0, round_off) << "a flow along the circle, however it speeds up, is not seen";
  }
}

TEST_P(Stencil, OfTheExtensionSeesNothingOfALinearField) {
  const auto rows = rows_of(whole, Kind::extension);
  for (const std::size_t r : rows) {
    const ContactRow& row = whole.rows[r];
    EXPECT_EQ(row.count, 3U);
    const double depth = -outline.nearest(row.point).distance / dx;
    EXPECT_GT(depth, 0.0) << "extends to nodes inside";
    EXPECT_LE(depth, 2.6 + 1e-9);
    double weight = 0.0, size = 0.0;
    for_entries(whole, row, [&](const ContactEntry& e, const auto&) {
      weight += e.vertical;
      size += std::abs(e.vertical);
    });
    EXPECT_EQ(weight, 0.0);
    EXPECT_EQ(size, 4.0);
    EXPECT_NEAR(value_of(whole, row, [](const Place& at) { return linear(dx * Vec2(at[0], at[1])); }), 0.0, round_off);
    const auto quadratic = [&](const Place& at) -> Vec2 {
      return (dx * Vec2(at[0], at[1]) - row.point).squaredNorm() * outline.nearest(row.point).normal;
    };
    EXPECT_NEAR(value_of(whole, row, quadratic), 2.0 * dx * dx, round_off) << "0, -2 of one cell, 1 of two";
  }
  // a node half a cell from being as near to another side has no direction to extend along: thin outlines are full of them
  if (GetParam().name.find("Thin") == std::string::npos && GetParam().name.find("Sharp") == std::string::npos) {
    EXPECT_GT(rows.size(), 3U);
  }
}

TEST_P(Stencil, HasItsPointsAboutACellApartAndInsideTheSidesOnACircleHalfACell) {
  std::vector<Vec2> points;
  for (const std::size_t r : rows_of(whole, Kind::point)) points.push_back(whole.rows[r].point);
  if (outline.circle()) {
    const double around = 2.0 * std::numbers::pi * outline.circle()->radius, count = static_cast<double>(points.size());
    // an even number, at least four
    if (around / dx > 2.0) {
      EXPECT_NEAR(2.0 * around / dx, count, 1.0);
    }
    for (std::size_t p = 0; p < points.size(); ++p) {
      const double chord = (points[p] - points[(p + 1) % points.size()]).norm();
      EXPECT_NEAR(chord, 2.0 * outline.circle()->radius * std::sin(std::numbers::pi / count), 1e-12);
    }
    return;
  }
  std::size_t all = 0;
  for (const Outline::Side& side : outline.sides()) {
    const Vec2 from = side.from, along = side.to - from;
    std::set<double> shares;
    for (const Vec2& point : points) {
      const double t = (point - from).dot(along) / along.squaredNorm();
      if (t > 0.0 && t < 1.0 && (point - from - t * along).norm() < 1e-9) shares.insert(t);
    }
    ASSERT_FALSE(shares.empty());
    all += shares.size();
    const double cells = along.norm() / dx;
    const double margin = cells - 2.0 * ContactStencil::edge_margin > 2.5 - 1e-9 ? ContactStencil::edge_margin : 0.0;  // of a long side
    if (margin > 0.0) {
      EXPECT_NEAR(*shares.begin() * cells, 0.5 * margin, 1e-9);
      EXPECT_NEAR((1.0 - *shares.rbegin()) * cells, 0.5 * margin, 1e-9);
      shares.erase(shares.begin());
      shares.erase(std::prev(shares.end()));
    }
    const auto count = static_cast<double>(shares.size());
    EXPECT_TRUE(count == 1.0 || std::abs(cells - 2.0 * margin - count) <= 0.5 + 1e-9) << "the nearest whole number of cells";
    EXPECT_LT(cells, count + 2.0 * margin + 0.5 + 1e-9);
    double i = 0.5;
    for (const double t : shares) EXPECT_NEAR(t * cells, margin + i++ * (cells - 2.0 * margin) / count, 1e-9);
  }
  EXPECT_EQ(all, points.size()) << "each on one side";
}

/// Integral of sqrt(s), by Simpson's rule in t = sqrt(s).
double root_integral(double from, double to) {
  const double a = std::sqrt(from), b = std::sqrt(to), m = 0.5 * (a + b);
  return (b - a) / 6.0 * (2.0 * a * a + 8.0 * m * m + 2.0 * b * b);
}

TEST_P(Stencil, ComparesTheEndsOfALongSideWithTheNextPointAndWithThatRoundTheEdge) {
  std::map<std::array<long, 2>, std::vector<std::size_t>> by_normal;
  for (const std::size_t r : rows_of(whole, Kind::point)) by_normal[key(normal_of(whole, whole.rows[r]))].push_back(r);
  const auto from_corner = [&](const Vec2& at) {
    double least = 1e9;
    for (const Outline::Side& side : outline.sides()) least = std::min(least, (side.from - at).norm());
    return least;
  };
  const auto row_at = [&](int number) -> const ContactRow& { return whole.rows[static_cast<std::size_t>(number)]; };
  std::size_t ends = 0, margins = 0;
  for (const auto& [normal, side] : by_normal) {
    for (const std::size_t r : side) {
      const ContactRow& row = whole.rows[r];
      if (side.size() < 3 || outline.circle()) {
        EXPECT_EQ(row.edge.neighbour, -1);
        continue;
      }
      if (row.edge.neighbour < 0) continue;
      const ContactRow& neighbour = row_at(row.edge.neighbour);
      if (key(normal_of(whole, neighbour)) != normal) {  // in the margin: as much as the end round the edge, by width
        ++margins;
        EXPECT_NEAR(row.width, ContactStencil::edge_margin * dx, 1e-12);
        EXPECT_NEAR(from_corner(row.point), 0.5 * row.width, 1e-9);
        EXPECT_LT(from_corner(neighbour.point), 1.5 * dx);
        EXPECT_NEAR(row.edge.at_rest, row.width / (neighbour.width - row.width), 1e-9) << "uniform pressure";
        EXPECT_TRUE(row.edge.in_margin());
        continue;
      }
      ++ends;
      EXPECT_FALSE(row.edge.in_margin());
      const Vec2 inner = neighbour.point, round = row_at(row.adjacent).point;
      EXPECT_NE(key(normal_of(whole, row_at(row.adjacent))), normal) << "on another side";
      // no end is nearer to the inner point, and the edge bounds the strip that reaches half-way to it
      const double gap = (inner - row.point).norm();
      const Vec2 edge = row.point + (row.width / gap - 0.5) * (row.point - inner);
      EXPECT_NEAR(row.edge.at_rest, row.width / gap, 1e-9) << "uniform pressure";
      EXPECT_NEAR(row.edge.free, root_integral(0.0, row.width) / root_integral(row.width, row.width + gap), 1e-9) << "a free jet";
      EXPECT_LE(from_corner(edge), 1e-9);
      EXPECT_LE((round - edge).norm(), 1.5 * dx + 1e-9) << "half a side of one point, which has less than 3 cells";
    }
  }
  std::size_t long_sides = 0, with_margins = 0;
  for (const auto& [normal, side] : by_normal) {
    long_sides += side.size() >= 3 && !outline.circle();
    with_margins += side.size() >= 5 && !outline.circle();  // three, and one in each margin
  }
  EXPECT_EQ(ends, 2 * long_sides);
  EXPECT_EQ(margins, 2 * with_margins);
}

TEST_P(Stencil, KnowsTheNodesInsideAndThoseBeyondTheReachOfItsPoints) {
  std::set<Place> columns, deep;
  for (const auto& c : whole.columns) EXPECT_TRUE(columns.insert(whole.nodes[static_cast<std::size_t>(c.node)].at).second);
  for (const auto& d : whole.deep) {
    EXPECT_TRUE(deep.insert(whole.nodes[static_cast<std::size_t>(d.node)].at).second);
    EXPECT_NEAR(d.normal.norm(), 1.0, 1e-12);
  }
  std::set<Place> reached;
  for (const std::size_t r : rows_of(whole, Kind::point))
    for_entries(whole, whole.rows[r], [&](const ContactEntry&, const auto& node) { reached.insert(node.at); });
  for (int x = -20; x < 30; ++x) {
    for (int y = -20; y < 20; ++y) {
      const double outside = outline.nearest(dx * Vec2(x, y)).distance / dx, depth = -outside;
      if (std::abs(outside - 0.5) > 1e-6) {
        EXPECT_EQ(columns.contains({x, y}), outside < 0.5);
      }
      if (depth > 2.6) {
        EXPECT_TRUE(deep.contains({x, y})) << "nothing else holds it";
      }
      // a B-spline reaches 1.5 cells along each axis, of a slanting side up to sqrt(2) times as deep
      if (depth > 1.5 * std::numbers::sqrt2 + 1e-6) {
        EXPECT_FALSE(reached.contains({x, y}));
      }
      if (deep.contains({x, y})) {
        EXPECT_GT(depth, 1.5);
      }
    }
  }
  for (const auto& node : whole.nodes) EXPECT_EQ(node.computed, 1.0);
  std::set<Place> nodes;
  for (const auto& node : whole.nodes) EXPECT_TRUE(nodes.insert(node.at).second) << "each node once";
}

/// The bounds of a column near a side are what it has to carry: its strip of at most a cell, under two pressures.
TEST_P(Stencil, BoundsTheColumnsOfItsTopAtEdgesByTheirStrips) {
  const auto carried = [](double depth) { return std::min(depth + 0.5, 1.0); };
  const auto root_law = [](double depth) { return root_integral(std::max(0.0, depth - 0.5), depth + 0.5); };
  const auto depth_of = [&](const ContactStencil::Column& c) {
    const Place& at = whole.nodes[static_cast<std::size_t>(c.node)].at;
    return -outline.nearest(dx * Vec2(at[0], at[1])).distance / dx;
  };
  int bounded = 0;
  bool has_inside = false;
  for (std::size_t i = 0; i < whole.columns.size(); ++i) {
    const ContactStencil::Column& column = whole.columns[i];
    const double depth = depth_of(column);
    has_inside |= depth > 1.0;
    if (depth > 0.5 + 1e-6) {
      EXPECT_EQ(column.edge.neighbour, -1) << "only the last before an edge";
    }
    if (column.edge.neighbour < 0) continue;
    ++bounded;
    ASSERT_LT(column.edge.neighbour, static_cast<int>(i)) << "what bounds is known before what is bounded";
    const ContactStencil::Column& inner = whole.columns[static_cast<std::size_t>(column.edge.neighbour)];
    const Place &here = whole.nodes[static_cast<std::size_t>(column.node)].at,
                &there = whole.nodes[static_cast<std::size_t>(inner.node)].at;
    EXPECT_LE(std::max(std::abs(here[0] - there[0]), std::abs(here[1] - there[1])), 1) << "neighbours";
    EXPECT_GT(depth_of(inner), depth);
    EXPECT_NEAR(column.edge.at_rest, carried(depth) / carried(depth_of(inner)), 1e-9) << "uniform pressure";
    EXPECT_NEAR(column.edge.free, root_law(depth) / root_law(depth_of(inner)), 1e-9) << "a free jet";
    EXPECT_NEAR(column.strip, (depth + 0.5) * dx, 1e-9);
  }
  if (has_inside) {
    EXPECT_GT(bounded, 8);
  }
}

/// On planes of nodes a point has the weights 1/8, 3/4, 1/8 across the side, and the row of nodes behind extends the other two: what a
/// mirror image needs.
TEST(Stencils, OfABoxOnPlanesOfNodesAreSymmetricAboutItsSides) {
  const ContactStencil stencil = contact_stencil(BoxShape{.width = 2.0, .depth = 1.0}.outline(), dx, {false, false});
  EXPECT_EQ(rows_of(stencil, Kind::point).size(), 2U * (8U + 4U) + 8U) << "one in each margin, too";
  EXPECT_EQ(stencil.columns.size(), 5U * 9U);
  for (const std::size_t r : rows_of(stencil, Kind::point)) {
    const ContactRow& row = stencil.rows[r];
    const Vec2 normal = normal_of(stencil, row), at = row.point / dx;
    std::map<long, double> across;
    double along = 0.0;
    for_entries(stencil, row, [&](const ContactEntry& e, const auto& node) {
      const Vec2 arm = Vec2(node.at[0], node.at[1]) - at;
      across[std::lround(arm.dot(normal))] += e.vertical;
      along += e.vertical * arm.dot(Vec2(-normal.y(), normal.x()));
    });
    ASSERT_EQ(across.size(), 3U);
    EXPECT_NEAR(across[0], 0.75, 1e-12);
    EXPECT_NEAR(across[-1], 0.125, 1e-12);
    EXPECT_NEAR(across[1], 0.125, 1e-12);
    EXPECT_NEAR(along, 0.0, 1e-12) << "the point is where its nodes say";
  }
  std::set<Place> extended;
  for (const std::size_t r : rows_of(stencil, Kind::extension)) {
    const Vec2 at = stencil.rows[r].point / dx;
    extended.insert({static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y()))});
  }
  for (int y = -2; y <= 2; ++y) EXPECT_TRUE(extended.contains({1, y}) && extended.contains({3, y})) << y;  // front and back
}

/// Every row has its image among the rows, with the images of its entries.
TEST_P(SymmetricStencil, HasTheImageOfEveryRow) {
  const auto name = [&](const ContactRow& row, double sign) { return std::tuple(row.kind, key({row.point.x(), sign * row.point.y()})); };
  std::map<std::tuple<Kind, std::array<long, 2>>, std::map<Place, ContactEntry>> rows;
  for (const ContactRow& row : whole.rows) {
    auto [entries, made] = rows.try_emplace(name(row, 1.0));
    EXPECT_TRUE(made);
    for_entries(whole, row, [&entries = entries](const ContactEntry& e, const auto& node) { entries->second[node.at] = e; });
  }
  for (const ContactRow& row : whole.rows) {
    const auto image = rows.find(name(row, -1.0));
    ASSERT_NE(image, rows.end()) << row.point.transpose() << " of kind " << static_cast<int>(row.kind);
    EXPECT_EQ(image->second.size(), row.count);
    for_entries(whole, row, [&](const ContactEntry& e, const auto& node) {
      const auto other = image->second.find({node.at[0], -node.at[1]});
      ASSERT_NE(other, image->second.end());
      EXPECT_NEAR(other->second.vertical, e.vertical, 1e-12);
      EXPECT_NEAR(other->second.normal.x(), e.normal.x(), 1e-12);
      EXPECT_NEAR(other->second.normal.y(), -e.normal.y(), 1e-12);
      EXPECT_NEAR(other->second.tangent.x(), -e.tangent.x(), 1e-12);
      EXPECT_NEAR(other->second.tangent.y(), e.tangent.y(), 1e-12);
    });
  }
}

TEST_P(SymmetricStencil, HoldsDeepNodesSymmetrically) {
  std::map<Place, Vec2> deep;
  for (const auto& d : whole.deep) deep[whole.nodes[static_cast<std::size_t>(d.node)].at] = d.normal;
  for (const auto& [at, normal] : deep) {
    ASSERT_TRUE(deep.contains({at[0], -at[1]}));
    if (at[1] == 0) continue;  // there the velocity across is zero
    EXPECT_LE((deep.at({at[0], -at[1]}) - Vec2(normal.x(), -normal.y())).norm(), 1e-12) << at[0] << ", " << at[1];
  }
}

/// Half of a symmetric outline, with what is behind the mirror plane replaced by its image, against the whole: the same rows give the same
/// values of a symmetric field, and their impulses the same changes of velocity.
TEST_P(SymmetricStencil, AtAMirrorPlaneAddsTheImagesOfTheWholeStencil) {
  const ContactStencil half = contact_stencil(outline, dx, {false, true});
  const auto field = [](const Place& at) {
    std::minstd_rand random(static_cast<unsigned>(1000 * (at[0] + 100) + std::abs(at[1]) + 1));
    random.discard(10);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const double x = unit(random), y = unit(random);
    return Vec2(x, at[1] < 0 ? -y : at[1] == 0 ? 0.0 : y);
  };
  const auto impulse = [](const Vec2& point) { return std::sin(7.0 * point.x()) + std::cos(5.0 * std::abs(point.y())); };  // of a row
  std::map<std::tuple<Kind, std::array<long, 2>>, const ContactRow*> rows;
  std::map<Place, Vec2> given, given_along;  // N s, by all rows
  std::size_t computed = 0;
  for (const ContactRow& row : whole.rows) {
    rows[{row.kind, key(row.point)}] = &row;
    computed += row.point.y() > -1e-9;
    // the image of a tangent points the other way: its impulse is the opposite, and zero on the plane
    const double side = std::abs(row.point.y()) < 1e-9 ? 0.0 : row.point.y() > 0.0 ? 1.0 : -1.0;
    for_entries(whole, row, [&](const ContactEntry& e, const auto& node) {
      given.try_emplace(node.at, Vec2::Zero()).first->second += impulse(row.point) * e.normal;
      given_along.try_emplace(node.at, Vec2::Zero()).first->second += side * impulse(row.point) * e.tangent;
    });
  }
  EXPECT_EQ(half.rows.size(), computed);
  std::map<Place, Vec2> given_to_half, given_to_half_along;
  for (const ContactRow& row : half.rows) {
    const auto found = rows.find({row.kind, key(row.point)});
    ASSERT_NE(found, rows.end()) << row.point.transpose();
    EXPECT_NEAR(value_of(half, row, field), value_of(whole, *found->second, field), round_off) << row.point.transpose();
    const bool on_plane = std::abs(row.point.y()) < 1e-9;
    EXPECT_EQ(row.computed, on_plane ? 0.5 : 1.0);
    for_entries(half, row, [&](const ContactEntry& e, const auto& node) {
      const double factor = impulse(row.point) * row.computed / node.computed;
      given_to_half.try_emplace(node.at, Vec2::Zero()).first->second += factor * e.normal;
      given_to_half_along.try_emplace(node.at, Vec2::Zero()).first->second += (on_plane ? 0.0 : factor) * e.tangent;
    });
  }
  for (const auto& node : half.nodes) {
    EXPECT_GE(node.at[1], 0);
    EXPECT_EQ(node.computed, node.at[1] == 0 ? 0.5 : 1.0);
  }
  for (const auto& [at, p] : given) {
    if (at[1] < 0) continue;
    const auto found = given_to_half.find(at);
    const Vec2 q = found == given_to_half.end() ? Vec2::Zero() : found->second;
    const auto along = given_to_half_along.find(at);
    const Vec2 t = along == given_to_half_along.end() ? Vec2::Zero() : along->second;
    EXPECT_LE((p - q).norm(), round_off) << at[0] << ", " << at[1];
    EXPECT_LE((given_along.at(at) - t).norm(), round_off) << at[0] << ", " << at[1];
  }
}

TEST(Stencils, LeaveRowsBehindMirrorPlanesOutAlongBothAxes) {
  Outline box = BoxShape{.width = 2.0, .depth = 2.0}.outline();
  box.translate({-1.0, 0.0});  // symmetric about both
  const ContactStencil whole = contact_stencil(box, dx, {false, false}), quarter = contact_stencil(box, dx, {true, true});
  EXPECT_EQ(4U * rows_of(quarter, Kind::point).size(), rows_of(whole, Kind::point).size());  // no point on a plane: eight on a side
  for (const auto& node : quarter.nodes) {
    EXPECT_TRUE(node.at[0] >= 0 && node.at[1] >= 0);
    EXPECT_EQ(node.computed, (node.at[0] == 0 ? 0.5 : 1.0) * (node.at[1] == 0 ? 0.5 : 1.0));
  }
}

}  // namespace
}  // namespace mpm
