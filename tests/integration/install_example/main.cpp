#include <iostream>

#include "mpm/build_info.hpp"

int main() {
  std::cout << "libmpm " << mpm::build_info().version << ", " << mpm::build_info().instruction_set << '\n';
  return 0;
}
