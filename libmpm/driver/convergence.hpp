#pragma once
/// Grid and step convergence: observed orders, Richardson extrapolation and numerical uncertainty.
///
/// With an exact solution, errors are known and the order is their slope (pairwise_orders, fitted_order). Without one, the order is
/// computed from the values on three grids, and the distance to the limit is estimated. If that is not possible, the result is 'not
/// asymptotic', with the reason.

#include <span>
#include <string>
#include <vector>

namespace mpm {

/// The line y = at_zero + slope x.
struct Line {
  double slope;    ///< dy/dx
  double at_zero;  ///< y at x = 0
};

/// The least-squares line through the points (x, y). @param x  as many as y, at least two of them different
inline Line fitted_line(const std::vector<double>& x, const std::vector<double>& y) {
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  const auto n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    sx += x[i];
    sy += y[i];
    sxx += x[i] * x[i];
    sxy += x[i] * y[i];
  }
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope, sy / n - slope * sx / n};
}

/// Orders between neighbours, log(e_i / e_i+1) / log(h_i / h_i+1), for errors against an exact solution.
/// @param size   h, cell size or step, coarse first, strictly falling, > 0
/// @param error  >= 0
/// @throws ConfigError for fewer than two entries, lengths that differ, or sizes that do not fall
std::vector<double> pairwise_orders(std::span<const double> size, std::span<const double> error);

/// Slope of the least-squares line through (log h, log e); same arguments as pairwise_orders.
double fitted_order(std::span<const double> size, std::span<const double> error);

/// Behaviour of the differences between three grids.
enum class Behaviour {
  monotone,     ///< f approaches its limit from one side
  oscillating,  ///< f jumps from side to side: no order is defined
  divergent,    ///< the differences grow under refinement
  constant,     ///< the values agree to round-off
};
/// As in converge.json: "monotone".
std::string to_string(Behaviour);

/// Result of three grids.
struct ThreeGrids {
  Behaviour behaviour;  ///< decides which of the numbers are defined
  double order;         ///< p; NaN if undefined
  double extrapolated;  ///< f_ext = f1 + (f1 - f2)/(r21^p - 1); NaN if undefined
};

/// Order from three grids of any ratios, h1 < h2 < h3: the p of Celik et al. (2008, J. Fluids Eng. 130, 078001),
/// p = |ln|e32/e21| + ln((r21^p - s)/(r32^p - s))| / ln r21. With monotone data this is the root of
/// e32/e21 = r21^p (r32^p - 1)/(r21^p - 1), whose right side grows with p: it is bracketed, because the plain fixed-point iteration
/// does not converge for every ratio. For r21 = r32 = r it is ln(e32/e21)/ln r.
/// @throws ConfigError unless 0 < h1 < h2 < h3
ThreeGrids observed_order(double h1, double f1, double h2, double f2, double h3, double f3);

/// Numerical uncertainty of the value on the finest grid.
struct Convergence {
  std::vector<double> size, value;   ///< coarse first, as given
  std::vector<ThreeGrids> triples;   ///< of neighbouring grids, coarse first
  Behaviour behaviour;               ///< of the three finest grids
  double order;                      ///< from the three finest grids; NaN if undefined, or if the two finest differ by noise alone
  double extrapolated;               ///< by Richardson, from the same order; NaN where the order is
  double safety_factor;              ///< Fs: 1.25 with a credible order, else 3 (Roache)
  double gci;                        ///< grid convergence index of the finest grid, relative to |f1|
  double uncertainty;                ///< of the value on the finest grid, in the unit of f: see judge_convergence
  std::string basis;                 ///< how the uncertainty was found, in words
  double least_squares_order;        ///< NaN with fewer than four grids, or where the fit prescribes the exponents
  double least_squares_limit;        ///< f at h -> 0 of the least-squares fit; NaN with fewer than four grids
  double least_squares_uncertainty;  ///< U of Eca & Hoekstra for the finest grid, in the unit of f; NaN with fewer than four grids
  bool asymptotic;                   ///< all observed orders agree
  std::string remark;                ///< in words: 'asymptotic ...' or 'not asymptotic: ...'
};

/// Convergence of a quantity without exact solution.
/// GCI = Fs |f1 - f2| / (|f1| (r21^p - 1)). An order is credible where the three finest grids are monotone and
/// 0.5 <= p <= formal_order + 0.5; else Fs = 3 with the order limited to [0.5, formal_order].
/// Uncertainty with three grids: GCI if the order is credible; if it is higher, 1.25 times the range of the three values; 3 times the range
/// otherwise (Eca & Hoekstra 2009, Computers & Fluids 38, 1580); without a credible order at least the GCI. The GCI alone is too small
/// where two values agree by chance. With four or more grids the least-squares form of Eca & Hoekstra (2014, J. Comput. Phys. 262,
/// 104-130): f = f0 + a h^p, weighted (1/h) and not, the better fit taken; prescribed exponents 1 and 2 where p falls outside [0.5, 2], and
/// then at most the uncertainty of the three finest grids, so that a further grid never makes the result worse. Asymptotic: monotone, and
/// the orders of all successive triples within 0.3 of each other (four or more grids), or within 0.3 of the formal order (three grids: one
/// order alone cannot confirm itself).
/// @param size          h, coarse first, strictly falling; at least three
/// @param formal_order  of the scheme, > 0
/// @param noise         twice the statistical error of the difference of the two finest values, in the unit of f; a smaller one has no
/// order
/// @throws ConfigError  as above
Convergence judge_convergence(std::span<const double> size, std::span<const double> value, double formal_order, double noise = 0.0);

}  // namespace mpm
