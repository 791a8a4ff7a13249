#pragma once
/// What has to hold between the components of a case. What holds within one of them, each checks itself.

#include "libmpm/driver/case.hpp"

namespace mpm {

class ParameterReport;

/// Checks a case whose tables were read, and completes what one table leaves to another (speed and width of the belt, friction of the
/// obstacle). Names are paths: "numerics.cell_size_m".
void resolve_case(Case& c, ParameterReport& report);

}  // namespace mpm
