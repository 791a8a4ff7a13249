#include "libmpm/driver/sampling.hpp"

#include <algorithm>
#include <cmath>

namespace mpm {

std::uint64_t last_sample(const Case& c) {
  return static_cast<std::uint64_t>(std::ceil(c.output.duration * c.output.series_per_second - 1e-9));
}

std::uint64_t samples_per_frame(const Case& c) {
  if (!(c.output.frames_per_second > 0.0)) return 0;
  constexpr double longest = 1e18;  // samples; fits into the integer
  return static_cast<std::uint64_t>(std::clamp(std::round(c.output.series_per_second / c.output.frames_per_second), 1.0, longest));
}

}  // namespace mpm
