#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"
#include "validation/harness/radial_field.hpp"

namespace mpm::validation::thick_cylinder {
namespace {

constexpr double inner = 1.0, outer = 2.5;  ///< m
constexpr double judged_to = 2.0;           ///< m: stresses; beyond, cells at the free surface take part on the coarsest grid
constexpr double strain = 1e-6;             ///< hoop strain at the inner radius: the exact solution is the linear one

/// Lame's cylinder: u = U g(t) (A R + B/R), free of stress at R = b, plane strain; u(a) = U g(t). Derived in the README.
class Lame {
 public:
  explicit Lame(const HenckyElastic::Parameters& m)
      : shear_(m.young_modulus / (2.0 * (1.0 + m.poisson_ratio))),
        lame_(m.young_modulus * m.poisson_ratio / ((1.0 + m.poisson_ratio) * (1.0 - 2.0 * m.poisson_ratio))) {
    const double ratio = shear_ / ((lame_ + shear_) * outer * outer);  // A/B
    b_ = 1.0 / (ratio * inner + 1.0 / inner);
    a_ = ratio * b_;
  }
  /// The wall moves by u in `duration`, smoothly: 10 x^3 - 15 x^4 + 6 x^5.
  [[nodiscard]] RadialMotion motion(double u, double duration) const {
    return [this, u, duration](double time) -> RadialState {
      const double x = std::clamp(time / duration, 0.0, 1.0);
      const double now = u * x * x * x * (10.0 + x * (6.0 * x - 15.0));
      const double rate = u * 30.0 * x * x * (1.0 - x) * (1.0 - x) / duration;
      const double growth = u * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / (duration * duration);
      return [this, now, rate, growth](double radius) {
        const double shape = a_ * radius + b_ / radius, radial = a_ - b_ / (radius * radius), hoop = a_ + b_ / (radius * radius);
        RadialPoint r;
        r.r = radius + now * shape;
        r.velocity = rate * shape;
        r.acceleration = growth * shape;
        r.radial_rate = rate * radial, r.hoop_rate = rate * hoop;
        r.axial = now * lame_ * (radial + hoop);
        r.radial = r.axial + 2.0 * shear_ * now * radial;
        r.hoop = r.axial + 2.0 * shear_ * now * hoop;
        return r;
      };
    };
  }

