/// `mpm post`: measures a run again from its frames, and draws its pictures.

#include "libmpm/driver/replay.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "python_script.hpp"

namespace mpm::app {

namespace {

struct PostArguments {
  std::filesystem::path directory;
  std::filesystem::path out;
  bool no_pictures = false;
};

/// Draws the pictures. If that fails, a message reports it, and the command still succeeds.
void draw_pictures(const std::filesystem::path& directory, const std::filesystem::path& out) {
  const auto script = find_script("plot_run.py");
  if (!script) {
    fmt::print(stderr, "no pictures: plot_run.py was found neither in share/mpm/scripts beside this program nor in {}\n", MPM_SCRIPT_DIR);
    return;
  }
  if (const int status = run_script(*script, {directory.string(), "--out", out.string()}); status != 0) {
    fmt::print(stderr, "no or not all pictures: {} {} ended with {}; Debian's {} are needed\n", python, script->string(), status,
               python_packages);
  }
}

void post(PostArguments arguments) {
  if (arguments.out.empty()) arguments.out = arguments.directory / "post";
  const PostResult result = post_process(arguments.directory, arguments.out);
  fmt::print("{}", result.results.to_json());
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
      "Writes results.json, series.csv, profile.csv, profiles.h5 and the pictures to DIR/post, also for a run that was killed; nothing is "
      "written to DIR itself, where a results.json means that the run finished. Frames are fewer than the "
      "rows of the run's series.csv, so means and peaks differ within their errors. Forces and moments are sums over steps that no frame "
      "holds: they are averaged from the run's series.csv. Momentum and energies are taken from it at the times of the frames.");
  const auto arguments = std::make_shared<PostArguments>();
  command->add_option("dir", arguments->directory, "Result folder of `mpm run`")->required()->type_name("DIR");
  command->add_option("--out", arguments->out, "Folder to write to (default: DIR/post)")->type_name("DIR");
  command->add_flag("--no-pictures", arguments->no_pictures, "Only the numbers");
  command->callback([arguments] { post(*arguments); });
}

}  // namespace mpm::app
