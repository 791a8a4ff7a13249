/// mpm-validate: theory against simulation, case by case.

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <omp.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdlib>
#include <iostream>

#include "mpm/error.hpp"
#include "mpm/io/atomic_file.hpp"
#include "validation/harness/report.hpp"

namespace {

using namespace mpm;
using namespace mpm::validation;

struct Options {
  Level level = Level::quick;
  std::vector<std::string> cases;
  std::filesystem::path out = "out/validation";
  std::filesystem::path junit;
  int threads = 0;
};

std::vector<CaseEntry> selected(const Options& options) {
  if (options.cases.empty()) return registered_cases();
  std::vector<CaseEntry> chosen;
  for (const std::string& name : options.cases) {
    bool found = false;
    for (const CaseEntry& entry : registered_cases())
      if (entry.name == name) {
        chosen.push_back(entry);
        found = true;
      }
    if (!found) throw ConfigError(fmt::format("no case '{}'; `mpm-validate list` names them", name));
  }
  return chosen;
}

int list_cases() {
  for (const CaseEntry& entry : registered_cases()) fmt::print("{:<24} {}\n", entry.name, entry.title);
  return 0;
}

/// Runs the script that draws; its failure leaves the numbers standing.
void draw_report(const std::filesystem::path& out) {
  const std::filesystem::path python = "/usr/bin/python3";  // Debian's, where the packages are
  const std::string script = MPM_REPORT_SCRIPT, directory = out.string();
  const pid_t child = fork();
  if (child == 0) {
    execl(python.c_str(), python.c_str(), script.c_str(), directory.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = -1;
  if (child < 0 || waitpid(child, &status, 0) < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    fmt::print(stderr, "mpm-validate: no HTML report (it needs python3 with jinja2 and matplotlib); the numbers are in {}\n",
               (out / "results.json").string());
  else
    fmt::print(stderr, "report: {}\n", (out / "index.html").string());
}

int run_cases(const Options& options, const std::string& command) {
  const std::vector<CaseEntry> entries = selected(options);
  if (options.threads > 0) omp_set_num_threads(options.threads);
  RunInfo info;
  info.level = options.level;
  info.command = command;
  info.machine = describe_machine();
  info.threads = omp_get_max_threads();
  info.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
  const auto start = std::chrono::steady_clock::now();
  std::vector<CaseResult> results;
  for (const CaseEntry& entry : entries) {
    fmt::print(stderr, "{}: {}\n", entry.name, entry.title);
    const auto directory = options.out / "cases" / entry.name;
    make_directory(directory);
    const CaseContext context(options.level, info.threads, directory, entry.directory,
                              [](const std::string& line) { fmt::print(stderr, "  {}\n", line); });
    results.push_back(run_case_entry(entry, context));
    fmt::print(stderr, "  {} in {:.1f} s\n", results.back().passed() ? "ok" : "FAILED", results.back().wall_time_s);
  }
  info.wall_time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  write_results(options.out, results, info);
  if (!options.junit.empty()) write_file(options.junit, junit_xml(results, info));
  draw_report(options.out);
  fmt::print("{}", summary_table(results));
  const bool passed = !results.empty() && std::all_of(results.begin(), results.end(), [](const CaseResult& r) { return r.passed(); });
  return static_cast<int>(passed ? ExitCode::ok : ExitCode::failed);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Checks libmpm against exact solutions, independent integrators and published results.", "mpm-validate");
  app.require_subcommand(1);
  CLI::App* list = app.add_subcommand("list", "names the cases");
  CLI::App* run = app.add_subcommand("run", "runs the cases; exit code 0 only if every check holds, 1 otherwise");
  const std::map<std::string, Level> levels{{"quick", Level::quick}, {"standard", Level::standard}, {"full", Level::full}};
  run->add_option("--level", options.level, "quick (5 minutes on 2 cores), standard (30 minutes) or full (hours)")
      ->transform(CLI::CheckedTransformer(levels))
      ->default_str("quick");
  run->add_option("--case", options.cases, "only this case; may be given again");
  run->add_option("--out", options.out, "directory of the report")->capture_default_str();
  run->add_option("--junit", options.junit, "a further copy of the JUnit XML");
  run->add_option("--threads", options.threads, "OpenMP threads; default: all")->check(CLI::PositiveNumber);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);
    return code == 0 ? 0 : static_cast<int>(ExitCode::usage);
  }
  std::string command = "mpm-validate";
  for (int i = 1; i < argc; ++i) command += fmt::format(" {}", argv[i]);
  try {
    return list->parsed() ? list_cases() : run_cases(options, command);
  } catch (const Error& e) {
    fmt::print(stderr, "mpm-validate: {}\n", e.what());
    return static_cast<int>(e.code());
  } catch (const std::exception& e) {
    fmt::print(stderr, "mpm-validate: internal: {}\n", e.what());
    return static_cast<int>(ExitCode::internal);
  }
}
