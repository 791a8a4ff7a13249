#pragma once
/// Which run of the suite this was.

#include <filesystem>
#include <optional>
#include <string>

#include "validation/harness/case.hpp"

namespace mpm::validation {

/// Which run this was.
struct RunInfo {
  Level level = Level::quick;
  std::string command;  ///< as typed
  std::string machine;  ///< processor and number of threads the machine offers
  std::string started;  ///< ISO 8601, UTC
  int threads = 1;
  Precision precision = Precision::double_precision;  ///< of the particles, in the runs that begin with a case file
  std::string solver;                                 ///< that made the runs; empty: this program
  double wall_time_s = 0.0;
  std::filesystem::path directory;  ///< of the report; set by write_results
};

/// Wall time that all cases of a level together may take on two idle cores, s; none for full.
std::optional<double> time_budget(Level level);

/// Processor model and number of threads of this machine.
std::string describe_machine();

}  // namespace mpm::validation
