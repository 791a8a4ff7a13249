#pragma once
/// RESULTS.csv and --filter, shared by the subcommands that evaluate a table of runs.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "mpm/error.hpp"
#include "mpm/impact/study.hpp"

namespace mpm::app {

struct StudyArguments {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> filters;
};

inline void add_study_arguments(CLI::App& command, StudyArguments& arguments) {
  command.add_option("results", arguments.files, "Result tables of campaigns, one row a run")->required()->type_name("RESULTS.csv");
  command.add_option("--filter", arguments.filters, "Keep rows where this holds: cell_size_m=0.25, hardening_xi=0.5,5, froude_number<=3")
      ->type_name("'COLUMN OP VALUE'")
      ->type_size(1)
      ->allow_extra_args(false);
}

/// @throws ConfigError where no row is left
inline StudyTable read_study(const StudyArguments& arguments) {
  std::vector<RowFilter> filters;
  for (const std::string& text : arguments.filters) filters.emplace_back(text);
  StudyTable table = read_study_table(arguments.files, filters);
  if (table.runs.empty()) {
    std::string reasons;
    for (const auto& [reason, rows] : table.left_out) reasons += (reasons.empty() ? "" : "; ") + std::to_string(rows) + " " + reason;
    throw ConfigError("no run with a steady run-up is left of " + std::to_string(table.rows) + " rows" +
                      (reasons.empty() ? "" : " (" + reasons + ")"));
  }
  return table;
}

/// Both equations, each on both sets of the paper.
inline std::vector<SetFit> fit_paper_sets(const StudyTable& table) {
  std::vector<SetFit> fits;
  for (const FittingSet& set : paper_fitting_sets()) {
    for (const HeightEquation equation : {HeightEquation::runup, HeightEquation::pressure_height}) {
      fits.push_back(fit_set(equation, set, table.runs));
    }
  }
  return fits;
}

}  // namespace mpm::app
