#pragma once
/// Savitzky-Golay smoothing: a local polynomial fitted by least squares.

#include <span>
#include <vector>

namespace mpm {

/// Smooths equally spaced values: each one is replaced by the value, at its own place, of the polynomial of degree `order` fitted to the
/// `window` values around it (Savitzky and Golay 1964, Anal. Chem. 36, 1627).
///
/// Ends: the first and the last (window - 1)/2 values are taken from the one polynomial fitted to the first or last `window` values
/// (`mode='interp'` of scipy.signal.savgol_filter, its default), so that polynomials up to `order` pass unchanged everywhere.
/// @param window odd, > order, at most the number of values. @param order degree, >= 0.
/// @throws ConfigError when these do not hold.
[[nodiscard]] std::vector<double> savitzky_golay(std::span<const double> values, int window, int order);

}  // namespace mpm
