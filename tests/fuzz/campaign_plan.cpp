#include "libmpm/campaign/plan.hpp"

#include <fmt/format.h>

#include <string_view>

#include "libmpm/base/error.hpp"
#include "targets.hpp"

namespace mpm::fuzz {

void campaign_plan(Bytes input) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  // Files that a plan names are not the input.
  for (const char* other : {"base = \"", "base = '", "table", "include", "base=", "\"base\"", "'base'"}) {
    if (text.find(other) != std::string_view::npos) return;
  }
  constexpr std::size_t most_runs = 200;
  CampaignPlan plan;
  try {
    plan = parse_plan(text, "plan.toml");
  } catch (const Error&) {
    return;
  }
  if (plan.runs.size() > most_runs) return;
  const std::string written = write_plan(plan);
  const CampaignPlan again = parse_plan(written, "written.toml");
  require(again.runs == plan.runs, "a written plan reads back to other runs:\n" + written);
}

}  // namespace mpm::fuzz
