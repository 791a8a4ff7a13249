#include "libmpm/driver/point_path.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "targets.hpp"

namespace mpm::fuzz {

void point_path(Bytes input) {
  PathSpec path;
  try {
    path = parse_path({reinterpret_cast<const char*>(input.data()), input.size()}, "path.toml");
  } catch (const ConfigError&) {
    return;
  }
  constexpr double longest = 500.0;  // steps; a long path takes its time, which is no fault
  const double steps = static_cast<double>(path.segments.size()) * path.steps_per_segment;
  if (steps > longest) return;
  try {
    const auto rows = follow_path(path);
    require(rows.size() == static_cast<std::size_t>(steps) + 1, "a row for each step");
    for (const PathRow& r : rows) {
      for (const double x : {r.eps_v, r.eps_q, r.p, r.q, r.eps_v_plastic, r.preconsolidation_pressure, r.yield})
        require(std::isfinite(x), fmt::format("step {}: a column holds {}", r.step, x));
    }
  } catch (const ConfigError&) {
  } catch (const UnstableError&) {
  }
}

}  // namespace mpm::fuzz
