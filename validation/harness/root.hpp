#pragma once
/// Roots for references, by Boost.Math.

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cstdint>
#include <limits>
#include <utility>

namespace mpm::validation {

/// Root of a continuous f between a and b to the last bits (TOMS 748); f(a) and f(b) have opposite signs, or one of them is 0.
/// @throws std::domain_error, boost::math::evaluation_error if there is no change of sign
template <class F>
double root_between(const F& f, double a, double b) {
  const auto [low, high] = std::minmax(a, b);
  if (low == high || f(low) == 0.0) return low;
  if (f(high) == 0.0) return high;
  std::uintmax_t iterations = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      f, double{low}, double{high}, boost::math::tools::eps_tolerance<double>(std::numeric_limits<double>::digits), iterations);
  return 0.5 * (bracket.first + bracket.second);
}

/// The place between `inside` and `beyond` from which a property no longer holds, for one that holds at `inside` and not at `beyond`.
/// @return two neighbouring places, {holds, does not hold}
template <class Property>
std::pair<double, double> limit_of(const Property& holds, double inside, double beyond) {
  const auto sign = [&](double x) { return holds(x) ? -1.0 : 1.0; };
  std::uintmax_t iterations = 200;
  const auto bracket =
      boost::math::tools::bisect(sign, std::min(inside, beyond), std::max(inside, beyond),
                                 boost::math::tools::eps_tolerance<double>(std::numeric_limits<double>::digits), iterations);
  return inside < beyond ? bracket : std::pair{bracket.second, bracket.first};
}

}  // namespace mpm::validation
