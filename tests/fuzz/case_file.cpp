#include <fmt/format.h>

#include <cmath>
#include <sstream>
#include <string_view>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/estimate.hpp"
#include "libmpm/driver/scene.hpp"
#include "targets.hpp"

namespace mpm::fuzz {

namespace {

constexpr double memory = 16e9;  // bytes; of the machine that is asked for

/// Every line says where.
void require_places(const std::string& message) {
  std::istringstream lines(message);
  std::string line;
  require(!message.empty(), "a refusal has a message");
  while (std::getline(lines, line)) {
    require(line.starts_with("case.toml:") || line.starts_with("--set "), "a fault without its place: " + line);
  }
}

/// A state is about as large as its estimate; lattices of small bodies are rounded to whole particles, each at least one.
void require_state_as_estimated(const Case& c, const Estimate& e) {
  const CaseScene scene = make_scene(c);
  const State state = make_state(c, scene);
  const double particles = static_cast<double>(state.grid.particle_count());
  require(particles <= 8.0 * e.particles + 8.0 * static_cast<double>(c.bodies.size()) + 512.0,
          fmt::format("{} particles, {} were estimated", particles, e.particles));
}

}  // namespace

void case_file(Bytes input) {
  std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  std::vector<std::string> overrides;
  constexpr std::string_view set = "#set ";
  while (text.starts_with(set)) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    overrides.emplace_back(text.substr(set.size(), end - set.size()));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  Case c;
  try {
    c = parse_case(text, "case.toml", overrides);
  } catch (const ConfigError& error) {
    return require_places(error.what());
  }
  const std::string written = write_case(c);
  Case again;
  try {
    again = parse_case(written, "written.toml");
  } catch (const Error& error) {
    throw Problem(fmt::format("a written case is refused: {}\n{}", error.what(), written));
  }
  require(again == c, "a written case reads back to another case:\n" + written);
  require(case_hash(again) == case_hash(c), "a written case reads back to another hash:\n" + written);
  require(write_case(again) == written, "a written case is written otherwise the second time:\n" + written);

  const Estimate e = estimate(c);
  for (const double x : {e.particles, e.cells, e.wave_speed, e.time_step, e.steps, e.particle_steps, e.memory_bytes, e.wall_time_s})
    require(std::isfinite(x) && x > 0.0, fmt::format("an estimate of {}:\n{}", x, written));
  try {
    require_feasible(e, memory);
    constexpr double small = 2000.0;  // particles
    if (e.particles < small) require_state_as_estimated(c, e);
  } catch (const ConfigError&) {    // refused in time
  } catch (const UnstableError&) {  // a material that cannot carry its own weight
  }
}

}  // namespace mpm::fuzz
