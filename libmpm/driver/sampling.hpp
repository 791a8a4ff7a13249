#pragma once
/// The instants at which a run is sampled and stored: at whole multiples of 1/series_per_second, and every so many samples as a frame.

#include <cstdint>

#include "libmpm/driver/case.hpp"

namespace mpm {

/// Index of the last sample, counted from 0 at t = 0: the first at or after the duration.
std::uint64_t last_sample(const Case& c);
/// Samples from one frame to the next; 0: no frames.
std::uint64_t samples_per_frame(const Case& c);

/// Samples and frames of one case.
class Sampling {
 public:
  /// @param c  only its [output] is used
  explicit Sampling(const Case& c) : per_second_(c.output.series_per_second), last_(last_sample(c)), per_frame_(samples_per_frame(c)) {}

  [[nodiscard]] std::uint64_t last() const { return last_; }  ///< number of the last sample; the first is 0
  /// Time of sample k, s.
  [[nodiscard]] double time(std::uint64_t k) const { return static_cast<double>(k) / per_second_; }
  [[nodiscard]] double end() const { return time(last_); }  ///< time of the last sample, s
  /// Whether sample k is stored as a frame.
  [[nodiscard]] bool has_frame(std::uint64_t k) const { return per_frame_ > 0 && k % per_frame_ == 0; }
  /// Number of frames of the first `samples` samples.
  [[nodiscard]] std::uint64_t frames(std::uint64_t samples) const {
    return per_frame_ > 0 && samples > 0 ? (samples - 1) / per_frame_ + 1 : 0;
  }

 private:
  double per_second_;
  std::uint64_t last_, per_frame_;
};

}  // namespace mpm
