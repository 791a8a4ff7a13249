#include "libmpm/driver/worker.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/core/health.hpp"
#include "libmpm/driver/checkpoint.hpp"
#include "libmpm/driver/observers.hpp"
#include "libmpm/driver/pieces.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/observe/observer_list.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "libmpm/parallel/ownership.hpp"

namespace mpm {

namespace {

/// Counts of all ranks, on the first; elsewhere nothing.
std::vector<RankCounts> gathered_counts(const State& state, BlockExchange& ranks) {
  RankCounts own = ranks.counts();
  state.grid.for_each_particle([&](const Particle&) { ++own.particles; });
  Message mine;
  put(mine, own);
  std::vector<RankCounts> all;
  for (const Message& message : ranks.gather(std::move(mine))) all.push_back(MessageReader(message).get<RankCounts>());
  return all;
}

}  // namespace

std::string report_of_ranks(const State& state, BlockExchange& ranks) {
  ranks.instruct(Task::report, state);
  auto all = nlohmann::ordered_json::array();
  for (const RankCounts& c : gathered_counts(state, ranks)) {
    all.push_back({{"rank", all.size()},
                   {"particles", c.particles},
                   {"steps", c.steps},
                   {"particle_steps", c.particle_steps},
                   {"block_steps", c.block_steps},
                   {"border_block_steps", c.border_steps},
                   {"neighbour_steps", c.neighbour_steps},
                   {"messages", c.messages},
                   {"part_bytes", c.part_bytes},
                   {"node_bytes", c.node_bytes},
                   {"migrant_bytes", c.migrant_bytes},
                   {"exchanges", c.exchanges},
                   {"reductions", c.reductions},
                   {"reduced_bytes", c.reduced_bytes},
                   {"gathers", c.gathers},
                   {"gathered_bytes", c.gathered_bytes},
                   {"moves", c.moves},
                   {"part_wait_s", c.part_wait},
                   {"node_wait_s", c.node_wait},
                   {"migrant_wait_s", c.migrant_wait},
                   {"reduction_wait_s", c.reduction_wait}});
  }
  ranks.done();
  return nlohmann::ordered_json{{"ranks", all}}.dump(1) + "\n";
}

void work_on(const Case& c, BlockExchange& ranks) {
  const CaseScene scene = make_scene(c);
  const ObserverList observers(make_observers(c, scene));
  State state(c.numerics.cell_size, c.numerics.precision);
  state.grid.divide(ranks);
  Grid nothing(c.numerics.cell_size, c.numerics.precision);
  for (;;) {
    const Instruction instruction = ranks.next_instruction(state);
    try {
      switch (instruction.task) {
        case Task::start: state = make_state(c, scene, &ranks); break;
        case Task::restore: read_own_blocks(c, scene, state, ranks); break;
        case Task::step: step(state, scene, instruction.dt); break;
        case Task::totals: totals(state, scene); break;
        case Task::fastest: fastest_particle(state); break;
        case Task::inside: particles_inside_boundaries(state, scene); break;
        case Task::observe:
          collect_blocks(
              state.grid, [&](const Block& b) { return observers.visits(b, scene, c.numerics.cell_size); }, nothing);
          break;
        case Task::particles: {
          SnapshotWriter file;
          write_particles(file, state, scene);
          break;
        }
        case Task::blocks: write_own_blocks(state); break;
        case Task::report: gathered_counts(state, ranks); break;
        case Task::end: return;
      }
      ranks.done();
    } catch (const UnstableError&) {
      if (ranks.busy()) throw;  // else every rank has this error, and the first reports it
    }
  }
}

}  // namespace mpm
