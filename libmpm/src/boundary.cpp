#include "mpm/boundary.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace mpm {

namespace {

constexpr double on_plane = 1e-9;  // m; a node this close counts as on the plane: coordinates are sums of rounded multiples of dx

}  // namespace

Vec3 contact_velocity(const Vec3& velocity, const Vec3& normal, const Vec3& surface_velocity, Contact contact, double friction) {
  if (contact == Contact::no_slip) return surface_velocity;
  const Vec3 relative = velocity - surface_velocity;
  const double approach = relative.dot(normal);
  if (approach >= 0.0 && contact == Contact::separable) return velocity;
  Vec3 tangential = relative - approach * normal;
  if (friction > 0.0 && approach < 0.0) {
    const double speed = tangential.norm();
    const double loss = -friction * approach;
    tangential *= speed > loss ? 1.0 - loss / speed : 0.0;
  }
  return surface_velocity + tangential;
}

bool Wall::covers(const Vec3& node, double time) const {
  const double shift = travels ? time * velocity.dot(normal) : 0.0;
  return (node - point).dot(normal) - shift <= on_plane;
}

bool Wall::reaches(const Vec3& low, const Vec3& high, double time) const {
  Vec3 deepest;
  for (int i = 0; i < 3; ++i) deepest[i] = normal[i] > 0.0 ? low[i] : high[i];
  return covers(deepest, time);
}

Vec3 Wall::constrain(const Vec3&, const Vec3& v, double) const { return contact_velocity(v, normal, velocity, contact, friction); }

Vec3 Belt::constrain(const Vec3& node, const Vec3& v, double time) const {
  return contact_velocity(v, plane.normal, surface_velocity(node, time), plane.contact, plane.friction);
}

bool RigidBox::covers(const Vec3& node, double) const {
  return ((node - min).array() >= -on_plane).all() && ((max - node).array() >= -on_plane).all();
}

bool RigidBox::reaches(const Vec3& low, const Vec3& high, double) const {
  return ((high - min).array() >= -on_plane).all() && ((max - low).array() >= -on_plane).all();
}

Vec3 RigidBox::constrain(const Vec3& node, const Vec3& v, double) const {
  // depth below each face; the first of equals wins, so the order here is the order of precedence on edges
  struct Face {
    double depth;
    Vec3 normal;
  };
  const Face faces[] = {{node.x() - min.x(), -Vec3::UnitX()},
                        {max.x() - node.x(), Vec3::UnitX()},
                        {node.y() - min.y(), -Vec3::UnitY()},
                        {max.y() - node.y(), Vec3::UnitY()},
                        {max.z() - node.z(), Vec3::UnitZ()}};
  const Face* nearest = faces;
  for (const Face& face : faces) {
    if (face.depth < nearest->depth - on_plane) nearest = &face;
  }
  return contact_velocity(v, nearest->normal, Vec3::Zero(), contact, friction);
}

namespace {

bool below_top(const Upright& solid, double z) { return z <= solid.top + on_plane; }

/// The velocity that the nearest face leaves, `distance` in front of the nearest side (negative inside) being that side's.
Vec3 constrain_upright(const Upright& solid, const Vec3& node, const Vec3& v, double distance, const Vec3& side_normal) {
  const bool top = node.z() - solid.top > distance + on_plane;
  return contact_velocity(v, top ? Vec3::UnitZ() : side_normal, Vec3::Zero(), solid.contact, solid.friction);
}

}  // namespace

bool RigidPrism::reaches(const Vec3& low, const Vec3& high, double) const {
  const double reach = solid.skin + on_plane;
  return low.x() <= max_x + reach && high.x() >= min_x - reach && low.y() <= max_y + reach && high.y() >= min_y - reach &&
         below_top(solid, low.z());
}

bool RigidPrism::covers(const Vec3& node, double time) const {
  if (!reaches(node, node, time)) return false;
  return std::all_of(sides.begin(), sides.end(), [&](const Side& side) {
    return side.normal_x * node.x() + side.normal_y * node.y() - side.offset <= solid.skin + on_plane;
  });
}

