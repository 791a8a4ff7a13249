#pragma once
/// The study of `mpm converge`: a campaign of one case at several values of a numerical parameter, its notes and its files.
/// driver/metric_convergence.hpp judges the metrics.

#include <filesystem>
#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"
#include "libmpm/campaign/folder.hpp"
#include "libmpm/driver/metric_convergence.hpp"

namespace mpm {

/// The case at every value of the sweep. The runs are called dx0.25, ppc8, cfl0.4 or offset0.5; their frames and final states are kept.
/// @param sweep  in the order of in_order(). @throws ConfigError if a case is invalid
[[nodiscard]] Campaign make_grid_study(const Case& c, const Sweep& sweep, int threads, int ranks);

/// What makes a study of this case unreliable: sizes that are too close, an obstacle with fewer than three cells or no whole number of
/// them, measuring windows that follow the grid.
[[nodiscard]] std::vector<std::string> study_notes(const Case& c, const Sweep& sweep);

/// Text of converge.json: the points, the notes and the metrics; null where there is no value.
/// @param status  of the runs of the study, all done
[[nodiscard]] std::string converge_json(const Case& c, const Sweep& sweep, const Campaign& study, const std::vector<RunStatus>& status,
                                        const std::vector<MetricConvergence>& metrics);
/// Writes converge.csv: one row a value of the parameter; for every metric its value, standard error and, with an exact value, its error.
void write_converge_table(const std::filesystem::path& path, const Sweep& sweep, const std::vector<MetricConvergence>& metrics);

}  // namespace mpm
