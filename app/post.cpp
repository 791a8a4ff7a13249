/// `mpm post`: measures a run again from its frames, and draws its pictures.

#include "libmpm/driver/replay.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <optional>

#include "commands.hpp"

namespace mpm::app {

namespace {

constexpr const char* python = "/usr/bin/python3";  // Debian's, where its pandas, h5py and matplotlib are

struct PostArguments {
  std::filesystem::path directory;
  std::filesystem::path out;
  bool no_pictures = false;
};

/// plot_run.py of the installation this program belongs to, or of the sources it was built from.
std::optional<std::filesystem::path> plot_script() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  for (const std::filesystem::path& candidate :
       {program.parent_path().parent_path() / "share/mpm/scripts/plot_run.py", std::filesystem::path(MPM_SCRIPT_DIR) / "plot_run.py"}) {
    if (std::filesystem::exists(candidate, error)) return candidate;
  }
  return std::nullopt;
}

/// Runs the script, whose messages go to this program's stdout and stderr. @return its exit status, 127 if it could not be started
int draw(const std::filesystem::path& script, const std::filesystem::path& directory, const std::filesystem::path& out) {
  const pid_t child = fork();
  if (child < 0) return 127;
  if (child == 0) {
    execl(python, python, script.c_str(), directory.c_str(), "--out", out.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return 127;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/// The numbers count: pictures that cannot be drawn are a message, not a failure.
void draw_pictures(const std::filesystem::path& directory, const std::filesystem::path& out) {
  const auto script = plot_script();
  if (!script) {
    fmt::print(stderr, "no pictures: plot_run.py was found neither in share/mpm/scripts beside this program nor in {}\n", MPM_SCRIPT_DIR);
    return;
  }
  if (const int status = draw(*script, directory, out); status != 0) {
    fmt::print(stderr,
               "no or not all pictures: {} {} ended with {}; Debian's python3-pandas, python3-matplotlib, python3-h5py and python3-jinja2 "
               "are needed\n",
               python, script->string(), status);
  }
}

void post(PostArguments arguments) {
  if (arguments.out.empty()) arguments.out = arguments.directory / "post";
  const PostResult result = post_process(arguments.directory, arguments.out);
  fmt::print("{}", result.results_json);
  fmt::print(stderr, "measured {} frames\n", result.frames);
  for (const auto& file : result.written) fmt::print(stderr, "wrote {}\n", file.string());
  std::fflush(stdout);
  if (!arguments.no_pictures) draw_pictures(arguments.directory, arguments.out);
}

}  // namespace

void add_post(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "post",
      "Measure a run again from its stored frames, and draw its pictures.\n"
      "Writes results.json, series.csv, profile.csv, profiles.h5 and the pictures to DIR/post. Those of the four files that DIR itself "
      "lacks, because the run was killed, are written there, too; the run's own files are never overwritten. Frames are fewer than the "
      "rows of the run's series.csv, so means and peaks differ within their errors. Forces and moments are sums over steps that no frame "
      "holds: they are averaged from the run's series.csv. Momentum and energies are taken from it at the times of the frames.");
  const auto arguments = std::make_shared<PostArguments>();
  command->add_option("dir", arguments->directory, "Result folder of `mpm run`")->required()->type_name("DIR");
  command->add_option("--out", arguments->out, "Folder to write to (default: DIR/post)")->type_name("DIR");
  command->add_flag("--no-pictures", arguments->no_pictures, "Only the numbers");
  command->callback([arguments] { post(*arguments); });
}

}  // namespace mpm::app
