#include "libmpm/core/numerics.hpp"

#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"

namespace mpm {

void Numerics::check_offset(const MirrorPlanes& mirror, ParameterReport& report) const {
  const bool mirrored[] = {mirror.x, mirror.y};
  for (int axis = 0; axis < 2; ++axis) {
    if (!mirrored[axis] || grid_offset[axis] == 0.0) continue;
    const std::string name(1, "xy"[axis]);
    report.problem("grid_offset_cells", "shifts the mirror plane " + name + " = 0 off the grid by " + number_text(grid_offset[axis]) +
                                            " cells in " + name + "; give 0 there, or compute the whole without the mirror");
  }
}

}  // namespace mpm
