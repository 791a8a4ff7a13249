#pragma once
/// The program `mpm` as one function. A package puts it into a shared library, one for each level of x86-64, and the dynamic linker chooses
/// the best one that the processor supports (cmake/Package.cmake).

namespace mpm::app {

/// Executes a command line. Results go to stdout, messages to stderr; it throws nothing. @return the exit code
[[gnu::visibility("default")]] int run_program(int argc, char** argv);

}  // namespace mpm::app
