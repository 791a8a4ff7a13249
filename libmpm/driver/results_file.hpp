#pragma once
/// Files with the results of a run: results.json, profiles.h5.

#include <filesystem>
#include <string>
#include <vector>

#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Content of results.json: one object; unknown numbers are null.
[[nodiscard]] std::string results_text(const Results& results);
/// The same, added to the content of another results.json, whose entries of the same names are replaced.
/// @throws IoError, naming `path`, if `base` is not a JSON object
[[nodiscard]] std::string results_text(const Results& results, const std::string& base, const std::filesystem::path& path);

/// profiles.h5: time_s, z_m and, with a row for each sample and a column for each height, the quantities over height and time.
/// @param profiles  the first holds the heights, as mean
void write_profiles_over_time(const std::filesystem::path& path, std::span<const double> time, const std::vector<HeightProfile>& profiles);

}  // namespace mpm
