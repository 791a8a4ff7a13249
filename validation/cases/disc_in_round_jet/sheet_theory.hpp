#pragma once
/// A round jet of diameter D and speed U on a flat disc of diameter d across its middle, incompressible, without gravity, with free
/// surfaces: the table reference_data/round_jet_on_disc, between its rows by cubic polynomials.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <span>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/norms.hpp"

namespace mpm::validation {

class DiscInJet {
 public:
  /// @param data  the table
  explicit DiscInJet(const std::filesystem::path& data) {
    const Table table = Table::read(data);
    ratio_ = table.numbers("d_over_D");
    if (ratio_.size() < 4) throw ConfigError("DiscInJet: the table needs four rows at least");
    force_ = table.numbers("force"), drag_ = table.numbers("drag_coefficient");
    for (const double apart : table.numbers("apart")) apart_ = larger(apart_, apart);
  }
  /// Force over rho U^2 times the section of the jet. @param ratio  d/D, within the table; ConfigError otherwise
  [[nodiscard]] double force(double ratio) const {
    if (!(ratio >= ratio_.front() && ratio <= ratio_.back()))
      throw ConfigError(fmt::format("DiscInJet: d/D = {} must be within the table, {} to {}", ratio, ratio_.front(), ratio_.back()));
    const auto above = static_cast<std::size_t>(std::ranges::lower_bound(ratio_, ratio) - ratio_.begin());
    const std::size_t first = std::min(above > 2 ? above - 2 : 0, ratio_.size() - 4);
    return polynomial_through(std::span(ratio_).subspan(first, 4), std::span(force_).subspan(first, 4), ratio);
  }
  /// Angle of the sheet far away to the jet's direction, degrees.
  [[nodiscard]] double angle(double ratio) const { return std::acos(1.0 - force(ratio)) * 180.0 / std::numbers::pi; }
  /// Of the widest disc: force over rho U^2 times the section of the jet.
  [[nodiscard]] double widest_force() const { return force_.back(); }
  /// Force over rho U^2/2 times the area of the disc, as d/D -> 0: parabola in (d/D)^2 through the three narrowest discs.
  [[nodiscard]] double drag_in_stream() const {
    double squares[3];
    for (std::size_t i = 0; i < 3; ++i) squares[i] = ratio_[i] * ratio_[i];
    return polynomial_through(squares, std::span(drag_).first(3), 0.0);
  }
  /// The table as a line of a plot.
  [[nodiscard]] Series force_line() const { return {"exact", ratio_, force_, Series::Style::reference}; }
  /// Largest difference between the forces from pressure and from momentum, relative.
  [[nodiscard]] double apart() const { return apart_; }

 private:
  /// Value at `at` of the polynomial through all the points (x, y): Lagrange's form.
  static double polynomial_through(std::span<const double> x, std::span<const double> y, double at) {
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      double weight = y[i];
      for (std::size_t k = 0; k < x.size(); ++k)
        if (k != i) weight *= (at - x[k]) / (x[i] - x[k]);
      sum += weight;
    }
    return sum;
  }

  std::vector<double> ratio_, force_, drag_;
  double apart_ = 0.0;
};

}  // namespace mpm::validation
