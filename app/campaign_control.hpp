#pragma once
/// Common part of `mpm campaign run`, `mpm design` and `mpm converge`: execution of a campaign here or through Slurm, with messages.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "libmpm/campaign/campaign.hpp"

namespace mpm::app {

/// The command line of a campaign.
struct CampaignArguments {
  std::filesystem::path plan;   ///< plan file, or the site file of a design
  std::filesystem::path out;    ///< folder; empty: out/<name of the plan>
  int jobs = 0;                 ///< runs at a time; 0: cores over threads of a run
  int ranks = 0;                ///< of each run; 0: as in the plan
  std::string executor;         ///< "slurm", or this machine
  bool retry_failed = false;    ///< repeat also failures that will recur
  bool list = false;            ///< status: every run
  bool json = false;            ///< plan, status: for programs
  std::string name;             ///< task: of one run
  bool progress = false;        ///< a line of progress and time left, for a campaign of few runs
  std::FILE* summary = stdout;  ///< where the summary at the end goes
};

/// Adds --jobs to a command. @param text  its description
void add_jobs_argument(CLI::App& command, CampaignArguments& a, const std::string& text);
/// Adds --executor and --retry-failed to a command that executes a campaign.
void add_execution_arguments(CLI::App& command, CampaignArguments& a);

/// The folder of the campaign.
[[nodiscard]] std::filesystem::path folder_of(const CampaignArguments& a);

/// Executes the incomplete runs, writes the tables and prints the summary. If a signal stops it, it ends the process by that signal; the
/// same command continues later. @throws CLI::RuntimeError(1) if runs failed
void run_campaign(const Campaign& campaign, const CampaignArguments& a);

}  // namespace mpm::app
