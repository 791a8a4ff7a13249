#pragma once
/// Results of earlier campaigns, from their results.csv: a campaign goes on with them where the folders of its runs are not there.

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/observe/results.hpp"

namespace mpm {

/// An input of every table of impacts, whether it varies or not.
struct InputColumn {
  const char* column;                        ///< its heading
  const char* key;                           ///< of the case file, if the column shows one
  std::function<double(const Case&)> value;  ///< NaN if the case has no such input
};
/// The inputs in the order of the table.
[[nodiscard]] const std::vector<InputColumn>& input_columns();

/// Rows of finished runs, by the hash of their case.
class StoredResults {
 public:
  /// @throws IoError if a file cannot be read or is not a table of results
  explicit StoredResults(const std::vector<std::filesystem::path>& tables);

  /// The row of a case, if it is of its whole duration (is_whole_run of driver/run_folder.hpp): its columns except for the inputs, vectors
  /// by component. The first such row counts.
  [[nodiscard]] std::optional<Results> of(const Case& c, const std::string& case_hash) const;
  [[nodiscard]] std::size_t rows() const { return rows_.size(); }  ///< finished runs in all tables

 private:
  std::multimap<std::string, Results> rows_;  ///< by case hash
};

}  // namespace mpm
