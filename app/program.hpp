#pragma once
/// The program `mpm` as one function. A package puts it into a shared library, one for each level of x86-64, and the dynamic linker takes
/// the best one that the processor runs (cmake/Package.cmake).

namespace mpm::app {

/// Does what the command line says. Results go to stdout, messages to stderr; no exception leaves it. @return the exit code
[[gnu::visibility("default")]] int run_program(int argc, char** argv);

}  // namespace mpm::app
