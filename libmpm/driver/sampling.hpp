#pragma once
/// The instants at which a run is sampled and stored: at whole multiples of 1/series_per_second, and every so many samples as a frame.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "libmpm/driver/case.hpp"

namespace mpm {

/// Samples and frames of one case. All that a run, a replay or an estimate knows of them comes from here.
class Sampling {
 public:
  /// @param c  only its [output] is used
  explicit Sampling(const Case& c)
      : per_second_(c.output.series_per_second), last_(last_sample(c.output)), per_frame_(samples_per_frame(c.output)) {}

  [[nodiscard]] std::uint64_t last() const { return last_; }  ///< number of the last sample; the first is 0, at t = 0
  /// Time of sample k, s.
  [[nodiscard]] double time(std::uint64_t k) const { return static_cast<double>(k) / per_second_; }
  [[nodiscard]] double end() const { return time(last_); }  ///< time of the last sample, s
  /// Frames that are stored, 1/s; 0: none.
  [[nodiscard]] double frames_per_second() const { return per_frame_ > 0 ? per_second_ / static_cast<double>(per_frame_) : 0.0; }
  /// Whether sample k is stored as a frame.
  [[nodiscard]] bool has_frame(std::uint64_t k) const { return per_frame_ > 0 && k % per_frame_ == 0; }
  /// Number of frames of the first `samples` samples.
  [[nodiscard]] std::uint64_t frames(std::uint64_t samples) const {
    return per_frame_ > 0 && samples > 0 ? (samples - 1) / per_frame_ + 1 : 0;
  }

 private:
  /// The first sample at or after the duration.
  static std::uint64_t last_sample(const OutputSpec& o) {
    return static_cast<std::uint64_t>(std::ceil(o.duration * o.series_per_second - 1e-9));
  }
  /// Samples from one frame to the next, the nearest whole number; 0: no frames.
  static std::uint64_t samples_per_frame(const OutputSpec& o) {
    if (!(o.frames_per_second > 0.0)) return 0;
    constexpr double longest = 1e18;  // samples; fits into the integer
    return static_cast<std::uint64_t>(std::clamp(std::round(o.series_per_second / o.frames_per_second), 1.0, longest));
  }

  double per_second_;
  std::uint64_t last_, per_frame_;
};

}  // namespace mpm
