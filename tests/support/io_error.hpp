#pragma once

#include <string>

#include "libmpm/base/error.hpp"

namespace mpm::testing {

/// Message of the IoError that a call throws, empty if it throws none.
template <class Call>
std::string io_error_of(Call call) {
  try {
    call();
  } catch (const IoError& e) {
    return e.what();
  }
  return {};
}

}  // namespace mpm::testing
