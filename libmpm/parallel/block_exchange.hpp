#pragma once
/// The messages that ranks exchange in a step.
///
/// In each step a rank sends one message of each kind to each of its few neighbours:
///
///   parts     contributions of its particles to nodes of the neighbour's blocks, block by block, unsummed. They are sent when the outer
///             blocks are on the grid, and travel while the other blocks follow
///   nodes     values of own nodes that the neighbour's particles touch. They are sent after the grid update, and travel while the
///             particles of the other blocks move
///   migrants  after the particles have moved
///
/// Around obstacles the correction of lumped masses needs some nodes and parts once more.
///
/// All small reductions over all ranks come when the particles have moved, so that a rank waits for the others only once in a step: the
/// largest speed (and whether a step failed), the sums over blocks (of impulses, for example), whether the set of border blocks changed,
/// and the largest load. If the set changed, neighbours exchange the lists of their blocks with particles at the common border. Both sides
/// derive the layouts of all messages (HaloPlan) from these lists.

#include <map>
#include <vector>

#include "libmpm/core/ranks.hpp"
#include "libmpm/parallel/halo_exchange.hpp"
#include "libmpm/parallel/ownership.hpp"

namespace mpm {

/// What the ranks of a program do together: the first rank decides (driver/worker.hpp).
struct Task : CoreTask {
  /// Besides those of the core.
  enum Number : TaskNumber {
    inside = CoreTask::count,  ///< particles that start inside a boundary
    observe,                   ///< particles that an observer wants to see
    particles,                 ///< all particles by their numbers, for a file
    blocks,                    ///< all blocks in their order, for a file
    report,                    ///< what was exchanged
    start,                     ///< the particles of t = 0
    restore,                   ///< the particles of a checkpoint
    end,                       ///< nothing follows
  };
};

/// What the first rank sends to start a task.
struct Instruction {
  TaskNumber task = Task::end;  ///< what to do
  double dt = 0.0;              ///< time step, s; CoreTask::step only
};

/// Implements Ranks with messages. Every rank creates one and passes it to Grid::divide.
class BlockExchange : public Ranks {
 public:
  /// Rank 0 owns all blocks until the first step. @param transport  must outlive this object
  explicit BlockExchange(Transport& transport, const Balancing& balancing = {}) : transport_(transport), ownership_(transport, balancing) {}

  [[nodiscard]] int size() const override { return transport_.size(); }
  [[nodiscard]] int rank() const override { return transport_.rank(); }
  void sum(std::span<std::uint64_t> numbers) override;
  std::vector<Message> gather(Message mine) override;
  void share(Message& message) override { transport_.broadcast(message); }
  std::map<int, Message> exchange(std::map<int, Message> to) override { return transport_.exchange(std::move(to)); }

  void instruct(TaskNumber task, const State& state, double dt = 0.0) override;
  void done() override;
  [[nodiscard]] bool busy() const { return busy_; }  ///< whether a task has started and not ended
  /// Waits for the first rank; called by the others. @param state  gets the scalars of the first rank's state
  Instruction next_instruction(State& state);

  [[nodiscard]] bool owns(const Index3& block) const override { return ownership_.owns(block); }
  [[nodiscard]] bool at_border(const Index3& block) const override { return ownership_.at_border(block); }
  void begin_step(State& state, const Scene& scene, double dt) override;
  void send_parts(const NodeFields& fields, const BlockChoice& givers = {}) override { halo_.send_parts(fields, plan_.of(givers)); }
  void add_parts(const NodeFields& fields) override { halo_.add_parts(fields); }
  void send_nodes(const NodeFields& fields, const BlockChoice& givers = {}) override { halo_.send_nodes(fields, plan_.of(givers)); }
  void receive_nodes(const NodeFields& fields) override { halo_.receive_nodes(fields); }
  double largest_or_throw(double own, const std::optional<BlockError>& error) override;
  void exchange_migrants(Grid& grid) override;
  std::vector<std::int32_t> announce(Grid& grid) override;
  void plan(Grid& grid) override;
  [[nodiscard]] std::size_t particle_count(std::size_t own) const override { return now_ ? now_->particles : own; }
  void progress() noexcept override { transport_.progress(); }
  [[nodiscard]] bool measures() const override { return ownership_.measures(); }
  void note_time(const Block& block, std::int32_t index, int particles, double time) noexcept override {
    costs_.note(block, index, particles, time);
  }

  /// Before there are particles on any rank: cuts by the number of particles that each block will hold; all ranks call it.
  /// @param heads  on the first rank
  void cut(const JoinedBlocks& joined, std::span<const BlockHead> heads);
  [[nodiscard]] const RankCounts& counts() const { return counts_; }  ///< of this rank, without RankCounts::particles

 private:
  [[nodiscard]] Borders borders_of(const Grid& grid) const;
  void exchange_borders();
  [[nodiscard]] std::vector<std::int32_t> required_blocks(Grid& grid) const;
  void reduce(std::size_t bytes);
  void begin(TaskNumber task);

  Transport& transport_;
  Ownership ownership_;
  BlockCosts costs_;
  HaloPlan plan_;
  Borders mine_, theirs_;
  std::vector<Index3> occupied_;      ///< own blocks with particles, at the last announce()
  std::vector<std::int32_t> needed_;  ///< blocks that must exist, as returned then
  std::optional<Evenness> now_;       ///< load, as of then
  bool busy_ = false;
  bool counting_ = true;    ///< the current task does not move particles for files or observers
  bool fresh_ = true;       ///< owners have changed since
  bool unchanged_ = false;  ///< the last announce() found the same blocks as the one before
  std::size_t own_particles_ = 0, border_blocks_ = 0;
  double own_cost_ = 0.0;  ///< of the own blocks for a step, as of then, s
  RankCounts counts_;
  StepClock clock_;  ///< of the steps that are measured
  HaloExchange halo_{transport_, clock_, counts_};
};

}  // namespace mpm
