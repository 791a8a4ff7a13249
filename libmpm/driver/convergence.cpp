#include "libmpm/driver/convergence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "libmpm/base/error.hpp"

namespace mpm {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void require_falling(std::span<const double> size, std::size_t values, std::size_t least, const char* who) {
  if (size.size() < least || size.size() != values)
    throw ConfigError(fmt::format("{}: needs at least {} sizes and as many values, got {} and {}", who, least, size.size(), values));
  for (std::size_t i = 0; i < size.size(); ++i)
    if (!(size[i] > 0.0) || (i > 0 && !(size[i] < size[i - 1])))
      throw ConfigError(fmt::format("{}: sizes must be positive and fall from coarse to fine, entry {} is {}", who, i, size[i]));
}

/// Magnitudes below which a difference is round-off.
double round_off(std::span<const double> f) {
  double scale = 0.0;
  for (const double v : f) scale = std::max(scale, std::abs(v));
  return 32.0 * std::numeric_limits<double>::epsilon() * scale;
}

/// Least-squares fit f = f0 + sum_k a_k h^p_k.
struct Fit {
  double limit, deviation;  ///< f0 and the standard deviation sigma of the fit
  double correction;        ///< sum_k a_k h_1^p_k on the finest grid
  double fitted;            ///< f0 + correction
  double order;             ///< p, or NaN where the exponents were prescribed
};

Fit fit_powers(std::span<const double> h, std::span<const double> f, std::span<const double> exponents, bool weighted, int parameters) {
  const std::size_t n = h.size(), m = exponents.size();
  const auto dot = [](const std::vector<double>& x, const std::vector<double>& y) {
    return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
  };
  const double finest = h.back();
  double weight_sum = 0.0;
  for (const double hi : h) weight_sum += 1.0 / hi;
  std::vector<std::vector<double>> columns(m + 2, std::vector<double>(n));  // of 1, of the powers, and of f: its place is `last`
  const std::size_t last = m + 1;
  for (std::size_t i = 0; i < n; ++i) {
    // square root of n w_i: 1 without weights; with weights their mean is 1
    const double s = weighted ? std::sqrt(static_cast<double>(n) / (h[i] * weight_sum)) : 1.0;
    columns[0][i] = s;
    for (std::size_t k = 0; k < m; ++k) columns[k + 1][i] = s * std::pow(h[i] / finest, exponents[k]);
    columns[last][i] = s * f[i];
  }
  // Gram and Schmidt's orthogonal columns, in the modified form: what is left of the last one is the misfit.
  std::vector<std::vector<double>> parts(last, std::vector<double>(m + 2));
  for (std::size_t k = 0; k < last; ++k) {
    const double squares = dot(columns[k], columns[k]);
    for (std::size_t j = k + 1; j <= last; ++j) {
      parts[k][j] = dot(columns[k], columns[j]) / squares;
      for (std::size_t i = 0; i < n; ++i) columns[j][i] -= parts[k][j] * columns[k][i];
    }
  }
  std::vector<double> c(last);
  for (std::size_t k = last; k-- > 0;) {
    c[k] = parts[k][last];
    for (std::size_t j = k + 1; j < last; ++j) c[k] -= parts[k][j] * c[j];
  }
  Fit fit{};
  fit.limit = c[0];
  fit.correction = std::accumulate(c.begin() + 1, c.end(), 0.0);
  fit.fitted = fit.limit + fit.correction;
  fit.deviation = std::sqrt(dot(columns[last], columns[last]) / std::max(1.0, static_cast<double>(n) - parameters));
  fit.order = nan;
  return fit;
}

/// The exponent is free: the other two parameters are linear, so that only p is searched.
Fit fit_free_order(std::span<const double> h, std::span<const double> f, bool weighted) {
  const auto deviation = [&](double p) { return fit_powers(h, f, std::array{p}, weighted, 3).deviation; };
  constexpr double lowest = 0.02, highest = 10.0, stride = 0.02;
  double best = lowest;
  double least = deviation(lowest);
  const auto strides = static_cast<int>(std::lround((highest - lowest) / stride));
  for (int i = 1; i <= strides; ++i) {
    const double p = lowest + i * stride;
    if (const double s = deviation(p); s < least) {
      least = s;
      best = p;
    }
  }
  constexpr int bits = std::numeric_limits<double>::digits / 2;  // a minimum is known to the square root of round-off
  const double order = boost::math::tools::brent_find_minima(deviation, std::max(lowest, best - stride), best + stride, bits).first;
  Fit fit = fit_powers(h, f, std::array{order}, weighted, 3);
  fit.order = order;
  return fit;
}

const Fit& better(const Fit& a, const Fit& b) { return b.deviation < a.deviation ? b : a; }

/// Eca & Hoekstra (2014), Sect. 4: choice of the fit, and the uncertainty from it.
void least_squares(Convergence& c) {
  const std::span<const double> h(c.size), f(c.value);
  const Fit free_plain = fit_free_order(h, f, false), free_weighted = fit_free_order(h, f, true);
  const auto credible = [](const Fit& x) { return x.order >= 0.5 && x.order <= 2.0; };
  Fit fit{};
  if (credible(free_plain) && credible(free_weighted)) {
    fit = better(free_plain, free_weighted);
  } else if (credible(free_plain) || credible(free_weighted)) {
    fit = credible(free_plain) ? free_plain : free_weighted;
  } else {
    const bool low = better(free_plain, free_weighted).order < 0.5;
    fit = fit_powers(h, f, std::array{1.0}, false, 2);
    for (const bool weighted : {false, true}) {
      fit = better(fit, fit_powers(h, f, std::array{1.0}, weighted, 2));
      fit = better(fit, fit_powers(h, f, std::array{2.0}, weighted, 2));
      if (low) fit = better(fit, fit_powers(h, f, std::array{1.0, 2.0}, weighted, 3));
    }
  }
  const auto [low, high] = std::minmax_element(f.begin(), f.end());
  const double range = (*high - *low) / static_cast<double>(f.size() - 1);
  const double estimate = std::abs(fit.correction), misfit = std::abs(f.back() - fit.fitted);
  c.least_squares_order = fit.order;
  c.least_squares_limit = fit.limit;
  if (range <= round_off(f)) {
    c.least_squares_uncertainty = range;
  } else if (fit.deviation < range) {
    const double fs = std::isnan(fit.order) ? 3.0 : 1.25;
    c.least_squares_uncertainty = fs * estimate + fit.deviation + misfit;
  } else {
    c.least_squares_uncertainty = 3.0 * fit.deviation / range * (estimate + fit.deviation + misfit);
  }
}

/// An uncertainty, and how it was found.
struct Uncertainty {
  double value;
  std::string basis;
};

/// Of the three finest grids, Eca & Hoekstra (2009); a higher order than the formal one is not trusted. @param range  of their values
Uncertainty of_three_grids(const Convergence& c, bool credible, double range, double formal_order) {
  const double gci = c.gci * std::abs(c.value.back());
  if (c.behaviour == Behaviour::constant) return {range, "the values agree to round-off"};
  if (credible) return {gci, fmt::format("grid convergence index, order {:.2f}, safety factor {}", c.order, c.safety_factor)};
  const double factor = c.order > formal_order ? 1.25 : 3.0;
  if (gci > factor * range) return {gci, fmt::format("grid convergence index, safety factor {}", c.safety_factor)};
  return {factor * range, fmt::format("{} times the range of the three finest grids", factor)};
}

/// Sets `uncertainty` and `basis`. With four grids or more the least-squares estimate counts, and without an order the smaller one. But
/// where the values have statistical noise it fits that, too: then the larger one counts.
void decide_on_uncertainty(Convergence& c, bool credible, double formal_order, double noise) {
  const auto [low, high] = std::minmax_element(c.value.end() - 3, c.value.end());
  const double range = *high - *low, gci = c.gci * std::abs(c.value.back());
  const bool constant = c.behaviour == Behaviour::constant;
  const Uncertainty three = of_three_grids(c, credible, range, formal_order);
  Uncertainty best = three;
  bool ordered = constant || credible;
  if (c.size.size() >= 4) {
    const Uncertainty fit{c.least_squares_uncertainty, fmt::format("least squares over {} grids", c.size.size())};
    const bool trusted = ordered || std::isfinite(c.order + c.least_squares_order);
    if (trusted || fit.value < three.value) best = fit;
    if (!trusted && gci > best.value) best = {gci, fmt::format("grid convergence index, safety factor {}", c.safety_factor)};
    if (noise > 0.0 && three.value > best.value)
      best = three;
    else
      ordered = trusted;
  }
  const bool too_high = c.behaviour == Behaviour::monotone && c.order > formal_order;
  c.uncertainty = best.value;
  c.basis = best.basis + (ordered    ? ""
                          : too_high ? fmt::format("; the observed order {:.2f} is not credible", c.order)
                                     : "; no order of convergence is observed");
}

/// Sets `asymptotic` and `remark`: whether all observed orders agree. Values that agree to round-off have
/// no uncertainty.
void decide_whether_asymptotic(Convergence& c, bool credible, double formal_order) {
  constexpr double agreement = 0.3;
  double lowest = c.order, highest = c.order;
  for (const ThreeGrids& t : c.triples) {
    lowest = std::min(lowest, t.order);
    highest = std::max(highest, t.order);
  }
  const auto worst =
      std::find_if(c.triples.rbegin(), c.triples.rend(), [](const ThreeGrids& t) { return t.behaviour != Behaviour::monotone; });
  if (c.behaviour == Behaviour::constant) {
    c.asymptotic = true;
    c.gci = 0.0;
    c.remark = "the three finest grids agree to round-off";
  } else if (worst != c.triples.rend()) {
    c.remark = fmt::format("not asymptotic: {} on {} grids", to_string(worst->behaviour),
                           worst == c.triples.rbegin() ? "the three finest" : "coarser");
  } else if (!credible) {
    c.remark = fmt::format("not asymptotic: observed order {:.2f} is not credible for a scheme of order {:g}", c.order, formal_order);
  } else if (c.size.size() >= 4) {
    c.asymptotic = highest - lowest <= agreement;
    c.remark = c.asymptotic ? fmt::format("asymptotic: orders {:.2f} to {:.2f} over {} triples of grids", lowest, highest, c.triples.size())
                            : fmt::format("not asymptotic: orders of successive triples spread from {:.2f} to {:.2f}", lowest, highest);
  } else {
    c.asymptotic = std::abs(c.order - formal_order) <= agreement;
    c.remark = c.asymptotic
                   ? fmt::format("asymptotic: observed order {:.2f}, formal order {:g}", c.order, formal_order)
                   : fmt::format("not asymptotic: observed order {:.2f} against a formal order of {:g}, and no fourth grid to confirm it",
                                 c.order, formal_order);
  }
}

}  // namespace

