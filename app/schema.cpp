/// `mpm schema`: the generated reference of case files.

#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "mpm/io/schema.hpp"

namespace mpm::app {

void add_schema(CLI::App& app) {
  CLI::App* command = app.add_subcommand("schema", "Print the reference of case files: every key with unit, range, default and meaning");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "As JSON");
  command->callback([json] { fmt::print("{}", *json ? schema_json() : schema_text()); });
}

}  // namespace mpm::app
