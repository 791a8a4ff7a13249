#pragma once
/// The list of all observers, and their output: the columns of series.csv and profile.csv and the entries of results.json.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/impact/grid_uncertainty.hpp"
#include "libmpm/impact/measure.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// How an impact is measured in a case, by the paper's procedure with the windows of [measurement]; empty without a conveyor or an
/// obstacle.
[[nodiscard]] std::optional<ImpactGeometry> impact_geometry(const Case& c);

/// How a case with a conveyor and an obstacle resolves the obstacle.
[[nodiscard]] GridResolution grid_resolution(const Case& c);
/// What of a material slows its convergence. A material without internal friction counts as a fluid.
[[nodiscard]] SnowTraits snow_traits(const MaterialParameters& snow);

/// The observers of a case, in the order of their columns. @param more  those of the caller, which come last
[[nodiscard]] std::vector<std::shared_ptr<Observer>> make_observers(const Case& c, const CaseScene& scene,
                                                                    const std::vector<std::shared_ptr<Observer>>& more = {});

/// The entries that results.json of a run of this case will have; their values are undefined.
[[nodiscard]] Results expected_results(const Case& c);

/// Output of one observer, without a run.
struct ObserverDescription {
  std::string name;              ///< Observer::name
  std::string cases;             ///< cases that it applies to: "cases with an obstacle"
  MeasuredFrom measured_from;    ///< what it needs
  std::vector<Column> columns;   ///< of series.csv
  std::vector<Column> profiles;  ///< columns of profile.csv
  std::vector<Result> results;   ///< their values are undefined
};

/// All output of a run and of `mpm post`.
[[nodiscard]] const std::vector<ObserverDescription>& describe_observers();

/// Nature of an entry of results.json; an unknown entry counts as physics. @param name a key, with "[0]" for a component
[[nodiscard]] Nature nature_of(std::string_view name);
/// Names of the entries of one nature that a run writes into results.json (not `mpm post`), in their order.
[[nodiscard]] std::vector<std::string> run_entries(Nature nature);

/// Tables of everything that can be measured, as Markdown.
[[nodiscard]] std::string observers_markdown();
/// The same as JSON {"columns": [...], "profiles": [...], "results": [...]}, for scripts that read runs.
[[nodiscard]] std::string observers_json();

}  // namespace mpm
