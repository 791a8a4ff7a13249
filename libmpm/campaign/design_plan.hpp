#pragma once
/// Makes an ensemble of runs from a site: every snow on two or three grids, as a campaign.

#include <string>
#include <vector>

#include "libmpm/campaign/campaign.hpp"
#include "libmpm/campaign/site.hpp"
#include "libmpm/driver/advice.hpp"

namespace mpm {

/// Time limit of an ensemble.
enum class DesignLevel : std::uint8_t {
  quick,     ///< at most ten minutes on two cores
  standard,  ///< at most an hour on two cores
};
/// As in design_plan.json: "quick".
std::string to_string(DesignLevel);

/// Particle-steps that fit into the time of a level at assumed_particle_steps_per_s, with a sixth of it reserved for the page.
[[nodiscard]] double design_budget(DesignLevel level);

/// A run of the ensemble.
struct DesignRun {
  std::string name;  ///< of its folder
  std::size_t snow;  ///< index into DesignPlan::snows
  std::size_t grid;  ///< index into DesignPlan::cells
};

/// The runs for a site.
struct DesignPlan {
  Site site;                           ///< resolved
  DesignLevel level;                   ///< time limit
  std::vector<std::string> overrides;  ///< "table.key=value" of a case file, for all runs
  std::vector<SiteSnow> snows;         ///< each with its source
  std::vector<int> cells;              ///< in the smaller of w and H, coarse first
  std::vector<double> cell_size;       ///< m, of each grid
  double duration = 0.0;               ///< s, of each run
  std::vector<DesignRun> runs;         ///< snow by snow, coarse first
  Campaign campaign;                   ///< the same runs, in this order
  double particle_steps = 0.0;         ///< estimated, of all runs
};

/// Grids: of the sets {3, 5, 7}, {5, 7, 11}, {7, 11, 15}, {11, 15, 21} (ratios above 1.3, odd numbers) the finest that fits into the budget
/// of the level; {3, 5} if none does. [plan] may prescribe them.
///
/// Each run: a window in whole mast widths, at least 4 r upstream, depth of the mast + r downstream and a belt of 6 r, r = max(w, sqrt(w
/// H)) (with w = H: 3 % of run-up and force, validation/cases/avalanche_convergence; else assumed), at least 5 r more than an arm is long
/// (assumed); half of it computed; measuring windows in metres, the same on all grids; 100 rows a second; numerics by the program's
/// defaults; gravity g cos(slope) without a slope, so that the flow keeps its speed. Duration: 2 v/g for the first splash, then max(3 v/g,
/// 3 s); at least a distance of 20 max(w, H) (the paper's slowest runs: 14 H and more).
/// @param overrides  "table.key=value" of a case file, for all runs; no key that the site decides
/// @throws ConfigError
[[nodiscard]] DesignPlan make_design(const Site& site, DesignLevel level, const std::vector<std::string>& overrides = {});

/// Advice about the runs of some snows.
struct DesignAdvice {
  std::string rule;                ///< its name
  std::string text;                ///< one sentence; keys of a case file are replaced by those of the site file where it has them
  std::vector<std::string> snows;  ///< names of the snows that it is about
};

/// Advice about the finest run of each snow, equal advice once. The coarser grids only serve to estimate the grid error.
[[nodiscard]] std::vector<DesignAdvice> design_advice(const DesignPlan& plan);

/// Content of design_plan.json: site, snows, grids, runs with the case hash and the end that their results must have, and the advice about
/// them, for the page.
[[nodiscard]] std::string design_plan_json(const DesignPlan& plan);

}  // namespace mpm
