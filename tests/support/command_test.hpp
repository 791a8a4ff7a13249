#pragma once
/// The base of tests of `mpm` on the command line.

#include <gtest/gtest.h>

#include <string>

#include "support/command.hpp"
#include "support/temporary_directory.hpp"

namespace mpm::testing {

/// Each test has a directory of its own, in which its commands run.
class CommandTest : public ::testing::Test {
 protected:
  [[nodiscard]] Outcome shell(const std::string& command) const { return run_command(command, directory_.path(), directory_.path()); }
  [[nodiscard]] Outcome mpm(const std::string& arguments) const { return shell("'" MPM_APP "' " + arguments); }

  TemporaryDirectory directory_;
};

}  // namespace mpm::testing
