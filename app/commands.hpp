#pragma once
/// The subcommands of `mpm`, one a file. Each adds itself to the command line; its callback does the work, writes results to
/// stdout and messages to stderr, and reports failure by throwing: mpm::Error with the exit code in it, or CLI::RuntimeError(1)
/// after a comparison that was printed and failed. program.cpp turns these into messages and exit codes.

#include <CLI/CLI.hpp>

namespace mpm::app {

void add_check(CLI::App& app);
void add_run(CLI::App& app);
void add_point(CLI::App& app);
void add_schema(CLI::App& app);
void add_post(CLI::App& app);
void add_converge(CLI::App& app);
void add_compare(CLI::App& app);
void add_campaign(CLI::App& app);
void add_predict(CLI::App& app);
void add_design(CLI::App& app);

}  // namespace mpm::app
