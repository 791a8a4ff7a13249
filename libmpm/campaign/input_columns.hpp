#pragma once
/// Columns of results.csv that describe the cases of a campaign: the inputs of an impact.

#include <functional>
#include <vector>

#include "libmpm/driver/case.hpp"

namespace mpm {

/// An input of every table of impacts, whether it varies or not.
struct InputColumn {
  const char* column;                        ///< its heading
  const char* key;                           ///< of the case file, if the column shows one
  std::function<double(const Case&)> value;  ///< NaN if the case has no such input
};
/// The inputs in the order of the table.
[[nodiscard]] const std::vector<InputColumn>& input_columns();

}  // namespace mpm
