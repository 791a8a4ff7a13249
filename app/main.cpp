/// `mpm`: dispatch, and the one place where errors become messages and exit codes.

#include <fmt/format.h>
#include <omp.h>

#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <system_error>

#include "commands.hpp"
#include "mpm/build_info.hpp"
#include "mpm/error.hpp"

namespace {

std::string version_text() {
  const mpm::BuildInfo build = mpm::build_info();
  return fmt::format("mpm {} (commit {})\ncompiler: {}, {}\nSIMD: {}, {} bit\nthreads: {}", build.version, build.commit, build.compiler,
                     build.build_type, build.instruction_set, build.simd_width_bits, omp_get_max_threads());
}

int fail(mpm::ExitCode code, const std::string& message) {
  std::fputs((message + "\n").c_str(), stderr);  // where stderr cannot be written either, the exit code still tells
  return static_cast<int>(code);
}

int parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return static_cast<int>(mpm::ExitCode::ok);
  } catch (const CLI::RuntimeError& result) {
    return result.get_exit_code();
  } catch (const CLI::ParseError& error) {  // --help and --version come this way, too, with code 0
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

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Snow avalanches on obstacles by the Material Point Method", "mpm"};
  app.set_version_flag("--version", version_text);
  app.require_subcommand(1);
  mpm::app::add_check(app);
  mpm::app::add_run(app);
  mpm::app::add_point(app);
  mpm::app::add_schema(app);
  mpm::app::add_post(app);
  mpm::app::add_predict(app);
  mpm::app::add_fit(app);
  mpm::app::add_study(app);
  mpm::app::add_converge(app);
  mpm::app::add_compare(app);
  mpm::app::add_campaign(app);
  const int code = parse(app, argc, argv);
  std::cout.flush();
  if (code == 0 && (std::fflush(stdout) != 0 || !std::cout)) {
    return fail(mpm::ExitCode::io, "the results could not be written to standard output");
  }
  return code;
}
