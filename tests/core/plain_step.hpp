#pragma once
/// The whole step once more, written to be read: one particle after the other, a map of nodes, scalar numbers, textbook formulas. It shares
/// no code with the library's step; what it takes from the library is the description of the scene and, of a solid that acts at its
/// surface, where its points are (ContactStencil). A newcomer can learn the method here.
///
/// Not in it: sources, solids with a top within reach of the material, Wall::speed, prisms and cylinders that act on nodes, mirror planes
/// beside a solid that acts at its surface.

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

#include "libmpm/base/bspline.hpp"
#include "libmpm/core/state.hpp"

namespace mpm::plain {

/// A particle. The elastic state is the left Cauchy-Green tensor, not the stress as in the library.
struct Particle {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
  Mat3 c = Mat3::Zero();        ///< C_p, 1/s
  Mat3 b_e = Mat3::Identity();  ///< elastic left Cauchy-Green tensor
  Mat3 tau = Mat3::Zero();      ///< Kirchhoff stress, Pa
  double internal = 0.0;        ///< X; of a fluid J - 1
  double ratio = 1.0;           ///< J
  double volume = 0.0;          ///< of the reference, m^3
  std::size_t id = 0;           ///< for results by particle; the step does not use it
};

/// Hencky's elasticity, tau = K tr(eps) I + 2 G dev(eps), eps = 1/2 log b_e, and a plastic correction of (p, q): principal directions stay.
/// A fluid has a pressure instead.
struct Law {
  double density = 0.0, bulk = 0.0, shear = 0.0;
  double initial_internal = 0.0;
  struct Invariants {
    double p, q, internal;
  };
  /// Returns a trial state (p, q, X) to the yield surface; empty: elastic. @param pressure_before  of the state before the step
  std::function<Invariants(const Invariants& trial, double pressure_before)> correct;
  /// Of a fluid: Cauchy's pressure at J, Pa. Empty: a solid
  std::function<double(double ratio)> pressure;

  [[nodiscard]] double wave_speed() const { return std::sqrt((bulk + 4.0 / 3.0 * shear) / density); }

  void update(Particle& p, double dt) const {
    const Mat3 f = Mat3::Identity() + dt * p.c;
    p.ratio *= f.determinant();
    if (pressure) {
      p.internal = p.ratio - 1.0;
      p.tau = -p.ratio * pressure(p.ratio) * Mat3::Identity();
      return;
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(f * p.b_e * f.transpose());
    Vec3 strain = 0.5 * eigen.eigenvalues().array().log().matrix();
    double volumetric = strain.sum();
    Vec3 deviator = strain - Vec3::Constant(volumetric / 3.0);
    if (correct) {
      const double q = std::sqrt(6.0) * shear * deviator.norm();
      const Invariants r = correct({-bulk * volumetric, q, p.internal}, -p.tau.trace() / 3.0);
      volumetric = -r.p / bulk;
      deviator *= q > 0.0 ? r.q / q : 0.0;
      p.internal = r.internal;
      strain = deviator + Vec3::Constant(volumetric / 3.0);
    }
    const Vec3 stress = Vec3::Constant(bulk * volumetric) + 2.0 * shear * deviator;
    const Mat3& n = eigen.eigenvectors();
    p.b_e = n * (2.0 * strain).array().exp().matrix().asDiagonal() * n.transpose();
    p.tau = n * stress.asDiagonal() * n.transpose();
  }

  /// b_e at a Kirchhoff stress: Hencky's law the other way round.
  [[nodiscard]] Mat3 elastic_state(const Mat3& tau) const {
    const Mat3 mean = tau.trace() / 3.0 * Mat3::Identity();
    const Eigen::SelfAdjointEigenSolver<Mat3> strain(mean / (3.0 * bulk) + (tau - mean) / (2.0 * shear));
    const Mat3& n = strain.eigenvectors();
    return n * (2.0 * strain.eigenvalues()).array().exp().matrix().asDiagonal() * n.transpose();
  }
};

inline Law elastic(double density, double young, double poisson) {
  return {density, young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson)), 0.0, {}, {}};
}

