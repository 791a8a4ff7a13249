#pragma once
/// A predicted value beside its reference: the points of the summary that opens the report.
///
/// A check takes part if it gives the kind of its quantity and the uncertainty of its reference:
///
///   result.check_relative(Label::validation, "steady run-up", runup, equation, "m", 0.2, "...").in_summary(Quantity::run_up, 0.13);

#include <string>

namespace mpm::validation {

/// The kinds of quantities of the summary, one plot each. To add one, add its row to the table in comparison.cpp.
enum class Quantity {
  force,            ///< N; of a slice one cell wide, of a metre of width or of a whole mast
  pressure,         ///< Pa
  run_up,           ///< m, height above the floor or the start that a flow or a body reaches
  pressure_height,  ///< m, height of the hydrostatic column with the same force
  run_out,          ///< m, distance that a collapse or a sliding body travels
  depth,            ///< m, of a layer or a deposit
  displacement,     ///< m, settlement
  speed,            ///< m/s, of fronts, waves and flows
  angle,            ///< degrees
  time,             ///< s
  frequency,        ///< Hz
  density,          ///< kg/m^3
};

/// Name and unit of a quantity in the report.
struct QuantityText {
  std::string name, unit;
};
QuantityText text_of(Quantity quantity);

/// One point of the summary.
struct Comparison {
  Quantity quantity = Quantity::force;
  double predicted = 0.0, reference = 0.0;  ///< in the unit of the quantity
  /// Relative standard deviation of the reference: 0 for an exact solution, the scatter for an experiment or a regression.
  double reference_uncertainty = 0.0;

  /// |predicted/reference| where it is positive and finite, so that it has a logarithm; otherwise NaN.
  [[nodiscard]] double ratio() const;
};

/// Both numbers in the quantity's unit.
/// @param unit  of `predicted` and `reference`: that of the quantity or a multiple of it with a prefix (kPa, mm)
/// @throws ConfigError for another unit, or an uncertainty that is negative or not finite
Comparison make_comparison(Quantity quantity, double predicted, double reference, const std::string& unit, double reference_uncertainty);

}  // namespace mpm::validation
