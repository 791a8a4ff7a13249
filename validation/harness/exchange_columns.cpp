#include "validation/harness/exchange_columns.hpp"

#include <fmt/format.h>

namespace mpm::validation {

std::vector<std::string> state_columns(const ParticleFields& fields, bool with_id) {
  std::vector<std::string> columns;
  const auto add = [&](const std::vector<std::string>& more) { columns.insert(columns.end(), more.begin(), more.end()); };
  if (with_id) columns.emplace_back("id");
  if (fields.position) add(position_columns);
  if (fields.velocity) add(velocity_columns);
  if (fields.stress) add(stress_columns);
  if (fields.volume_ratio) columns.emplace_back("volume_ratio");
  return columns;
}

std::string state_number(std::size_t index) { return fmt::format("{:04}", index + 1); }

}  // namespace mpm::validation
