#pragma once
/// How wide the numbers of a run's particles are.

#include <cstdint>
#include <string_view>

namespace mpm {

/// Of particles as they are stored, and of the arithmetic on them. Nodes, boundaries and sums are in double precision with both.
enum class Precision : std::uint8_t {
  double_precision,  ///< 192 bytes a particle
  single_precision,  ///< 96 bytes a particle
};

/// As in cases and files.
constexpr std::string_view name_of(Precision precision) { return precision == Precision::single_precision ? "single" : "double"; }

}  // namespace mpm