std::string to_string(Behaviour b) {
  static constexpr std::array names{"monotone", "oscillating", "divergent", "constant"};
  return names.at(static_cast<std::size_t>(b));
}

std::vector<double> pairwise_orders(std::span<const double> size, std::span<const double> error) {
  require_falling(size, error.size(), 2, "pairwise_orders");
  std::vector<double> p;
  for (std::size_t i = 0; i + 1 < size.size(); ++i) p.push_back(std::log(error[i] / error[i + 1]) / std::log(size[i] / size[i + 1]));
  return p;
}

double fitted_order(std::span<const double> size, std::span<const double> error) {
  require_falling(size, error.size(), 2, "fitted_order");
  const auto logarithms = [](std::span<const double> values) {
    std::vector<double> result;
    for (const double v : values) result.push_back(std::log(v));
    return result;
  };
  return fitted_line(logarithms(size), logarithms(error)).slope;
}

ThreeGrids observed_order(double h1, double f1, double h2, double f2, double h3, double f3) {
  const std::array size{h3, h2, h1};
  require_falling(size, 3, 3, "observed_order");
  const double e32 = f3 - f2, e21 = f2 - f1, noise = round_off(std::array{f1, f2, f3});
  if (!std::isfinite(f1) || !std::isfinite(f2) || !std::isfinite(f3)) return {Behaviour::divergent, nan, nan};
  if (std::abs(e32) <= noise && std::abs(e21) <= noise) return {Behaviour::constant, nan, f1};
  if (e32 * e21 < 0.0) return {Behaviour::oscillating, nan, nan};
  const double l21 = std::log(h2 / h1), l32 = std::log(h3 / h2);
  // log of r21^p (r32^p - 1)/(r21^p - 1), without overflow for large p; expm1 keeps it exact for small p
  const auto log_ratio = [&](double p) { return p * l32 + std::log(-std::expm1(-p * l32)) - std::log(-std::expm1(-p * l21)); };
  const double wanted = std::log(std::abs(e32)) - std::log(std::abs(e21));
  if (!(wanted > std::log(l32 / l21))) return {Behaviour::divergent, nan, nan};  // the limit p -> 0+
  constexpr double lowest = 1e-12, highest = 1024.0;
  double p = highest;  // also used for data of a higher order
  if (log_ratio(highest) > wanted) {
    const auto excess = [&](double order) { return log_ratio(order) - wanted; };
    std::uintmax_t iterations = 200;
    const auto [low, high] = boost::math::tools::toms748_solve(
        excess, lowest, highest, boost::math::tools::eps_tolerance<double>(std::numeric_limits<double>::digits - 2), iterations);
    p = 0.5 * (low + high);
  }
  return {Behaviour::monotone, p, f1 - e21 / std::expm1(p * l21)};
}