Vec3 RigidPrism::constrain(const Vec3& node, const Vec3& v, double) const {
  const auto distance_to = [&](const Side& side) { return side.normal_x * node.x() + side.normal_y * node.y() - side.offset; };
  double nearest = distance_to(sides.front());
  for (const Side& side : sides) nearest = std::max(nearest, distance_to(side));
  Vec3 normal = Vec3::Zero();
  for (const Side& side : sides) {
    if (distance_to(side) >= nearest - on_plane) normal += Vec3(side.normal_x, side.normal_y, 0.0);
  }
  // opposite sides of a thin plate cancel: then the first of them
  if (normal.squaredNorm() < 1e-12) normal = Vec3(sides.front().normal_x, sides.front().normal_y, 0.0);
  return constrain_upright(solid, node, v, nearest, normal.normalized());
}

bool RigidCylinder::reaches(const Vec3& low, const Vec3& high, double) const {
  const double reach = radius + solid.skin + on_plane;
  return low.x() <= centre_x + reach && high.x() >= centre_x - reach && low.y() <= centre_y + reach && high.y() >= centre_y - reach &&
         below_top(solid, low.z());
}

bool RigidCylinder::covers(const Vec3& node, double) const {
  return below_top(solid, node.z()) && std::hypot(node.x() - centre_x, node.y() - centre_y) <= radius + solid.skin + on_plane;
}

Vec3 RigidCylinder::constrain(const Vec3& node, const Vec3& v, double) const {
  const Vec3 arm(node.x() - centre_x, node.y() - centre_y, 0.0);
  const double r = arm.norm();
  // on the axis every direction is as near: upstream
  return constrain_upright(solid, node, v, r - radius, r > on_plane ? Vec3(arm / r) : Vec3(-Vec3::UnitX()));
}

namespace {

/// Calls f(nodes, nodes behind or null, stride, flip) for every block at the mirror plane of `axis`: `stride` from a node to the next along
/// the axis, `flip` turns a node into its image.
template <class F>
void for_each_mirrored_block(Grid& grid, int axis, F&& f) {
  const int stride = axis == 0 ? 1 : 4;
  const auto slot = static_cast<std::size_t>(axis == 0 ? neighbour_slot(-1, 0, 0) : neighbour_slot(0, -1, 0));
  Node flip = {1, 1, 1, 1};
  flip[axis] = -1.0;
  for (const auto index : grid.all_blocks()) {
    const Block& block = grid.block(index);
    if (block.coordinate[static_cast<std::size_t>(axis)] != 0) continue;
    const std::int32_t behind = block.neighbour[slot];
    f(grid.nodes(index).node, behind == no_block ? nullptr : grid.nodes(behind).node, stride, flip);
  }
}

/// Adds the image of the plane behind (axis index -1) to the plane at +1, doubles the mirror plane, and sets the plane behind to the image.
void fold(Grid& grid, int axis) {
  for_each_mirrored_block(grid, axis, [](Node* nodes, Node* behind, int stride, Node flip) {
    for (int n = 0; n < block_nodes; ++n) {
      if ((n / stride) % 4 != 0) continue;
      nodes[n] += flip * nodes[n];
      if (behind == nullptr) continue;
      Node& image = behind[n + 3 * stride];
      nodes[n + stride] += flip * image;
      image = flip * nodes[n + stride];
    }
  });
}

/// Sets the plane behind to the image of the plane at +1 again, whose velocities a boundary may have changed.
void reflect(Grid& grid, int axis) {
  for_each_mirrored_block(grid, axis, [](const Node* nodes, Node* behind, int stride, Node flip) {
    for (int n = 0; behind != nullptr && n < block_nodes; ++n) {
      if ((n / stride) % 4 == 0) behind[n + 3 * stride] = flip * nodes[n + stride];
    }
  });
}

/// Adds what each block booked in its four layers, in the order of the blocks.
LayerImpulses sum_of_layers(const Grid& grid, const std::vector<Vec3>& partial) {
  constexpr std::int32_t edge = block_edge;
  const auto all = grid.all_blocks();
  const auto took = [&](std::size_t i) {
    return std::any_of(&partial[edge * i], &partial[edge * i] + edge, [](const Vec3& v) { return !v.isZero(0.0); });
  };
  std::int32_t lowest = 0, highest = -1;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!took(i)) continue;
    const std::int32_t z = grid.block(all[i]).coordinate[2];
    if (highest < lowest) lowest = highest = z;
    lowest = std::min(lowest, z);
    highest = std::max(highest, z);
  }
  LayerImpulses sum;
  sum.first = edge * lowest;
  sum.layer.assign(static_cast<std::size_t>(edge * (highest - lowest + 1)), Vec3::Zero());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!took(i)) continue;
    const auto base = static_cast<std::size_t>(edge * (grid.block(all[i]).coordinate[2] - lowest));
    for (std::size_t k = 0; k < edge; ++k) sum.layer[base + k] += partial[edge * i + k];
  }
  return sum;
}

}  // namespace