 private:
  double shear_, lame_, a_ = 0.0, b_ = 0.0;
};

void run(const CaseContext& context, CaseResult& result) {
  const Case base = context.read_case();
  const CaseScene scene = make_scene(base);
  const Lame exact(base.material.as<HenckyElastic>());
  const double duration = 6.0 * outer / wave_speed_of(scene.material), u = strain * inner;
  const RadialState end = exact.motion(u, duration)(duration);
  {
    // the textbook's cylinder under the pressure p inside, as this one: u(a) = p a (1 + nu)/E ((1 - 2 nu) a^2 + b^2)/(b^2 - a^2)
    const auto& m = base.material.as<HenckyElastic>();
    const double p = -end(inner).radial, a2 = inner * inner, b2 = outer * outer;
    const double book = p * inner * (1.0 + m.poisson_ratio) / m.young_modulus * ((1.0 - 2.0 * m.poisson_ratio) * a2 + b2) / (b2 - a2);
    result.check_relative(Label::verification, "reference: displacement of the wall over that of the textbook's formula", u / book, 1.0, "",
                          1e-12, "the same solution, written in another way");
    result.check_at_most(Label::verification, "reference: radial stress of the free surface over that of the wall",
                         std::abs(end(outer).radial / end(inner).radial), 0.0, "", 1e-12, "free of stress, round-off");
  }

  const auto grids = context.choose<std::vector<int>>({8, 12, 16}, {8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48, 64});
  struct Method {
    std::string name;
    Transfer transfer;
  };
  std::vector<Method> methods = {{"AFLIP", Transfer::aflip}};
  if (context.level() != Level::quick) {
    methods.push_back({"APIC", Transfer::apic});
    methods.push_back({"FLIP", Transfer::flip});
  }
  std::vector<std::vector<RadialErrors>> all(methods.size(), std::vector<RadialErrors>(grids.size()));
  in_parallel(methods.size() * grids.size(), [&](std::size_t i) {
    const std::size_t m = i % methods.size(), g = grids.size() - 1 - i / methods.size();
    all[m][g] = run_radial(base,
                           {.inner = inner,
                            .outer = outer,
                            .cells = grids[g],
                            .free_surface = true,
                            .judged_to = judged_to,
                            .duration = duration,
                            .transfer = methods[m].transfer},
                           exact.motion(u, duration));
  });

  const double pressure = -end(inner).radial;
  Plot errors{"errors", "Errors", "dx / a [-]", "root mean square error over the wall's value [-]", {}, "", true, true};
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::vector<double> cell, displacement, radial, hoop;
    double work = 0.0;
    for (const RadialErrors& e : all[m]) {
      cell.push_back(e.cell);
      displacement.push_back(e.displacement / u);
      radial.push_back(e.radial / pressure), hoop.push_back(e.hoop / pressure);
      work += e.particle_steps;
    }
    const std::string& name = methods[m].name;
    const auto order = [&](const std::string& what, const std::vector<double>& error, double low, const std::string& reason) {
      const double p = fitted_order(cell, error);
      result.check_order(Label::verification, name + ": order of the " + what, p, low, 3.0, reason).observed_order = p;
    };
    order("displacement", displacement, 1.5,
          "second order inside; the free surface passes through cells, whose nodes outside carry little mass: between first and second");
    order("radial stress up to R = 2 a", radial, 0.8, "gradients of the displacement: first order at least");
    order("hoop stress up to R = 2 a", hoop, 0.8, "as the radial stress");
    const RadialErrors& finest = all[m].back();
    result
        .check_relative(Label::verification, name + ": radial stress at the wall, finest grid", -finest.wall_stress, -finest.wall_exact,
                        "Pa", 0.02, "2 %: second order at 16 cells in the radius and more")
        .in_summary(Quantity::pressure);
    errors.series.push_back({name + ", displacement", cell, displacement, Series::Style::points});
    errors.series.push_back({name + ", radial stress", cell, radial, Series::Style::points});
    result.notes.push_back(fmt::format(
        "{}: displacement {:.1e} to {:.1e}, up to 2 a radial stress {:.1e} to {:.1e}, hoop stress {:.1e} to {:.1e}; radial stress at the "
        "wall {:.4f} to {:.4f} of the exact one; {:.1f} million particle-steps.",
        name, displacement.front(), displacement.back(), radial.front(), radial.back(), hoop.front(), hoop.back(),
        all[m].front().wall_stress / all[m].front().wall_exact, finest.wall_stress / finest.wall_exact, 1e-6 * work));
  }
  errors.series.push_back(slope_line("order 2", errors.series.front().x, errors.series.front().y.back(), 2.0));
  result.plots.push_back(std::move(errors));

  const RadialErrors& shown = all[0].front();
  Plot stress{"stress", "Stresses, coarsest grid, AFLIP", "R / a [-]", "stress over the pressure inside [-]"};
  const auto exact_line = [&](const char* name, double RadialPoint::*what) {
    return reference_curve(name, 1.0, 2.5, 150, [&](double x) { return end(x * inner).*what / pressure; });
  };
  Series ours_radial{"radial", shown.place, {}, Series::Style::points}, ours_hoop{"hoop", shown.place, {}, Series::Style::points};
  for (const double v : shown.radial_values) ours_radial.y.push_back(v / pressure);
  for (const double v : shown.hoop_values) ours_hoop.y.push_back(v / pressure);
  stress.series = {exact_line("radial, exact", &RadialPoint::radial), exact_line("hoop, exact", &RadialPoint::hoop), ours_radial,
                   ours_hoop};
  result.plots.push_back(std::move(stress));
}

const Registration registered{{.title = "Thick cylinder: Lamé", .run = run}};

}  // namespace
}  // namespace mpm::validation::thick_cylinder
