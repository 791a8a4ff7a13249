/// `mpm`: calls the subcommands, and converts errors to messages and exit codes.

#include "program.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "commands.hpp"
#include "libmpm/base/error.hpp"
#include "libmpm/base/process.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/threads.hpp"
#include "ranks.hpp"
#include "run_control.hpp"

namespace {

std::string version_text() {
  const mpm::BuildInfo build = mpm::build_info();
  return fmt::format("mpm {} (commit {})\ncompiler: {}, {}\nSIMD: {}, {} bit\nthreads: {}", build.version, build.commit, build.compiler,
                     build.build_type, build.instruction_set, build.simd_width_bits, omp_get_max_threads());
}

int fail(mpm::ExitCode code, const std::string& message) {
  std::fputs((message + "\n").c_str(), stderr);  // if this fails, too, only the exit code remains
  return static_cast<int>(code);
}

/// The message for an unknown command; empty if there is none.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  const CLI::App* level = &app;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    const auto commands = level->get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
    if (commands.empty()) return {};  // the words that follow are arguments
    std::vector<std::string> names;
    for (const CLI::App* command : commands) names.push_back(command->get_name());
    const auto found = std::ranges::find(names, argv[i]);
    if (found == names.end()) {
      const std::string meant = mpm::nearest_word(argv[i], names);
      return fmt::format("{} has no command '{}'; {}", level->get_name(), argv[i],
                         meant.empty() ? fmt::format("there are {}", fmt::join(names, ", ")) : fmt::format("did you mean {}?", meant));
    }
    level = commands[static_cast<std::size_t>(found - names.begin())];
  }
  return {};
}

int parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return static_cast<int>(mpm::ExitCode::ok);
  } catch (const CLI::RuntimeError& result) {
    return result.get_exit_code();
  } catch (const CLI::ParseError& error) {  // also --help and --version, with code 0
    if (const std::string message = unknown_command(app, argc, argv); error.get_exit_code() != 0 && !message.empty())
      return fail(mpm::ExitCode::usage, message);
    return app.exit(error) == 0 ? static_cast<int>(mpm::ExitCode::ok) : static_cast<int>(mpm::ExitCode::usage);
  } catch (const mpm::Error& error) {
    return fail(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(mpm::ExitCode::internal, "out of memory; take a larger numerics.cell_size_m or less snow (`mpm check` estimates the need)");
  } catch (const std::system_error& error) {  // of streams and of the file system
    return fail(mpm::ExitCode::io, error.what());
  } catch (const std::exception& error) {
    return fail(mpm::ExitCode::internal, fmt::format("internal error: {}", error.what()));
  }
}

/// Commands other than `run` use one rank.
void require_one_rank(const std::string& command) {
  if (mpm::app::session().size() == 1 || command == "run" || command.starts_with("-")) return;
  const char* const remedy = command == "campaign" || command == "converge" ? "; it starts the ranks of each run itself, with --ranks" : "";
  throw mpm::ConfigError(fmt::format("mpm {}: not available with more than one rank; start it without mpirun{}", command, remedy));
}

int run_command(int argc, char** argv) {
  using namespace mpm::app;
  CLI::App app{"Snow avalanches on obstacles by the Material Point Method", "mpm"};
  app.set_version_flag("--version", version_text);
  app.require_subcommand(1);
  add_check(app);
  add_run(app);
  add_point(app);
  add_schema(app);
  add_post(app);
  add_predict(app);
  add_converge(app);
  add_compare(app);
  add_campaign(app);
  add_design(app);
  const int code = parse(app, argc, argv);
  std::cout.flush();
  if (code == 0 && (std::fflush(stdout) != 0 || !std::cout)) {
    return fail(mpm::ExitCode::io, "the results could not be written to standard output");
  }
  return code;
}

}  // namespace

namespace mpm::app {

int run_program(int argc, char** argv) {
  open_closed_streams();
  use_short_spin(argv);
  if (const std::string warning = limit_threads(); !warning.empty()) say(warning + "\n");
  try {
    Session session(argc, argv);
    if (!session.first()) return session.serve();
    int code = 0;
    try {
      require_one_rank(argc > 1 ? argv[1] : "-");
      code = run_command(argc, argv);
    } catch (const Error& error) {
      code = fail(error.code(), error.what());
    }
    session.close(code);
    return code;
  } catch (const Error& error) {
    return fail(error.code(), error.what());
  }
}

}  // namespace mpm::app