void fold_mirror_planes(Grid& grid, bool mirror_x, bool mirror_y) {
  if (mirror_x) fold(grid, 0);
  if (mirror_y) fold(grid, 1);
}

double update_grid(Grid& grid, std::span<const Boundary> boundaries, const Vec3& gravity, double dt, double time, bool mirror_x,
                   bool mirror_y, std::vector<Impulse>& impulses, std::optional<std::size_t> layered, LayerImpulses* layers) {
  const auto all = grid.all_blocks();
  const std::size_t count = boundaries.size();
  std::vector<Impulse> partial(all.size() * count);
  constexpr std::size_t layers_per_block = 4;
  std::vector<Vec3> layer_partial(layered && layers != nullptr ? layers_per_block * all.size() : 0, Vec3::Zero());
  std::vector<double> mass(all.size(), 0.0);
  const double dx = grid.cell_size();
  const Node acceleration = {dt * gravity.x(), dt * gravity.y(), dt * gravity.z(), 0.0};
#pragma omp parallel for schedule(static, 8)
  for (std::size_t i = 0; i < all.size(); ++i) {
    NodeBlock& nodes = grid.nodes(all[i]);
    const Index3& c = grid.block(all[i]).coordinate;
    const bool halved = (mirror_x && c[0] <= 0) || (mirror_y && c[1] <= 0);
    // share of a node that belongs to the computed part: none behind a mirror plane, half on it
    const auto share_of = [&](int n) {
      double share = 1.0;
      if (mirror_x) share *= c[0] < 0 ? 0.0 : c[0] == 0 && (n & 3) == 0 ? 0.5 : 1.0;
      if (mirror_y) share *= c[1] < 0 ? 0.0 : c[1] == 0 && (n >> 2 & 3) == 0 ? 0.5 : 1.0;
      return share;
    };
    for (int i_node = 0; i_node < block_nodes; ++i_node) {
      Node& n = nodes.node[i_node];
      const double m = n[3];
      mass[i] += halved ? share_of(i_node) * m : m;
      Node v = n * (m > 0.0 ? 1.0 / m : 0.0) + acceleration;
      v[3] = m;
      n = v;
    }
    const Vec3 low = 4.0 * dx * Vec3(c[0], c[1], c[2]);
    const Vec3 high = low + Vec3::Constant(3.0 * dx);
    for (std::size_t b = 0; b < count; ++b) {
      std::visit(
          [&](const auto& boundary) {
            if (!boundary.reaches(low, high, time)) return;
            Impulse& impulse = partial[i * count + b];
            Vec3* const layer = !layer_partial.empty() && b == *layered ? &layer_partial[layers_per_block * i] : nullptr;
            for (int n = 0; n < block_nodes; ++n) {
              Node& node = nodes.node[n];
              if (node[3] <= 0.0) continue;
              const Vec3 position = dx * Vec3(4 * c[0] + (n & 3), 4 * c[1] + (n >> 2 & 3), 4 * c[2] + (n >> 4));
              if (!boundary.covers(position, time)) continue;
              const Vec3 before(node[0], node[1], node[2]);
              const Vec3 after = boundary.constrain(position, before, time);
              const Vec3 taken = (halved ? share_of(n) : 1.0) * node[3] * (before - after);
              impulse.linear += taken;
              impulse.work -= taken.dot(boundary.surface_velocity(position, time));
              if (layer != nullptr) layer[n >> 4] += taken;
              impulse.angular += (position - boundary.reference_point()).cross(taken);
              node = Node{after.x(), after.y(), after.z(), node[3]};
            }
          },
          boundaries[b]);
    }
  }
  if (mirror_x) reflect(grid, 0);
  if (mirror_y) reflect(grid, 1);
  impulses.assign(count, Impulse{});
  double total = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    total += mass[i];
    for (std::size_t b = 0; b < count; ++b) impulses[b] += partial[i * count + b];
  }
  if (!layer_partial.empty()) *layers = sum_of_layers(grid, layer_partial);
  return total;
}

}  // namespace mpm
