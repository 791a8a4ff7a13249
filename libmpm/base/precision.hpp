#pragma once
/// Precision of a run's particles.

#include <cstdint>
#include <string_view>

namespace mpm {

/// Of the stored particles and of arithmetic on them. Nodes, boundaries and sums always have double precision.
enum class Precision : std::uint8_t {
  double_precision,  ///< 192 bytes a particle
  single_precision,  ///< 96 bytes a particle
};

/// As in cases and files.
constexpr std::string_view name_of(Precision precision) { return precision == Precision::single_precision ? "single" : "double"; }

}  // namespace mpm
