#include "libmpm/boundary/wall_spec.hpp"

#include "libmpm/base/parameter_report.hpp"

namespace mpm {

void WallSpec::check(ParameterReport& report) const {
  if (report.sound("normal") && normal.isZero(0.0))
    report.problem("normal", "= [0, 0, 0] has no direction; give a vector that points into the material");
}

}  // namespace mpm
