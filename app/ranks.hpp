#pragma once
/// The processes of a run: one, unless mpirun or srun started several of a program that was built with MPI.

#include <memory>

#include "libmpm/driver/run.hpp"

namespace mpm::app {

/// This process as one of the ranks. Create one object, at the start of main().
class Session {
 public:
  /// Starts MPI if there is more than one rank. @throws ConfigError if a launcher started several, and this program has no MPI
  Session(int& argc, char**& argv);
  ~Session();

  /// Whether this program can be started as several ranks: it was built with MPI.
  [[nodiscard]] static bool can_be_several();
  [[nodiscard]] bool first() const;  ///< whether this is the rank that reads the command line and reports
  [[nodiscard]] int size() const;    ///< number of ranks
  /// Called on the other ranks: takes part in the runs of the first until it ends. @returns the exit code; ends all ranks if this one fails
  int serve();
  /// run_case(), with all ranks.
  RunResult run(const Case& c, RunOptions options);
  /// Called when the first rank ends: ends the others, at once if they wait in a step for a rank that failed. @param exit_code  of this
  /// rank
  void close(int exit_code);

 private:
  struct Group;
  std::unique_ptr<Group> group_;  ///< null: one rank
};

/// The ranks of this program.
Session& session();

/// @throws ConfigError if this program cannot be started as so many ranks
void require_mpi(int ranks);

}  // namespace mpm::app
