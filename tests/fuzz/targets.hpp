#pragma once
/// What is fuzzed: each target takes arbitrary bytes and throws where the library does something with them that it must not do.
/// fuzzer.cpp leads libFuzzer to a target; tests/fuzz/test_fuzz_corpus.cpp replays the stored inputs with every compiler.

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace mpm::fuzz {

/// The library broke a promise about an input. Other exceptions than the library's own three are findings as well.
struct Problem : std::logic_error {
  using std::logic_error::logic_error;
};

inline void require(bool holds, const std::string& promise) {
  if (!holds) throw Problem(promise);
}

using Bytes = std::span<const std::uint8_t>;

/// A case file; lines `#set KEY=VALUE` in front are given as --set. Refused with places and remedies, or read: then it is written and read
/// back to the same case and the same hash, its estimate is made of numbers, and a small one becomes a state as large as estimated.
void case_file(Bytes input);

/// A point path, followed if it is short: rows of finite numbers, or refused.
void point_path(Bytes input);

/// A plan of a campaign: refused, or read, written and read back to the same runs.
void campaign_plan(Bytes input);

/// A CSV table: every way of reading it ends in a table that is written and read back to the same, or in an IoError.
void csv_table(Bytes input);

/// A list of alterations to a small valid checkpoint, frame or final state, which is then sealed again (recipe: state_file.cpp): content
/// that no run can have written is refused with an IoError, anything else can be measured and computed on.
void state_file(Bytes recipe);

struct Target {
  const char* name;  ///< of its corpus folder
  void (*run)(Bytes);
};
inline constexpr Target targets[] = {{"case_file", case_file},
                                     {"point_path", point_path},
                                     {"campaign_plan", campaign_plan},
                                     {"csv_table", csv_table},
                                     {"state_file", state_file}};

}  // namespace mpm::fuzz
