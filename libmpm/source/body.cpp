#include "libmpm/source/body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/core/state.hpp"

namespace mpm {

namespace {

bool inside_shape(const BodySpec& body, const Vec3& x) {
  const Vec3 r = (2.0 * x - body.min - body.max).cwiseQuotient(body.max - body.min);  // -1 .. 1 within the bounding box
  switch (body.shape) {
    case BodySpec::Shape::cylinder: return r.head<2>().squaredNorm() <= 1.0;
    case BodySpec::Shape::sphere: return r.squaredNorm() <= 1.0;
    case BodySpec::Shape::box: break;
  }
  return true;
}

/// Shift of a lattice's layers against each other, in cells of the lattice: between -1/2 and 1/2 along the two axes across.
class Stagger {
 public:
  Stagger(const BodySpec& body) : staggered_(body.lattice == Lattice::staggered) {
    if (body.velocity.isZero(0.0)) return;
    body.velocity.cwiseAbs().maxCoeff(&axis_);
  }
  [[nodiscard]] Vec3 of(const std::array<long, 3>& index) const {
    Vec3 shift = Vec3::Zero();
    if (!staggered_) return shift;
    const R2Point point = r2_point(static_cast<double>(index[static_cast<std::size_t>(axis_)]));
    shift[(axis_ + 1) % 3] = point.a - 0.5;
    shift[(axis_ + 2) % 3] = point.b - 0.5;
    return shift;
  }

