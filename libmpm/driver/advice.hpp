#pragma once
/// Advice about a case that is valid but may not answer its question: too few cells, too short a time, values beyond those
/// of avalanches. The case runs nevertheless.

#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"

namespace mpm {

/// One piece of advice.
struct Advice {
  std::string rule;    ///< name of the rule: "cells_across"
  std::string what;    ///< the quantity with its value: "3 cells across the obstacle (w/dx)"
  std::string why;     ///< the consequence, with its source
  std::string remedy;  ///< the change, with a value: "take numerics.cell_size_m = 0.16"

  /// "what: why; remedy"
  [[nodiscard]] std::string text() const { return what + ": " + why + "; " + remedy; }
};

/// All advice about a case, in the order of the rules (advice.cpp: one rule, one function). Reads no file. A case without a conveyor gets
/// only the advice that applies to any case.
[[nodiscard]] std::vector<Advice> advise(const Case& c);

}  // namespace mpm
