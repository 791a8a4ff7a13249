/// `mpm`.

#include "program.hpp"

int main(int argc, char** argv) { return mpm::app::run_program(argc, argv); }
