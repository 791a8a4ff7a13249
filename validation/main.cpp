/// mpm-validate: theory against simulation, case by case.

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <functional>
#include <future>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>

#include "libmpm/base/error.hpp"
#include "libmpm/base/process.hpp"
#include "libmpm/driver/threads.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5.hpp"
#include "validation/harness/exchange.hpp"
#include "validation/harness/junit.hpp"
#include "validation/harness/orders.hpp"
#include "validation/harness/report.hpp"
#include "validation/harness/summary.hpp"
#include "validation/harness/tables.hpp"

namespace {

using namespace mpm;
using namespace mpm::validation;

struct Options {
  Level level = Level::quick;
  std::vector<std::string> cases;
  std::filesystem::path out = "out/validation";
  std::filesystem::path junit, record;
  std::filesystem::path results;  ///< of another solver, to be judged; empty: this program makes the runs
  int threads = 0;
  Precision precision = Precision::double_precision;
  bool solve = false;  ///< export: the results of this program, too
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

/// Name, labels and time of each case, the last two as recorded.
int list_cases() {
  const std::vector<RecordedCase> recorded = recorded_cases(MPM_RECORDED_ORDERS);
  for (const CaseEntry& entry : registered_cases()) {
    std::string labels, times;
    for (const RecordedCase& r : recorded) {
      if (r.name != entry.name) continue;
      labels = r.labels;
      times += fmt::format("{}{} {:.0f} s", times.empty() ? "" : ", ", r.level, r.wall_time_s);
    }
    const std::string known =
        fmt::format("{}{}", labels.empty() ? "" : fmt::format(" [{}; {}]", labels, times), can_be_exported(entry) ? " [export]" : "");
    fmt::print("{:<24} {}{}\n", entry.name, entry.title, known);
  }
  return 0;
}

/// Runs one of the scripts that draw. @returns false if it failed
bool run_script(const std::filesystem::path& script, const std::filesystem::path& first, const std::filesystem::path& second = {}) {
  const std::filesystem::path python = "/usr/bin/python3";  // Debian's, where the packages are
  const pid_t child = fork();
  if (child == 0) {
    execl(python.c_str(), python.c_str(), script.c_str(), first.c_str(), second.empty() ? nullptr : second.c_str(),
          static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = -1;
  return child >= 0 && waitpid(child, &status, 0) >= 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Runs the scripts that draw; the numbers do not depend on them.
void draw_report(const std::filesystem::path& out, const std::filesystem::path& record) {
  const std::filesystem::path script = MPM_REPORT_SCRIPT, history = out / "history.html";
  if (!record.empty() && run_script(script.parent_path() / "validation_history.py", record / "history.csv", history))
    fmt::print(stderr, "history: {}\n", history.string());
  if (!run_script(script, out))
    fmt::print(stderr, "mpm-validate: no HTML report (it needs python3 with jinja2 and matplotlib); the numbers are in {}\n",
               (out / "results.json").string());
  else
    fmt::print(stderr, "report: {}\n", (out / "index.html").string());
}

/// A case without a result yet; the report keeps it if the program stops before there is one.
CaseResult without_result(const CaseEntry& entry, std::string fault) {
  CaseResult result;
  result.name = entry.name;
  result.title = entry.title;
  result.fault = std::move(fault);
  return result;
}

/// Turns a word into the value that it names; any other word is an error that lists them.
template <class T>
CLI::Validator one_of(const std::map<std::string, T>& named) {
  std::vector<std::string> words;
  for (const auto& [word, value] : named) words.push_back(word);
  return {[named, words](std::string& text) {
            const auto found = named.find(text);
            if (found == named.end()) return fmt::format("'{}' is none of {}", text, fmt::join(words, ", "));
            text = std::to_string(static_cast<int>(found->second));
            return std::string();
          },
          fmt::format("{}", fmt::join(words, "|"))};
}

/// Calls `work` on `count` threads; the first exception is thrown after the last has ended.
void in_threads(int count, const std::function<void()>& work) {
  std::vector<std::future<void>> all;
  for (int i = 1; i < count; ++i) all.push_back(std::async(std::launch::async, work));
  work();
  for (std::future<void>& one : all) one.get();
}

/// How many cases run at a time. Those of level quick have grids so small that two threads are little faster than one, or slower: there
/// as many cases run as there are threads. From level standard on a case has all threads, and the memory, to itself.
int cases_at_a_time(std::size_t cases, const Options& options, int threads) {
  if (options.level != Level::quick || !hdf5::usable_by_threads()) return 1;
  return std::min(static_cast<int>(cases), threads);
}

/// Numbers of the cases, the longest first, so that no thread is idle at the end: as recorded at this level, or else at another. A case
/// without a recorded time may be long: it starts before those that have one.
std::vector<std::size_t> longest_first(const std::vector<CaseEntry>& entries, Level level) {
  std::map<std::string, double> time;
  const std::vector<RecordedCase> recorded = recorded_cases(MPM_RECORDED_ORDERS);
  for (const bool at_level : {false, true})
    for (const RecordedCase& r : recorded)
      if ((r.level == to_string(level)) == at_level) time[r.name] = r.wall_time_s;
  const auto time_of = [&](std::size_t i) {
    const auto known = time.find(entries[i].name);
    return known == time.end() ? std::numeric_limits<double>::infinity() : known->second;
  };
  std::vector<std::size_t> order(entries.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return time_of(a) > time_of(b); });
  return order;
}

/// Writes one case for other solvers.
int export_to(const CaseEntry& entry, const Options& options) {
  const CaseContext context(options.level, 1, options.out, entry.directory,
                            [](const std::string& line) { fmt::print(stderr, "  {}\n", line); });
  fmt::print(stderr, "{}: {}\n", entry.name, entry.title);
  export_case(entry, context, options.out);
  if (options.solve) {
    if (options.threads > 0) omp_set_num_threads(options.threads);
    export_results(entry, context, options.out);
  }
  fmt::print("{}\n", (options.out / "case.json").string());
  return static_cast<int>(ExitCode::ok);
}

/// Runs the cases. What is known is written before and after each, so that a crash loses nothing of the others.
int run_cases(const std::vector<CaseEntry>& entries, const Options& options, const std::string& command) {
  if (options.threads > 0) omp_set_num_threads(options.threads);
  RunInfo info;
  info.level = options.level;
  info.command = command;
  info.machine = describe_machine();
  info.threads = omp_get_max_threads();
  info.precision = options.precision;
  info.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
  const auto start = std::chrono::steady_clock::now();
  std::vector<CaseResult> results;
  for (const CaseEntry& entry : entries) results.push_back(without_result(entry, "not run: the program stopped before"));
  std::optional<ForeignResults> foreign;
  if (!options.results.empty()) {  // of one case
    const CaseContext context(options.level, info.threads, options.out, entries.at(0).directory, [](const std::string&) {});
    foreign.emplace(options.results, entries.at(0), context);
    info.solver = foreign->solver().name + (foreign->solver().version.empty() ? "" : " " + foreign->solver().version);
  }

  const int at_a_time = cases_at_a_time(entries.size(), options, info.threads);
  std::vector<std::size_t> order(entries.size());
  std::iota(order.begin(), order.end(), 0);
  if (at_a_time > 1) order = longest_first(entries, options.level);
  std::mutex mutex;  // of what follows, of `results` and of `info`
  std::size_t started = 0;
  const auto run_next_cases = [&] {
    omp_set_num_threads(info.threads / at_a_time);  // of this thread
    std::unique_lock lock(mutex);
    while (started < order.size()) {
      const std::size_t i = order[started++];
      const CaseEntry& entry = entries[i];
      fmt::print(stderr, "{}: {}\n", entry.name, entry.title);
      results[i].fault = "crashed: the program stopped while this case ran";
      write_results(options.out, results, info);
      const auto directory = options.out / "cases" / entry.name;
      make_directory(directory);
      const std::string label = at_a_time > 1 ? entry.name + ": " : "";
      const CaseContext context(
          options.level, info.threads / at_a_time, directory, entry.directory,
          [&](const std::string& line) { fmt::print(stderr, "  {}{}\n", label, line); }, foreign ? &*foreign : nullptr, options.precision);
      lock.unlock();
      CaseResult result = run_case_entry(entry, context);
      if (foreign && foreign->not_finite() > 0 && result.fault.empty())
        result.fault = fmt::format("{} numbers of the results are not finite", foreign->not_finite());
      lock.lock();
      results[i] = std::move(result);
      fmt::print(stderr, "  {}{} in {:.1f} s\n", label, results[i].passed() ? "ok" : "FAILED", results[i].wall_time_s);
      info.wall_time_s = seconds_since(start);
    }
  };
  in_threads(at_a_time, run_next_cases);

  if (foreign && !foreign->damage().empty()) throw IoError("the results cannot be judged: " + foreign->damage());
  write_results(options.out, results, info);
  if (!options.junit.empty()) write_file(options.junit, junit_xml(results, info));
  if (!options.record.empty()) record_results(options.record, results, info);
  const std::string summary = summary_table(summary_rows(summary_points(results)));
  fmt::print("{}\n{}{}{}", check_table(results), summary, summary.empty() ? "" : "\n", case_table(results, info));
  const bool passed = !results.empty() && std::all_of(results.begin(), results.end(), [](const CaseResult& r) { return r.passed(); });
  return static_cast<int>(passed ? ExitCode::ok : ExitCode::failed);
}

/// Calls `work` in a process of its own: a crash there does not end this process. Empty if it was stopped by a signal.
std::optional<int> in_own_process(const std::function<int()>& work) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // without its parent the answer has no reader
    const int code = work();
    std::fflush(nullptr);
    _exit(code);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0) throw std::runtime_error("cannot start a process for the cases");
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  fmt::print(stderr, "mpm-validate: stopped by signal {} ({})\n", WTERMSIG(status), strsignal(WTERMSIG(status)));
  return std::nullopt;
}

/// Turns what `work` throws into a message and an exit code.
int guarded(const std::function<int()>& work) {
  try {
    return work();
  } catch (const Error& e) {
    fmt::print(stderr, "mpm-validate: {}\n", e.what());
    return static_cast<int>(e.code());
  } catch (const std::exception& e) {
    fmt::print(stderr, "mpm-validate: internal: {}\n", e.what());
    return static_cast<int>(ExitCode::internal);
  }
}

}  // namespace

int main(int argc, char** argv) {
  mpm::open_closed_streams();
  mpm::use_short_spin(argv);
  if (const std::string warning = mpm::limit_threads(); !warning.empty()) fmt::print(stderr, "{}\n", warning);
  Options options;
  CLI::App app("Checks libmpm against exact solutions, independent integrators and published results.", "mpm-validate");
  app.require_subcommand(1);
  CLI::App* list = app.add_subcommand("list", "names the cases");
  CLI::App* run = app.add_subcommand("run", "runs the cases; exit code 0 only if every check holds, 1 otherwise");
  const std::map<std::string, Level> levels{{"quick", Level::quick}, {"standard", Level::standard}, {"full", Level::full}};
  run->add_option("--level", options.level, "quick (2:30 minutes on 2 cores), standard (30 minutes) or full (hours)")
      ->transform(one_of(levels))
      ->default_str("quick");
  run->add_option("--case", options.cases, "only this case; may be given again");
  run->add_option("--out", options.out, "directory of the report")->capture_default_str();
  run->add_option("--junit", options.junit, "a further copy of the JUnit XML");
  run->add_option("--record", options.record, "keep the table of orders and errors in this directory: reference_data/validation_orders");
  const std::map<std::string, Precision> precisions{{"double", Precision::double_precision}, {"single", Precision::single_precision}};
  run->add_option("--precision", options.precision,
                  "double, or single: that of the particles (docs/precision.md); one in the report's results.json")
      ->transform(one_of(precisions))
      ->default_str("double");
  run->add_option("--threads", options.threads, "OpenMP threads; default: all")->check(CLI::Range(1, most_threads()));
  std::string name;
  CLI::App* write = app.add_subcommand("export", "writes a case as plain data for another solver: docs/other-solvers.md");
  CLI::App* grade = app.add_subcommand(
      "grade", "judges what another solver made of an exported case; exit code 1 if a check fails, 4 if files are missing");
  for (CLI::App* command : {write, grade}) {
    command->add_option("CASE", name, "name of the case; `mpm-validate list` marks those that can be exported")->required();
    command->add_option("--level", options.level, "level of the case, the same for both commands")
        ->transform(one_of(levels))
        ->default_str("quick");
  }
  write->add_option("--out", options.out, "directory of the exported case")->required();
  write->add_option("--threads", options.threads, "OpenMP threads of --solve; default: all")->check(CLI::Range(1, most_threads()));
  write->add_flag("--solve", options.solve, "also make the runs, and write the results as another solver would");
  grade->add_option("--results", options.results, "directory of the solver's results")->required();
  grade->add_option("--out", options.out, "directory of the report")->default_str("out/grade");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);
    return code == 0 ? 0 : static_cast<int>(ExitCode::usage);
  }
  std::string command = "mpm-validate";
  for (int i = 1; i < argc; ++i) command += fmt::format(" {}", argv[i]);
  return guarded([&] {
    if (list->parsed()) return list_cases();
    if (!name.empty()) options.cases = {name};
    const std::vector<CaseEntry> entries = selected(options);
    if (write->parsed()) return export_to(entries.at(0), options);
    if (grade->parsed() && grade->count("--out") == 0) options.out = "out/grade";
    const std::optional<int> code = in_own_process([&] { return guarded([&] { return run_cases(entries, options, command); }); });
    if (!code || *code <= static_cast<int>(ExitCode::failed)) draw_report(options.out, options.record);
    return code.value_or(static_cast<int>(ExitCode::internal));
  });
}
