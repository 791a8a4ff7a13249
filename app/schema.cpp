/// `mpm schema`: the generated reference of case files and of results.

#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "libmpm/campaign/site.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/observers.hpp"

namespace mpm::app {

void add_schema(CLI::App& app) {
  struct Arguments {
    bool json = false, results = false, site = false;
  };
  CLI::App* command = app.add_subcommand("schema",
                                         "Print the reference of case files: every key with unit, range, default and meaning; or, with "
                                         "--results, of what a run measures");
  const auto arguments = std::make_shared<Arguments>();
  command->add_flag("--json", arguments->json, "As JSON");
  CLI::Option* results = command->add_flag(
      "--results", arguments->results, "Columns of series.csv and profile.csv and keys of results.json, as tables in Markdown or as JSON");
  command->add_flag("--site", arguments->site, "Keys of the site files of `mpm design`")->excludes(results);
  command->callback([arguments] {
    const bool json = arguments->json;
    if (arguments->results) {
      fmt::print("{}", json ? observers_json() : observers_markdown());
      return;
    }
    const config::Reference reference = arguments->site ? site_reference() : case_reference();
    fmt::print("{}", json ? config::reference_json(reference) : config::reference_text(reference));
  });
}

}  // namespace mpm::app