Convergence judge_convergence(std::span<const double> size, std::span<const double> value, double formal_order, double noise) {
  require_falling(size, value.size(), 3, "judge_convergence");
  if (!(formal_order > 0.0)) throw ConfigError(fmt::format("judge_convergence: the formal order must be positive, got {}", formal_order));
  const std::size_t n = size.size();
  Convergence c{};
  c.size.assign(size.begin(), size.end());
  c.value.assign(value.begin(), value.end());
  for (std::size_t i = 0; i + 2 < n; ++i)
    c.triples.push_back(observed_order(size[i + 2], value[i + 2], size[i + 1], value[i + 1], size[i], value[i]));
  c.behaviour = c.triples.back().behaviour;
  c.order = c.triples.back().order;
  c.extrapolated = c.triples.back().extrapolated;

  constexpr double slack = 0.5;
  const double f1 = value[n - 1], f2 = value[n - 2], r21 = size[n - 2] / size[n - 1];
  if (std::abs(f1 - f2) <= noise) c.order = c.extrapolated = nan;
  const bool credible = c.behaviour == Behaviour::monotone && c.order >= slack && c.order <= formal_order + slack;
  const double p =
      credible ? c.order : std::clamp(std::isnan(c.order) ? formal_order : c.order, std::min(slack, formal_order), formal_order);
  c.safety_factor = credible ? 1.25 : 3.0;
  c.gci = c.safety_factor * std::abs(f1 - f2) / (std::abs(f1) * std::expm1(p * std::log(r21)));
  decide_whether_asymptotic(c, credible, formal_order);
  if (c.behaviour != Behaviour::constant && std::abs(f1 - f2) <= noise) {
    c.remark = fmt::format(
        "not asymptotic: the two finest differ by {:.3g}, within twice the statistical error of their difference ({:.3g}), so the order "
        "cannot be determined",
        std::abs(f1 - f2), noise);
  }
  c.least_squares_order = c.least_squares_limit = c.least_squares_uncertainty = nan;
  if (n >= 4) least_squares(c);
  decide_on_uncertainty(c, credible, formal_order, noise);
  return c;
}

}  // namespace mpm