 private:
  bool staggered_;
  Eigen::Index axis_ = 2;
};

}  // namespace

double volume_of(const BodySpec& body) {
  const Vec3 size = body.max - body.min;
  switch (body.shape) {
    case BodySpec::Shape::cylinder: return 0.25 * std::numbers::pi * size.prod();
    case BodySpec::Shape::sphere: return std::numbers::pi / 6.0 * size.prod();
    case BodySpec::Shape::box: break;
  }
  return size.prod();
}

void BodySpec::check(ParameterReport& report) const {
  if (!report.all_valid({"min_m", "max_m"})) return;
  constexpr int digits = 9;
  for (int axis = 0; axis < 3; ++axis) {
    if (min[axis] < max[axis]) continue;
    return report.problem("max_m", std::string("is not above min_m in ") + "xyz"[axis] + ": " + number_text(max[axis], digits) +
                                       " <= " + number_text(min[axis], digits) + "; exchange them");
  }
}

namespace {

/// Calls f(position, fraction of its volume in the computed part) for the points of a body's lattice: a half on a mirror plane, where its
/// image adds the other half. @returns the number of points of the whole body
template <class F>
std::size_t for_each_point(const BodySpec& body, const MirrorPlanes& planes, double spacing, F&& f) {
  const Vec3 size = body.max - body.min;
  std::array<long, 3> count{};
  Vec3 step;
  for (int i = 0; i < 3; ++i) {
    count[static_cast<std::size_t>(i)] = std::max(1L, std::lround(size[i] / spacing));
    step[i] = size[i] / static_cast<double>(count[static_cast<std::size_t>(i)]);
  }
  const double on_plane = 1e-9 * spacing;  // lattice points are sums of rounded numbers
  const Stagger stagger(body);
  std::size_t whole = 0;
  const auto place = [&](const Vec3& middle, Vec3 shift) {
    if (planes.x) shift.x() *= middle.x() > on_plane ? 1.0 : middle.x() < -on_plane ? -1.0 : 0.0;
    if (planes.y) shift.y() *= middle.y() > on_plane ? 1.0 : middle.y() < -on_plane ? -1.0 : 0.0;
    Vec3 x = middle + step.cwiseProduct(shift);
    if (!inside_shape(body, x)) return;
    ++whole;
    double fraction = 1.0;
    for (const auto& [mirror, coordinate] : {std::pair{planes.x, &x.x()}, std::pair{planes.y, &x.y()}}) {
      if (!mirror || *coordinate > on_plane) continue;
      fraction *= *coordinate < -on_plane ? 0.0 : 0.5;
      *coordinate = 0.0;
    }
    if (fraction > 0.0) f(x, fraction);
  };
  for (long k = 0; k < count[2]; ++k) {
    for (long j = 0; j < count[1]; ++j) {
      for (long i = 0; i < count[0]; ++i) {
        const Vec3 middle =
            body.min + step.cwiseProduct(Vec3(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5, static_cast<double>(k) + 0.5));
        if (body.lattice != Lattice::random) {
          place(middle, stagger.of({i, j, k}));
          continue;
        }
        // a body that is symmetric about a plane has the same points on both sides; a quarter: half a cell is rounded
        const auto from_plane = [&](int axis) { return std::lround(std::floor(std::abs(middle[axis]) / step[axis] + 0.25)); };
        for (const Vec3& shift : random_points(planes.x ? from_plane(0) : i, planes.y ? from_plane(1) : j, k)) place(middle, shift);
      }
    }
  }
  return whole;
}

}  // namespace

std::size_t fill_body(State& state, const BodySpec& body, const Scene& scene, double spacing) {
  const std::size_t whole = for_each_point(body, scene.mirror, spacing, [](const Vec3&, double) {});
  if (whole == 0) return 0;
  std::vector<const Terrain*> grounds;
  for (const Boundary& boundary : scene.boundaries) {
    if (const auto* const terrain = std::get_if<Terrain>(&boundary)) grounds.push_back(terrain);
  }
  std::size_t buried = 0, filled = 0;  // points below the ground, and the others
  const double volume = volume_of(body) / static_cast<double>(whole);
  const double internal = initial_internal_of(scene.material);
  for_each_point(body, scene.mirror, spacing, [&](const Vec3& x, double fraction) {
    Particle p{};
    const Vec3 place = x + scene.offset;
    if (std::ranges::any_of(grounds, [&](const Terrain* ground) { return place.z() < ground->surface(place).height; })) {
      ++buried;
      return;
    }
    ++filled;
    for (int i = 0; i < 3; ++i) {
      p.position[i] = place[i];
      p.velocity[i] = body.velocity[i];
    }
    p.volume = fraction * volume;
    p.internal = internal;
    p.id = state.next_id++;
    state.grid.insert(p);
  });
  state.max_speed = std::max(state.max_speed, body.velocity.norm());
  return buried > 0 && filled == 0 ? 0 : whole;
}

bool meets_solid(const BodySpec& body, const UprightSolid& solid) {
  constexpr double inside = 1.0 - 1e-9;  // rounding of what touches
  if (body.min.z() >= solid.top || body.max.z() <= solid.base) return false;
  // in coordinates in which the body's bounding box is the cube -1 .. 1; a map by axes keeps the plan convex
  const Vec3 centre = 0.5 * (body.min + body.max), half = 0.5 * (body.max - body.min);
  std::vector<Vec2> corners;
  for (const Outline::Side& side : solid.outline.sides())
    corners.emplace_back((side.from - centre.head<2>()).cwiseQuotient(half.head<2>()));
  const Outline plan(corners);
  if ((plan.bounds().min().array() >= inside).any() || (plan.bounds().max().array() <= -inside).any()) return false;
  if (body.shape == BodySpec::Shape::box) {
    // separating axes: those of the box were tried, these are the plan's sides
    return std::ranges::none_of(plan.sides(),
                                [](const Outline::Side& side) { return -inside * side.normal.cwiseAbs().sum() - side.offset >= 0.0; });
  }
  const double gap = std::max(0.0, plan.distance(Vec2::Zero()));  // of the body's axis from the plan
  const double above = std::clamp(centre.z(), solid.base, solid.top) - centre.z();
  const double rise = body.shape == BodySpec::Shape::sphere ? above / half.z() : 0.0;
  return gap * gap + rise * rise < inside;
}

bool overlap(const BodySpec& a, const BodySpec& b) {
  const Vec3 low = a.min.cwiseMax(b.min), size = a.max.cwiseMin(b.max) - low;
  const double rounding = 1e-9 * (a.max - a.min).cwiseMax(b.max - b.min).maxCoeff();  // of bodies that touch
  if (size.minCoeff() <= rounding) return false;
  constexpr int points = 24;
  for (int i = 0; i < points * points * points; ++i) {
    const int row = i / points, layer = row / points;
    const Vec3 at(i % points + 0.5, row % points + 0.5, layer + 0.5);
    const Vec3 x = low + size.cwiseProduct(at / points);
    if (inside_shape(a, x) && inside_shape(b, x)) return true;
  }
  return false;
}

}  // namespace mpm
