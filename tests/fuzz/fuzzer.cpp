/// libFuzzer's entry: FUZZ_TARGET is the name of a target. An exception that leaves it ends the fuzzer and keeps the input.

#include <omp.h>

#include "targets.hpp"

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  omp_set_num_threads(1);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  mpm::fuzz::FUZZ_TARGET({data, size});
  return 0;
}
