/// `mpm point`: one material point along a path, as CSV.

#include <fmt/format.h>

#include <array>
#include <memory>

#include "arguments.hpp"
#include "commands.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/point_path.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm::app {

namespace {

void point(const CaseArguments& arguments) {
  const std::vector<PathRow> rows = follow_path(read_path(arguments.file, arguments.overrides));
  fmt::print("{}\n", fmt::join(path_columns, ","));
  for (const PathRow& r : rows) {
    fmt::print("{}", csv_line(std::array{static_cast<double>(r.step), r.eps_v, r.eps_q, r.p, r.q, r.eps_v_plastic,
                                         r.preconsolidation_pressure, r.yield}));
  }
}

}  // namespace

void add_point(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("point", "Compute one material point along a path of strain or stress; CSV to stdout (Kirchhoff stresses)");
  const auto arguments = std::make_shared<CaseArguments>();
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { point(*arguments); });
}

}  // namespace mpm::app
