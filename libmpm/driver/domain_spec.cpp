#include "libmpm/driver/domain_spec.hpp"

#include <fmt/format.h>

#include "libmpm/base/parameter_report.hpp"

namespace mpm {

void DomainSpec::check(ParameterReport& report) const {
  for (int axis = 0; axis < 3 && report.all_sound({"min_m", "max_m"}); ++axis) {
    if (!(min[axis] < max[axis]))
      report.problem("max_m", fmt::format("is not above min_m in {}: {} <= {}; exchange them", "xyz"[axis], max[axis], min[axis]));
  }
}

}  // namespace mpm
