#pragma once
/// Case files and result folders of tests with real ranks.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "support/command.hpp"

namespace mpm::testing {

/// A file of the case writes frames, and its bodies start within the domain (ranks as threads test particles that leave it).
inline Case with_frames(Case c) {
  c.output.frames_per_second = 50.0;
  for (const BodySpec& body : c.bodies) c.domain.max = c.domain.max.cwiseMax(body.max);
  return c;
}

inline void write_rank_case(const std::filesystem::path& file, Case c) {
  if (c.conveyor)
    c.conveyor->upstream_length = std::max(c.conveyor->upstream_length, 4.0 * c.numerics.cell_size);  // required in a case file
  write_file(file, write_case(c));
}

/// The files of a result folder, relative to it, that must have the same bytes for any number of ranks.
inline std::set<std::string> files_of_any_rank(const std::filesystem::path& out) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out)) {
    const std::string name = std::filesystem::relative(entry.path(), out).string();
    const bool tells_of_execution =
        name == "results.json" || name == "run.log" || name == "ranks.json" || name == ".lock" || name.starts_with("checkpoint");
    if (entry.is_regular_file() && !tells_of_execution) names.insert(name);
  }
  return names;
}

inline void expect_same_files(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto names = files_of_any_rank(a);
  EXPECT_TRUE(names.contains("final.h5") && names.contains("series.csv"));
  EXPECT_EQ(names, files_of_any_rank(b));
  for (const std::string& name : names) EXPECT_TRUE(content(a / name) == content(b / name)) << (b / name);
}

}  // namespace mpm::testing
