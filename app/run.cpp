/// `mpm run`: computes a case into a directory.

#include "libmpm/driver/run.hpp"

#include <fmt/format.h>

#include <limits>
#include <memory>

#include "arguments.hpp"
#include "commands.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/estimate.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "ranks.hpp"
#include "run_control.hpp"

namespace mpm::app {

namespace {

struct RunArguments {
  CaseArguments input;
  std::filesystem::path out;
  int threads = 0;
  bool resume = false, force = false;
  bool any_size = false;
};

void run(const RunArguments& arguments) {
  const Case spec = read_case(arguments.input.file, arguments.input.overrides);
  require_feasible(estimate(spec), arguments.any_size ? std::numeric_limits<double>::infinity() : physical_memory_bytes());

  listen_to_signals();  // before anything is printed, because stdout may be closed
  print_advice(spec);
  RunOptions options;
  options.out = arguments.out.empty() ? std::filesystem::path("out") / arguments.input.file.stem() : arguments.out;
  if (!arguments.resume && !arguments.force) require_no_results(options.out);
  if (arguments.resume) require_folder(options.out);
  if (!arguments.force) {  // run.log is the first file of a run, attempts.json that of a campaign
    require_no_other_files(options.out, {"case.toml", "obstacle.json", "series.csv", "profile.csv", "frames.xdmf"},
                           {"run.log", "attempts.json"});
  }
  options.threads = arguments.threads;
  options.resume = arguments.resume;
  const auto progress = std::make_shared<ProgressLine>();
  options.on_progress = [progress](const Progress& p) { (*progress)(p); };
  options.poll = pending_request;
  const RunResult result = session().run(spec, options);
  progress->finish();
  if (!result.finished) {  // the run has reported where it stopped
    session().close(0);
    end_by_signal();
  }
  say(summary_text(result.results));
  say(fmt::format("results in {}\n", options.out.string()));
  fmt::print("{}\n", result.results.to_json());
}

}  // namespace

void add_run(CLI::App& app) {
  CLI::App* command = app.add_subcommand("run", "Compute a case; writes the results to a directory and prints results.json");
  const auto arguments = std::make_shared<RunArguments>();
  add_case_arguments(*command, arguments->input);
  command->add_option("--out", arguments->out, "Directory of the results (default: out/<name of the case file>)")->type_name("DIR");
  add_threads_argument(*command, arguments->threads);
  CLI::Option* resume =
      command->add_flag("--resume", arguments->resume, "Continue from the last checkpoint, or extend a finished run to a longer duration");
  command->add_flag("--force", arguments->force, "Overwrite the results or the checkpoint of an earlier run")->excludes(resume);
  command->add_flag("--any-size", arguments->any_size, "Start even if the case is estimated to need more memory than this machine has");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace mpm::app
