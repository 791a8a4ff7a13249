#pragma once
/// A case as runs to make and a judge of their results, so that other solvers can be held against the same references.
///
/// A case with set-ups names its runs in `setups` of its registration. Its `run` is the judge: it calls play() for every one of them and
/// sees the results instant by instant. play() makes the run with this program, or reads the results of another solver; the evaluation does
/// not depend on which, but for what is added by own_run().
///
///   std::vector<Setup> setups(const CaseContext& context);                    // physics, particles at t = 0, what to write back
///   void run(const CaseContext& context, CaseResult& result) {
///     for (const Setup& setup : setups(context)) {
///       play(context, setup, [&](const Instant& now) { ... measure ...; return true; });
///     }
///     result.check_relative(...);
///   }
///   const Registration registered{{.title = "...", .run = run, .setups = setups}};

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "libmpm/core/step.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/in_parallel.hpp"

namespace mpm::validation {

/// What a judge needs of the particles.
struct ParticleFields {
  bool position = true, velocity = true;
  bool stress = false;        ///< Cauchy
  bool volume_ratio = false;  ///< J
  bool identity = false;      ///< the particles of t = 0 are followed
};

/// One run to make.
struct Setup {
  std::string id;     ///< names its directory: "wedge-30-dx4"; unique in its case
  std::string title;  ///< what it is, in words
  Case spec;          ///< law, walls, obstacle, gravity, domain; cell size, CFL number and transfer are a suggestion to other solvers
  /// The particles of t = 0.
  std::function<State(const Case&, const Scene&)> start = [](const Case& c, const Scene& scene) { return make_state(c, scene); };
  std::vector<double> times;  ///< s, increasing: when to write results
  ParticleFields fields;      ///< of the particles at these times
  bool particles = true;      ///< false: only forces are needed
  bool forces = false;        ///< of the material on every boundary
  double time_step = 0.0;     ///< s, to be used as it is; 0: the solver's own choice
  /// What a solver has to do beyond moving the particles under gravity and the boundaries, in words; `solve` does it with this program.
  std::string procedure;
  /// Instead of advance(): brings the state to the next instant, and adds to the impulses of the boundaries since the last one.
  std::function<void(State&, Scene&, double time, std::vector<Vec3>& impulses)> solve;
};

/// One particle as a judge sees it.
struct ParticleRecord {
  std::uint64_t id = 0;
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();  ///< m, m/s; coordinates of the case
  double mass = 0.0;                                      ///< kg
  double stress[6] = {0, 0, 0, 0, 0, 0};                  ///< Cauchy, Pa, tension positive: xx yy zz xy xz yz
  double volume_ratio = 1.0;                              ///< J

  /// -tr(sigma)/3, Pa
  [[nodiscard]] double pressure() const { return -(stress[0] + stress[1] + stress[2]) / 3.0; }
};

/// What is known at one of the times of a set-up.
struct Instant {
  std::size_t index = 0;                  ///< of the set-up's times
  double time = 0.0, before = 0.0;        ///< s: this time and the one before (0 for the first)
  std::vector<ParticleRecord> particles;  ///< of the computed part, in a fixed order
  std::vector<Vec3> forces;               ///< N, on each boundary of the scene, mean from `before` to `time`
  const State* state = nullptr;           ///< of this program's own run, for pictures; null if another solver made the run
  const Scene* scene = nullptr;           ///< likewise
};

/// What a run took.
struct RunCost {
  double particle_steps = 0.0;  ///< 0 if another solver made the run
};

/// Called at every time of a set-up, in order; returns false when it needs no more.
using Visitor = std::function<bool(const Instant&)>;

/// Makes runs, or has them.
class RunSource {
 public:
  RunSource() = default;
  RunSource(const RunSource&) = delete;
  RunSource& operator=(const RunSource&) = delete;
  virtual ~RunSource() = default;
  /// Calls `visit` at the times of the set-up. @throws IoError, naming file and field, if results are missing
  virtual RunCost play(const Setup& setup, const Visitor& visit) const = 0;
};

/// The results of a set-up: computed here or read, according to the context.
RunCost play(const CaseContext& context, const Setup& setup, const Visitor& visit);

/// This program makes the runs: pictures can be drawn, and checks of its own scheme apply.
inline bool own_run(const CaseContext& context) { return context.source() == nullptr; }

/// play(i) for i < count, on all threads if this program makes the runs; one after the other if results are read.
template <class Task>
void play_in_parallel(const CaseContext& context, std::size_t count, Task&& play) {
  if (own_run(context)) {
    in_parallel(count, play);
  } else {
    for (std::size_t i = 0; i < count; ++i) play(i);
  }
}

/// The particles of a state as a judge sees them.
std::vector<ParticleRecord> particle_records(const State& state, const Scene& scene);

/// `count` equal steps from `from` to `to`, without `from`.
std::vector<double> even_times(double from, double to, std::size_t count);

/// Mass-weighted means of position and velocity.
struct MassCentre {
  double mass = 0.0;
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();
};
MassCentre mass_centre(const std::vector<ParticleRecord>& particles);

/// Names of the boundaries of a set-up's scene, in their order: "wall_1", ..., "obstacle".
std::vector<std::string> boundary_names(const Setup& setup);

}  // namespace mpm::validation