/// Tait's fluid without viscosity, p = K/n (J^-n - 1).
inline Law fluid(double density, double bulk, int exponent, bool carries_tension) {
  Law law{density, bulk, 0.0, 0.0, {}, {}};
  law.pressure = [=](double ratio) {
    const double p = bulk / exponent * (std::pow(ratio, -exponent) - 1.0);
    return carries_tension ? p : std::max(p, 0.0);
  };
  return law;
}

/// Root of f, which changes its sign between a and b, by bisection to the last bit.
template <class F>
double bisect(const F& f, double a, double b) {
  const bool rising = f(a) < 0.0;
  for (int i = 0; i < 400; ++i) {
    const double middle = 0.5 * (a + b);
    if (middle == a || middle == b) break;
    ((f(middle) < 0.0) == rising ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

/// Cohesive Modified Cam-Clay, M > 0: the state returns along the flow rule of backward Euler to the first place where it is on the yield
/// surface, X = X_n + d, p = p_tr - K d, q = q_tr/(1 + 6 G (1 + 2 beta) d/y_p).
inline Law cam_clay(double density, double young, double poisson, double slope, double beta, double xi, double pc0) {
  Law law = elastic(density, young, poisson);
  const double bulk = law.bulk, shear = law.shear, m2 = slope * slope;
  law.initial_internal = std::asinh(pc0 / bulk) / xi;
  law.correct = [=](const Law::Invariants& t, double) -> Law::Invariants {
    const auto hardness = [&](double x) { return bulk * std::sinh(xi * std::max(x, 0.0)); };
    const auto yield = [&](double p, double q, double pc) { return q * q * (1.0 + 2.0 * beta) + m2 * (p + beta * pc) * (p - pc); };
    const double pc_n = hardness(t.internal);
    if (yield(t.p, t.q, pc_n) <= 1e-13 * m2 * pc_n * pc_n) return t;
    const auto slope_p = [&](double d) { return m2 * (2.0 * (t.p - bulk * d) - (1.0 - beta) * hardness(t.internal + d)); };
    const auto q_at = [&](double d) { return t.q / (1.0 + 6.0 * shear * (1.0 + 2.0 * beta) * d / slope_p(d)); };
    const auto residual = [&](double d) { return yield(t.p - bulk * d, q_at(d), hardness(t.internal + d)); };
    const double to_loose = -(t.internal + t.p / bulk);  // volume that is missing for any pressure
    const Law::Invariants stress_free{0.0, 0.0, -to_loose};
    if (t.internal <= 0.0 && to_loose >= 0.0) return stress_free;
    // what is expanded is first compressed, without resistance, to X = 0
    const double base = std::max(0.0, -t.internal);
    if (slope_p(base) >= 0.0) {
      double far = t.p / bulk;  // p = 0; y_p vanishes before
      far = bisect(slope_p, base, far);
      const double d = bisect(residual, base, std::nextafter(far, base));
      return {t.p - bulk * d, q_at(d), t.internal + d};
    }
    // dilation: the first of possibly several roots, looked for where the rest of the way falls in equal ratios, because a root may lie
    // close to where all hardness is lost; none: all stress is lost
    const double reach = std::min(t.internal, -slope_p(0.0) / (2.0 * m2 * bulk));
    constexpr int steps = 1000;
    constexpr double ratio = 0.97;
    double before = 0.0, left = 1.0;
    for (int i = 1; i <= steps; ++i) {
      left *= ratio;
      const double d = -reach * (1.0 - left);
      if (slope_p(d) >= 0.0) {  // past the critical state, where the state is inside: the root lies before it
        const double end = before + (1.0 - 1e-12) * (bisect(slope_p, before, d) - before);
        const double root = bisect(residual, before, end);
        return {t.p - bulk * root, q_at(root), t.internal + root};
      }
      if (residual(d) <= 0.0) {
        const double root = bisect(residual, before, d);
        return {t.p - bulk * root, q_at(root), t.internal + root};
      }
      before = d;
    }
    return stress_free;
  };
  return law;
}

/// The same with M = 0: no shear stress, -beta p_c <= p <= p_c. What exceeds a bound becomes plastic volume strain until p is on the bound.
inline Law slippery_snow(double density, double young, double poisson, double beta, double xi, double pc0) {
  Law law = elastic(density, young, poisson);
  const double bulk = law.bulk;
  law.initial_internal = std::asinh(pc0 / bulk) / xi;
  law.correct = [=](const Law::Invariants& t, double) -> Law::Invariants {
    const auto hardness = [&](double x) { return bulk * std::sinh(xi * std::max(x, 0.0)); };
    const auto over = [&](double d) { return t.p - bulk * d - hardness(t.internal + d); };          // above the upper bound
    const auto under = [&](double d) { return t.p - bulk * d + beta * hardness(t.internal + d); };  // above the lower bound
    // with d = p/K the pressure is 0, which lies between the bounds
    const double d = over(0.0) > 0.0 ? bisect(over, 0.0, t.p / bulk) : under(0.0) < 0.0 ? bisect(under, t.p / bulk, 0.0) : 0.0;
    return {t.p - bulk * d, 0.0, t.internal + d};
  };
  return law;
}

/// Drucker-Prager without dilatancy and cohesion, q <= A p. A point that expands without stress is torn, and X counts the gap; it has to
/// close before the point bears pressure again.
inline Law drucker_prager(double density, double young, double poisson, double slope) {
  Law law = elastic(density, young, poisson);
  const double bulk = law.bulk;
  law.correct = [=](const Law::Invariants& t, double pressure_before) -> Law::Invariants {
    Law::Invariants r = t;
    if (pressure_before <= 1e-12 * bulk) {  // no pressure but for round-off
      const double closed = std::clamp(r.p / bulk, 0.0, std::max(r.internal, 0.0));
      r.p -= bulk * closed;
      r.internal -= closed;
    }
    if (r.q <= slope * r.p) return r;
    if (r.p > 0.0) return {r.p, slope * r.p, r.internal};
    return {0.0, 0.0, r.internal - r.p / bulk};
  };
  return law;
}

using Index = std::array<int, 3>;

struct Node {
  double mass = 0.0;
  Vec3 momentum = Vec3::Zero(), force_impulse = Vec3::Zero();
  Vec3 v = Vec3::Zero(), before_forces = Vec3::Zero();
};
using Nodes = std::map<Index, Node>;

/// A quadratic B-spline at a distance from its node, in cells.
inline double spline(double distance) {
  const double r = std::abs(distance);
  return r < 0.5 ? 0.75 - r * r : r < 1.5 ? 0.5 * (1.5 - r) * (1.5 - r) : 0.0;
}

/// Calls f(node, weight, x_i - x) for the nodes around a place.
template <class F>
void for_each_node(const Vec3& x, double dx, F&& f) {
  Index nearest;
  for (std::size_t a = 0; a < 3; ++a) nearest[a] = static_cast<int>(std::floor(x[static_cast<int>(a)] / dx + 0.5));
  for (int i = nearest[0] - 1; i <= nearest[0] + 1; ++i) {
    for (int j = nearest[1] - 1; j <= nearest[1] + 1; ++j) {
      for (int k = nearest[2] - 1; k <= nearest[2] + 1; ++k) {
        const Vec3 apart = dx * Vec3(i, j, k) - x;
        f(Index{i, j, k}, spline(apart.x() / dx) * spline(apart.y() / dx) * spline(apart.z() / dx), apart);
      }
    }
  }
}

/// The step of a scene, and its particles.
class Solver {
 public:
  Solver(const Scene& scene, Law law, double dx)
      : scene_(scene), law_(std::move(law)), dx_(dx), impulses(scene.boundaries.size(), Vec3::Zero()) {}

  std::vector<Particle> particles;
  double time = 0.0;
  double max_speed = 0.0;  ///< of the particles at the end of the step, also of those that then left the domain

  /// cfl dx/(c_P + |v|max)
  [[nodiscard]] double stable_step() const { return scene_.numerics.cfl * dx_ / (law_.wave_speed() + max_speed); }

  void step(double dt) {
    const double speed = law_.wave_speed() + max_speed;
    kept_ = scene_.numerics.transfer == Transfer::flip    ? scene_.numerics.flip_ratio
            : scene_.numerics.transfer == Transfer::aflip ? 1.0 - std::min(1.0, dt * speed / (scene_.numerics.relaxation_cells * dx_))
                                                          : 0.0;
    particles_to_grid(dt);
    for (auto& [at, n] : nodes_) {
      n.before_forces = n.momentum / n.mass;
      n.v = n.before_forces + n.force_impulse / n.mass + dt * scene_.gravity;
    }
    correct_around_solids(dt);
    for (std::size_t b = 0; b < scene_.boundaries.size(); ++b) {
      std::vector<Vec3> before;
      for (const auto& [at, n] : nodes_) before.push_back(n.v);
      act(b, dt);
      auto was = before.begin();
      for (const auto& [at, n] : nodes_) {
        // an image is what it is the image of
        const auto parts = [&at = at](bool mirror, std::size_t axis) {
          return !mirror ? 1.0 : at[axis] > 0 ? 2.0 : at[axis] == 0 ? 1.0 : 0.0;
        };
        impulses[b] += parts(scene_.mirror.x, 0) * parts(scene_.mirror.y, 1) * n.mass * (*was++ - n.v);
      }
    }
    max_speed = 0.0;
    for (Particle& p : particles) {
      grid_to_particle(p, dt);
      max_speed = std::max(max_speed, p.v.norm());
      hold_outside(p);
      law_.update(p, dt);
    }
    std::erase_if(particles, [&](const Particle& p) {
      return (p.x.array() < scene_.domain_min.array()).any() || (p.x.array() > scene_.domain_max.array()).any();
    });
    time += dt;
  }

 private:
  const Scene& scene_;
  Law law_;
  double dx_, kept_ = 0.0;
  Nodes nodes_;

 public:
  std::vector<Vec3> impulses;  ///< that each boundary took since the start, N s; with mirror planes: of all parts

 private:
  void scatter(const Particle& p, double dt) {
    const double mass = law_.density * p.volume, compression = std::max(-p.c.trace(), 0.0);
    const double c2 = keeps_compaction(scene_.material) ? scene_.numerics.shock_viscosity : 0.0;
    const double viscous = law_.density * dx_ * dx_ * compression * std::min(c2 * compression, 0.25 / dt);
    const Mat3 stress = p.tau - viscous * Mat3::Identity();
    for_each_node(p.x, dx_, [&](const Index& at, double w, const Vec3& apart) {
      if (w == 0.0) return;
      Node& n = nodes_[at];
      n.mass += w * mass;
      n.momentum += w * mass * (scene_.numerics.transfer == Transfer::flip ? p.v : Vec3(p.v + p.c * apart));
      n.force_impulse -= dt * p.volume * 4.0 / (dx_ * dx_) * w * (stress * apart);
    });
  }
  void particles_to_grid(double dt) {
    nodes_.clear();
    for (const Particle& p : particles) {
      for (const double x : {1.0, -1.0}) {
        for (const double y : {1.0, -1.0}) {
          if ((x < 0.0 && !scene_.mirror.x) || (y < 0.0 && !scene_.mirror.y)) continue;
          Particle image = p;  // the other parts of the domain, as material
          const Vec3 flip(x, y, 1.0);
          image.x = flip.cwiseProduct(p.x);
          image.v = flip.cwiseProduct(p.v);
          image.c = flip.asDiagonal() * p.c * flip.asDiagonal();
          image.tau = flip.asDiagonal() * p.tau * flip.asDiagonal();
          scatter(image, dt);
        }
      }
    }
  }
  void grid_to_particle(Particle& p, double dt) {
    Vec3 now = Vec3::Zero(), old = Vec3::Zero();
    Mat3 c = Mat3::Zero();
    for_each_node(p.x, dx_, [&](const Index& at, double w, const Vec3& apart) {
      if (w == 0.0) return;
      const Node& n = nodes_.at(at);
      now += w * n.v;
      old += w * n.before_forces;
      c += 4.0 / (dx_ * dx_) * w * n.v * apart.transpose();
    });
    p.v = now + kept_ * (p.v - old);
    p.c = c;
    p.x += dt * now;
  }
  /// A particle behind the surface of a solid goes back to it, and hits it.
  void hold_outside(Particle& p) {
    for (std::size_t b = 0; b < scene_.boundaries.size(); ++b) {
      const auto* const solid = std::get_if<SurfaceSolid>(&scene_.boundaries[b]);
      if (solid == nullptr) continue;
      const auto [distance, normal] = solid->solid().nearest(p.x);
      if (distance >= -0.05 * dx_) continue;
      const Vec3 before = p.v;
      p.v = contact(p.v, normal, Contact::separable, solid->friction());
      p.x += std::min(-distance, dx_) * normal;
      impulses[b] += law_.density * p.volume * (before - p.v);
    }
  }

  /// How far a place is from the outline of a solid; 0 within it.
  static double distance_from(const Outline& outline, const Vec2& x) {
    if (outline.circle()) return std::max(0.0, (x - outline.circle()->centre).norm() - outline.circle()->radius);
    double least = 1e300;
    bool inside = true;
    for (const Outline::Side& side : outline.sides()) {
      const Vec2 along = side.to - side.from, arm = x - side.from;
      inside = inside && along.x() * arm.y() - along.y() * arm.x() >= 0.0;  // to the left of every side
      least = std::min(least, (arm - std::clamp(arm.dot(along) / along.dot(along), 0.0, 1.0) * along).norm());
    }
    return inside ? 0.0 : least;
  }

  /// Around solids: one step from the lumped towards the consistent mass matrix (lumped_mass.hpp says why).
  void correct_around_solids(double dt) {
    for (const Boundary& boundary : scene_.boundaries) {
      const auto* const solid = std::get_if<SurfaceSolid>(&boundary);
      if (solid == nullptr) continue;
      Nodes corrected = nodes_;
      for (std::size_t b = 0; b < scene_.boundaries.size(); ++b) act(b, dt);
      for (const Particle& p : particles) {
        const double apart = std::max(distance_from(solid->solid().outline, p.x.head<2>()), p.x.z() - solid->solid().top);
        const double share = std::clamp((5.5 - apart / dx_) / 3.0, 0.0, 1.0);  // whole up to 2.5 cells, none from 5.5 on
        Vec3 gained = Vec3::Zero(), before = Vec3::Zero();
        Mat3 gradient = Mat3::Zero(), turned = Mat3::Zero();
        for_each_node(p.x, dx_, [&](const Index& at, double w, const Vec3& arm) {
          if (w == 0.0) return;
          const Node& n = nodes_.at(at);
          gained += w * (n.v - n.before_forces);
          before += w * n.before_forces;
          gradient += 4.0 / (dx_ * dx_) * w * n.before_forces * arm.transpose();
          if (kept_ == 0.0)
            turned += 2.0 / (dx_ * dx_) * w * ((n.v - n.before_forces) * arm.transpose() - arm * (n.v - n.before_forces).transpose());
        });
        for_each_node(p.x, dx_, [&](const Index& at, double w, const Vec3& arm) {
          if (w == 0.0) return;
          const Node& n = nodes_.at(at);
          const Vec3 more = n.v - n.before_forces - gained - turned * arm + (1.0 - kept_) * (n.before_forces - before - gradient * arm);
          corrected.at(at).v += share * law_.density * p.volume * w / n.mass * more;
        });
      }
      nodes_ = std::move(corrected);
    }
  }

  void act(std::size_t b, double dt) {
    if (const auto* wall = std::get_if<Wall>(&scene_.boundaries[b]); wall != nullptr && !wall->speed) {
      if (folds(*wall)) {
        act_folded(*wall);
      } else {
        const double moved = wall->travels ? time * wall->velocity.dot(wall->normal) : 0.0;
        for (auto& [at, n] : nodes_) {
          if ((place_of(at) - wall->point).dot(wall->normal) > moved + on_surface) continue;
          n.v = wall->velocity + contact(n.v - wall->velocity, wall->normal, wall->contact, wall->friction);
        }
      }
    } else if (const auto* box = std::get_if<NodalSolid>(&scene_.boundaries[b])) {
      act_as_box(*box);
    } else if (const auto* solid = std::get_if<SurfaceSolid>(&scene_.boundaries[b])) {
      act_at_surface(*solid, dt);
    } else {
      throw std::logic_error("the plain step does not know this boundary");
    }
  }

  /// What contact leaves of a velocity relative to a surface: no approach, Coulomb's friction.
  static Vec3 contact(const Vec3& v, const Vec3& normal, Contact kind, double friction) {
    if (kind == Contact::no_slip) return Vec3::Zero();
    const double approach = -v.dot(normal);
    if (approach <= 0.0 && kind == Contact::separable) return v;
    Vec3 along = v + approach * normal;
    if (approach <= 0.0 || along.norm() == 0.0) return along;
    return std::max(0.0, 1.0 - friction * approach / along.norm()) * along;
  }
  [[nodiscard]] Vec3 place_of(const Index& at) const { return dx_ * Vec3(at[0], at[1], at[2]); }
  [[nodiscard]] bool folds(const Wall& wall) const;
  void act_as_box(const NodalSolid& box);
  void act_folded(const Wall& wall);
  void act_at_surface(const SurfaceSolid& solid, double dt);
};

/// Every node inside obeys the nearest face; of faces as near the first of: upstream, sides, downstream, top.
inline void Solver::act_as_box(const NodalSolid& box) {
  for (auto& [at, n] : nodes_) {
    const Vec3 x = place_of(at), low = x - box.solid.bounds().min(), high = box.solid.bounds().max() - x;
    if (low.minCoeff() < -on_surface || high.minCoeff() < -on_surface) continue;
    Vec3 normal = -Vec3::UnitX();
    double depth = low.x();
    const auto nearer = [&](double other, const Vec3& direction) {
      if (other < depth - on_surface) depth = other, normal = direction;
    };
    nearer(low.y(), -Vec3::UnitY());
    nearer(high.y(), Vec3::UnitY());
    nearer(high.x(), Vec3::UnitX());
    nearer(high.z(), Vec3::UnitZ());
    n.v = contact(n.v, normal, box.contact, box.friction);
  }
}

/// Whether a wall acts on columns of nodes: one that asks for it, normal to an axis, not on a mirror plane, with room for its master. The
/// master is up to 1.5 cells before it, and a wall opposite needs one and a half cells more.
inline bool Solver::folds(const Wall& wall) const {
  Eigen::Index axis = 0;
  if (wall.rule != ContactRule::surface || wall.normal.cwiseAbs().maxCoeff(&axis) < 1.0 - 1e-12) return false;
  const double side = wall.normal[axis];
  const auto moved = [&](const Wall& w) -> Vec3 { return w.point + (w.travels ? time : 0.0) * w.velocity; };
  const double plane = moved(wall)[axis] / dx_;
  const double master = side > 0.0 ? std::ceil(plane + 0.5 - 1e-9) : std::floor(plane - 0.5 + 1e-9);
  if (((axis == 0 && scene_.mirror.x) || (axis == 1 && scene_.mirror.y)) && master <= 0.0) return false;
  Vec3 at = wall.point;
  at[axis] = dx_ * master;
  return std::ranges::none_of(scene_.boundaries, [&](const Boundary& other) {
    const auto* opposite = std::get_if<Wall>(&other);
    return opposite != nullptr && opposite->normal.dot(wall.normal) <= -0.5 &&
           (at - moved(*opposite)).dot(opposite->normal) < (1.5 - 1e-9) * dx_;
  });
}

/// A wall normal to an axis on the columns of nodes through it. The first node half a cell or more before the wall is the master; it and
/// the two nodes behind it may only move as v_k = c_k v_master along the normal, c_k the distance over the master's, and the mean of
/// momentum under that constraint gives v_master.
inline void Solver::act_folded(const Wall& wall) {
  Eigen::Index axis = 0;
  wall.normal.cwiseAbs().maxCoeff(&axis);
  const auto a = static_cast<std::size_t>(axis);
  const int into = wall.normal[axis] > 0.0 ? -1 : 1;  // from a node to the next one nearer to the wall
  const double plane = (wall.point[axis] + (wall.travels ? time * wall.velocity[axis] : 0.0)) / dx_;
  const int master = into < 0 ? static_cast<int>(std::ceil(plane + 0.5 - 1e-9)) : static_cast<int>(std::floor(plane - 0.5 + 1e-9));
  const double distance = std::abs(master - plane);
  std::set<Index> columns;  // by the place of the master
  for (auto& [at, n] : nodes_) {
    const int behind = into * (at[a] - master);
    if (behind < 0) continue;
    if (behind > 2) {
      n.v = wall.velocity + contact(n.v - wall.velocity, wall.normal, wall.contact, wall.friction);
      continue;
    }
    Index first = at;
    first[a] = master;
    columns.insert(first);
  }
  for (const Index& first : columns) {
    std::array<Node*, 3> column{};
    std::array<double, 3> c{};
    for (int k = 0; k < 3; ++k) {
      Index at = first;
      at[a] += into * k;
      const auto found = nodes_.find(at);
      column[static_cast<std::size_t>(k)] = found == nodes_.end() ? nullptr : &found->second;
      c[static_cast<std::size_t>(k)] = (distance - k) / distance;
    }
    if (column[1] == nullptr && column[2] == nullptr) continue;  // all before the wall
    if (column[0] == nullptr) {
      for (Node* n : {column[1], column[2]})
        if (n != nullptr) n->v = wall.velocity + contact(n->v - wall.velocity, wall.normal, wall.contact, wall.friction);
      continue;
    }
    Vec3 weighted = Vec3::Zero();
    double mass = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (column[k] == nullptr) continue;
      weighted += c[k] * column[k]->mass * (column[k]->v - wall.velocity);
      mass += c[k] * c[k] * column[k]->mass;
    }
    const Vec3 held = weighted / mass;
    Vec3 impulse = Vec3::Zero();  // that the wall would take if all stuck
    for (std::size_t k = 0; k < 3; ++k)
      if (column[k] != nullptr) impulse += column[k]->mass * (column[k]->v - wall.velocity - c[k] * held);
    const double push = -impulse.dot(wall.normal);
    if (wall.contact == Contact::separable) {
      if (push <= 0.0) continue;
      // masses of the column's nodes if the material began a tenth of a cell before the wall
      double there[3] = {0.0, 0.0, 0.0};
      for (std::size_t k = 0; k < 3; ++k) there[k] = bspline_tail(0.1 - (distance - static_cast<double>(k)));
      const double behind = (column[1] == nullptr ? 0.0 : column[1]->mass) + (column[2] == nullptr ? 0.0 : column[2]->mass);
      if (behind / column[0]->mass < (there[1] + there[2]) / there[0]) continue;
    }
    const double tangential = (impulse + push * wall.normal).norm();
    double share = wall.contact == Contact::no_slip ? 1.0 : 0.0;
    if (wall.contact != Contact::no_slip && wall.friction > 0.0 && push > 0.0)
      share = tangential > wall.friction * push ? wall.friction * push / tangential : 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (column[k] == nullptr) continue;
      const Vec3 before = column[k]->v - wall.velocity, stuck = c[k] * held;
      Vec3 after = before + share * (stuck - before);
      after[axis] = stuck[axis];
      column[k]->v = wall.velocity + after;
    }
  }
}

/// A solid with vertical sides: at the points of its surface the interpolated velocity must not point inwards. Impulses of the points are
/// found by eight sweeps of Gauss-Seidel over each layer of nodes, forwards and backwards in turn.
inline void Solver::act_at_surface(const SurfaceSolid& solid, double dt) {
  const ContactStencil& stencil = solid.stencil();
  if (scene_.mirror.y || scene_.mirror.x) throw std::logic_error("the plain step has surface contact without mirror planes only");
  constexpr int sweeps = 8, first_capped = 2;
  constexpr double least_weight = 0.3;
  std::set<int> layers;
  for (const auto& [at, n] : nodes_) layers.insert(at[2]);
  for (const int z : layers) {
    if (dx_ * z > solid.solid().top + on_surface) continue;
    std::vector<Node*> node;
    for (const auto& place : stencil.nodes) {
      const auto found = nodes_.find({place.at[0], place.at[1], z});
      node.push_back(found == nodes_.end() ? nullptr : &found->second);
    }
    struct Row {
      bool active = false;
      double normal = 0.0, tangent = 0.0, vertical = 0.0;  // impulses
    };
    std::vector<Row> rows(stencil.rows.size());
    const auto entries_of = [&](const ContactRow& row) { return std::span(stencil.entries).subspan(row.first, row.count); };
    for (std::size_t r = 0; r < rows.size(); ++r) {
      double weight = 0.0;
      bool all = true;
      for (const ContactEntry& e : entries_of(stencil.rows[r])) {
        const bool there = node[static_cast<std::size_t>(e.node)] != nullptr;
        weight += there ? e.vertical : 0.0;
        all &= there;
      }
      rows[r].active = stencil.rows[r].kind == ContactRow::Kind::extension ? all : weight > least_weight;
    }
    const auto solve = [&](std::size_t r, double strongest) {
      const ContactRow& row = stencil.rows[r];
      Row& state = rows[r];
      if (!state.active) return;
      double un = 0.0, ut = 0.0, uz = 0.0, kn = 0.0, kt = 0.0, kz = 0.0;  // velocities of the row, and its mobilities
      for (const ContactEntry& e : entries_of(row)) {
        const Node* n = node[static_cast<std::size_t>(e.node)];
        if (n == nullptr) continue;
        un += e.normal.dot(n->v.head<2>()), ut += e.tangent.dot(n->v.head<2>()), uz += e.vertical * n->v.z();
        kn += e.normal.squaredNorm() / n->mass, kt += e.tangent.squaredNorm() / n->mass, kz += e.vertical * e.vertical / n->mass;
      }
      const bool point = row.kind == ContactRow::Kind::point;
      double normal = state.normal + (kn > 0.0 ? un / kn : 0.0);
      normal = point ? std::clamp(normal, -strongest, 0.0) : rows[static_cast<std::size_t>(row.row_before)].normal < 0.0 ? normal : 0.0;
      double tangent = 0.0, vertical = 0.0;
      if (point && solid.friction() > 0.0) {
        tangent = state.tangent + (kt > 0.0 ? ut / kt : 0.0);
        vertical = state.vertical + (kz > 0.0 ? uz / kz : 0.0);
        const double size = std::hypot(tangent, vertical), most = -solid.friction() * normal;
        if (size > most) tangent *= most / size, vertical *= most / size;
      }
      for (const ContactEntry& e : entries_of(row)) {
        Node* n = node[static_cast<std::size_t>(e.node)];
        if (n == nullptr) continue;
        n->v.head<2>() -= ((normal - state.normal) * e.normal + (tangent - state.tangent) * e.tangent) / n->mass;
        n->v.z() -= (vertical - state.vertical) * e.vertical / n->mass;
      }
      state.normal = normal, state.tangent = tangent, state.vertical = vertical;
    };
    const std::size_t points = stencil.point_rows, extensions = rows.size() - points;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      const bool forward = sweep % 2 == 0;
      for (std::size_t i = 0; sweep > 0 && i < extensions; ++i) solve(points + (forward ? i : extensions - 1 - i), 0.0);
      for (std::size_t i = 0; i < points; ++i) {
        const std::size_t r = forward ? i : points - 1 - i;
        const ContactRow& row = stencil.rows[r];
        double strongest = 1e300;
        if (const EdgeBound& edge = row.edge; edge.neighbour >= 0 && (edge.in_margin() || sweep >= first_capped)) {
          Vec2 along = Vec2::Zero();  // velocity along the side at the point
          for (const ContactEntry& e : entries_of(row)) {
            const Node* n = node[static_cast<std::size_t>(e.node)];
            if (n != nullptr) along += Vec2(e.tangent.dot(n->v.head<2>()), e.vertical * n->v.z());
          }
          const double inner = -rows[static_cast<std::size_t>(edge.neighbour)].normal;
          double squared_speed = along.squaredNorm();
          if (edge.in_margin()) {  // that of the flow, up to twice the largest of the nodes
            squared_speed = 0.0;
            for (const ContactEntry& e : entries_of(row)) {
              const Node* n = node[static_cast<std::size_t>(e.node)];
              if (n != nullptr) squared_speed = std::max(squared_speed, 4.0 * n->v.squaredNorm());
            }
          }
          const double fall = 0.5 * law_.density * squared_speed * row.width * dx_ * dt;
          strongest = edge.at_rest * inner - std::min((edge.at_rest - edge.free) * inner, fall);
          if (row.adjacent >= 0) strongest = std::max(strongest, -rows[static_cast<std::size_t>(row.adjacent)].normal);
        }
        solve(r, strongest);
      }
    }
    if (dx_ * (z + ContactStencil::deep_from) > solid.solid().top + on_surface) continue;
    for (const auto& deep : stencil.deep) {
      Node* n = node[static_cast<std::size_t>(deep.node)];
      if (n != nullptr) n->v = contact(n->v, Vec3(deep.normal.x(), deep.normal.y(), 0.0), Contact::separable, solid.friction());
    }
  }
}

}  // namespace mpm::plain
