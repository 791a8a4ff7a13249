/// Replays what the fuzzers found and what they start from (tests/fuzz/corpus), with this compiler and without libFuzzer.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "fuzz/targets.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm::fuzz {
namespace {

const std::filesystem::path corpus = std::filesystem::path(MPM_SOURCE_DIR) / "tests/fuzz/corpus";

std::vector<std::filesystem::path> inputs(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

void expect_no_finding(const Target& target, const std::string& input, const std::string& name) {
  try {
    target.run({reinterpret_cast<const std::uint8_t*>(input.data()), input.size()});
  } catch (const std::exception& finding) {
    ADD_FAILURE() << target.name << ", " << name << ": " << finding.what();
  }
}

class Corpus : public testing::TestWithParam<Target> {};

TEST_P(Corpus, BringsNoFinding) {
  const auto files = inputs(corpus / GetParam().name);
  EXPECT_GE(files.size(), 2u);
  for (const auto& file : files) expect_no_finding(GetParam(), read_file(file), file.filename().string());
}

TEST_P(Corpus, CutOffAnywhereBringsNoFinding) {
  const auto file = corpus / GetParam().name / "seed";
  const std::string whole = read_file(file);
  const std::size_t stride = 1 + whole.size() / 100;
  for (std::size_t size = 0; size < whole.size(); size += stride) {
    expect_no_finding(GetParam(), whole.substr(0, size), "the first " + std::to_string(size) + " bytes of the seed");
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, testing::ValuesIn(targets), [](const auto& target) { return std::string(target.param.name); });

/// Every alteration of every array and attribute of the three files, one at a time: what the fuzzer combines.
TEST(StateFiles, AlteredAtOnePlaceAreRefusedOrCanBeUsed) {
  constexpr int kinds = 3, alterations = 9, most_names = 24, arguments = 17;
  for (int kind = 0; kind < kinds; ++kind) {
    for (int alteration = 0; alteration < alterations; ++alteration) {
      for (int name = 0; name < most_names; ++name) {
        const int variants = alteration == 0 ? arguments : 3;
        for (int variant = 0; variant < variants; ++variant) {
          const auto byte = [](int x) { return static_cast<char>(x); };
          const std::string recipe = alteration == 0
                                         ? std::string{byte(kind), byte(alteration), byte(name), byte(0), byte(7 * variant), byte(variant)}
                                         : std::string{byte(kind), byte(alteration), byte(name), byte(variant), byte(variant)};
          expect_no_finding({"state_file", state_file}, recipe,
                            "kind " + std::to_string(kind) + ", alteration " + std::to_string(alteration) + ", name " +
                                std::to_string(name) + ", variant " + std::to_string(variant));
        }
      }
    }
  }
}

TEST(CorpusFolder, StaysSmall) {
  constexpr std::size_t most_files = 200;
  constexpr std::uintmax_t most_bytes = 300'000;
  std::size_t files = 0;
  std::uintmax_t bytes = 0;
  for (const Target& target : targets) {
    for (const auto& file : inputs(corpus / target.name)) {
      ++files;
      bytes += std::filesystem::file_size(file);
    }
  }
  EXPECT_LT(files, most_files);
  EXPECT_LT(bytes, most_bytes);
}

}  // namespace
}  // namespace mpm::fuzz
