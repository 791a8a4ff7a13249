#pragma once
/// A quantity over time: the record of a gauge in an experiment, or what a run gives for it.

#include <filesystem>
#include <string>
#include <vector>

namespace mpm::validation {

/// Values at times that do not fall, linear between them and constant before the first and after the last.
struct TimeRecord {
  std::vector<double> time;   ///< s
  std::vector<double> value;  ///< in any unit

  /// Linear interpolation.
  [[nodiscard]] double at(double t) const;
  /// Mean over a time interval. @param from, to  s, from < to
  [[nodiscard]] double mean(double from, double to) const;
  /// First time at which the value rises through `level`, s; infinite if it never does.
  [[nodiscard]] double first_above(double level) const;
};

/// The rows of one quantity of a table with the columns quantity, time_s and value, sorted by time: rows digitised from a figure may be out
/// of order. @throws IoError if there is none
TimeRecord read_record(const std::filesystem::path& table, const std::string& quantity);

}  // namespace mpm::validation
