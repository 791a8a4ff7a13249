#include "libmpm/driver/checkpoint.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/checkpoint_blocks.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/joint_file.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "libmpm/parallel/joined_blocks.hpp"

namespace mpm {

namespace {

constexpr const char* file_kind = "libmpm checkpoint";

/// Calls count() with every counter and real() with every other number of a state and its run, in the order of the file.
template <class StateOrConst, class ProgressOrConst, class Count, class Real>
void for_each_number(StateOrConst& s, ProgressOrConst& p, Count&& count, Real&& real) {
  for (auto* x : {&s.step, &s.next_id, &s.source_count}) count(*x);
  for (auto* x : {&s.time, &s.max_speed, &p.wall_time, &p.step_time}) real(*x);
  for (auto* flux : {&s.entered, &s.left}) {
    for (auto* x : {&flux->count, &flux->through_x_max}) count(*x);
    for (auto* x : {&flux->mass, &flux->momentum.x(), &flux->momentum.y(), &flux->momentum.z(), &flux->energy}) real(*x);
  }
  for (auto* x : {&p.samples, &p.particle_steps, &p.initial_particles}) count(*x);
}

/// Datasets of observers have a point in their names; the program's own have none.
bool is_observed(const std::string& dataset) { return dataset.find('.') != std::string::npos; }

/// Writes everything except the blocks.
void write_rest(hdf5::Writer& file, const State& state, const RunProgress& progress, const Arrays& observed) {
  std::vector<std::uint64_t> counters;
  std::vector<double> reals;
  for_each_number(
      state, progress, [&](std::uint64_t x) { counters.push_back(x); }, [&](double x) { reals.push_back(x); });
  file.dataset<std::uint64_t>("counters", counters);
  file.dataset<double>("reals", reals);
  for (const auto& [name, values] : observed) {
    if (!is_observed(name)) throw Error(ExitCode::internal, fmt::format("array '{}' has no observer's name before it", name));
    file.dataset<double>(name, values);
  }
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const Case& c, const State& state, const RunProgress& progress,
                      const Arrays& observed, const std::filesystem::path& keep_as) {
  const auto make = [&](std::span<const BlockHead> heads) {
    auto file = std::make_unique<hdf5::Writer>(path);
    file->attribute("kind", std::string(file_kind));
    file->attribute("format_version", std::int64_t{checkpoint_format_version});
    file->attribute("case_hash", case_hash_text(c));
    file->attribute("case", write_case(c));
    file->attribute("precision", std::string(name_of(state.grid.precision())));
    declare_blocks(*file, state.grid.precision(), heads);
    write_rest(*file, state, progress, observed);
    return file;
  };
  write_blocks(state, make, keep_as);
}

void write_own_blocks(const State& state) { write_blocks(state, {}, {}); }

namespace {

/// The keys in which the case of a checkpoint differs, for a message.
std::string differences(const std::string& case_text, const Case& c) {
  try {
    const auto keys = case_differences(parse_case(case_text, checkpoint_file), c);
    if (!keys.empty()) return fmt::format("{}", fmt::join(keys, "; "));
  } catch (const ConfigError&) {  // written by another version: report the hashes
  }
  return "its hash differs";
}

/// Checks kind, version and case. @throws IoError, ConfigError
void check_header(const hdf5::Reader& file, const Case& c, const std::filesystem::path& path, const Refuse& refuse) {
  if (file.text("kind") != file_kind) refuse("this is not a checkpoint");
  if (file.integer("format_version") != checkpoint_format_version) {
    refuse(fmt::format("checkpoint format {}, this program reads {}; go on with the version of the program that wrote it",
                       file.integer("format_version"), checkpoint_format_version));
  }
  if (file.text("case_hash") != case_hash_text(c)) {
    throw ConfigError(
        fmt::format("{}: it belongs to another case: {}; put the case back, use another --out directory, or overwrite it with --force "
                    "instead of --resume",
                    path.string(), differences(file.text("case"), c)));
  }
}

/// All but the blocks.
void read_rest(const hdf5::Reader& file, State& state, RunProgress& progress, const Refuse& refuse) {
  const auto counters = file.dataset<std::uint64_t>("counters", {10});
  const auto reals = file.dataset<double>("reals", {14});
  if (!std::ranges::all_of(reals, [](double x) { return std::isfinite(x); }) || reals[0] < 0.0 || reals[1] < 0.0)
    refuse(fmt::format("time {} s, speed {} m/s, or a sum that is not finite: no run wrote this", reals[0], reals[1]));
  constexpr std::uint64_t most_ids = std::uint64_t{1} << 60;
  if (counters[1] > most_ids) refuse(fmt::format("the next particle has number {}: no run wrote this", counters[1]));
  auto counter = counters.begin();
  auto number = reals.begin();
  for_each_number(
      state, progress, [&](std::uint64_t& x) { x = *counter++; }, [&](double& x) { x = *number++; });
}

/// Throws that a file cannot be used.
Refuse refusing(const std::filesystem::path& path) {
  return [path](const std::string& why) { throw IoError(fmt::format("{}: {}", path.string(), why)); };
}

}  // namespace

void read_checkpoint(const std::filesystem::path& path, const Case& c, State& state, RunProgress& progress, Arrays& observed,
                     BlockExchange* ranks) {
  const hdf5::Reader file(path);
  const Refuse refuse = refusing(path);
  check_header(file, c, path, refuse);
  State found(c.numerics.cell_size, state.grid.precision());
  RunProgress at;
  read_rest(file, found, at, refuse);
  Arrays arrays;
  for (const std::string& name : file.datasets()) {
    if (is_observed(name)) arrays[name] = file.dataset<double>(name, {hdf5::any_extent});
  }
  const StoredBlocks blocks(file, found.grid.precision());
  const std::vector<BlockHead> heads = blocks.heads(refuse);
  if (ranks != nullptr) {
    const JoinedBlocks joined(make_scene(c), c.numerics.cell_size, found.time);
    ranks->instruct(Task::restore, found);
    Message where;
    put(where, std::span<const char>(std::filesystem::absolute(path).string()));
    ranks->share(where);
    ranks->cut(joined, heads);
    found.grid.divide(*ranks);
  }
  FirstError error;
  error.attempt([&] { blocks.restore_own(found.grid, found.next_id, refuse); });
  agree_on_errors(error, found.grid.ranks());
  found.grid.refresh();
  found.grid.ranks().done();

  // Everything is there: from here on nothing is refused.
  state = std::move(found);
  progress = at;
  observed = std::move(arrays);
}

void read_own_blocks(const Case& c, const Scene& scene, State& state, BlockExchange& ranks) {
  Message where;
  ranks.share(where);
  const std::filesystem::path path = MessageReader(where).text();
  ranks.cut(JoinedBlocks(scene, c.numerics.cell_size, state.time), {});
  Grid grid(c.numerics.cell_size, c.numerics.precision);
  grid.divide(ranks);
  FirstError error;
  error.attempt([&] {
    const hdf5::Reader file(path, hdf5::Seal::known_good);
    StoredBlocks(file, grid.precision()).restore_own(grid, state.next_id, refusing(path));
  });
  if (!agree_on_errors(error, ranks)) return;
  grid.refresh();
  state.grid = std::move(grid);
}

bool has_checkpoint(const std::filesystem::path& directory) {
  return std::filesystem::exists(directory / checkpoint_file) || std::filesystem::exists(directory / previous_checkpoint_file);
}

std::string resume_from_checkpoint(const std::filesystem::path& directory, const Case& c, State& state, RunProgress& progress,
                                   const AcceptCheckpoint& acceptable, BlockExchange* ranks) {
  std::vector<std::string> reasons;
  bool other_case = false;
  for (const char* name : {checkpoint_file, previous_checkpoint_file}) {
    try {
      State found(c.numerics.cell_size, c.numerics.precision);
      RunProgress at;
      Arrays observed;
      read_checkpoint(directory / name, c, found, at, observed, ranks);
      acceptable(found, at, observed);
      state = std::move(found);
      progress = at;
    } catch (const ConfigError& error) {
      other_case = other_case || reasons.empty();
      reasons.emplace_back(error.what());
      continue;
    } catch (const IoError& error) {
      reasons.emplace_back(error.what());
      continue;
    }
    if (reasons.empty()) return {};
    std::string kept;
    if (std::filesystem::exists(directory / checkpoint_file)) {
      rename_file(directory / checkpoint_file, directory / refused_checkpoint_file);
      kept = fmt::format(" (kept as {})", refused_checkpoint_file);
    }
    return fmt::format("{}{}; going on from {}", reasons.front(), kept, previous_checkpoint_file);
  }
  if (other_case) throw ConfigError(reasons.front());
  throw IoError(fmt::format("there is no checkpoint to go on from: {}; start from the beginning with --force instead of --resume",
                            fmt::join(reasons, "; and ")));
}

}  // namespace mpm
