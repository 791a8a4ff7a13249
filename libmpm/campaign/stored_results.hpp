#pragma once
/// Results of earlier campaigns, from their results.csv: a campaign goes on with them where the folders of its runs are not there.

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libmpm/driver/case.hpp"

namespace mpm {

/// Rows of finished runs, by the hash of their case.
class StoredResults {
 public:
  /// @throws IoError if a file cannot be read or is not a table of results
  explicit StoredResults(const std::vector<std::filesystem::path>& tables);

  /// The row of a case, if it is of its whole duration (is_whole_run of driver/run_folder.hpp), as the text of a results.json: its columns
  /// except for the inputs. The first such row counts.
  [[nodiscard]] std::optional<std::string> of(const Case& c, const std::string& case_hash) const;
  [[nodiscard]] std::size_t rows() const { return rows_.size(); }  ///< finished runs in all tables

 private:
  std::multimap<std::string, std::string> rows_;  ///< case hash, text of a results.json
};

}  // namespace mpm
