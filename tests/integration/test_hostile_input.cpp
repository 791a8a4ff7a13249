/// Invalid command lines and files: a clear message and exit code 2 or 4, at once, with little memory, and nothing written.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/estimate.hpp"
#include "support/command.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;

using testing::Outcome;

const std::string valid_case = R"([material]
model = "hencky_elastic"
[[body]]
min_m = [0.0, 0.0, 0.0]
max_m = [1.0, 1.0, 1.0]
[domain]
min_m = [-1e5, -1e5, -1e5]
max_m = [1e5, 1e5, 1e5]
[output]
duration_s = 0.01
)";

std::string repeated(const std::string& text, int times) {
  std::string all;
  all.reserve(text.size() * static_cast<std::size_t>(times));
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

class HostileInput : public ::testing::Test {
 protected:
  HostileInput() {
    fs::create_directory(here_);
    write("valid.toml", valid_case);
  }

  fs::path write(const std::string& name, const std::string& text) const {
    fs::path file = directory_ / name;
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }

  /// A minute and, where no sanitizer takes address space of its own, 4 GB are far more than any refusal needs.
  [[nodiscard]] Outcome mpm(const std::string& arguments) const {
#if defined(__SANITIZE_ADDRESS__)
    const std::string limit;
#else
    const std::string limit = "ulimit -v 4000000 && ";
#endif
    return testing::run_command("(" + limit + "timeout 60 '" MPM_APP "' " + arguments + ")", here_, directory_.path());
  }

  void expect_refused(const std::string& arguments, const std::vector<std::string>& words = {}) const {
    SCOPED_TRACE(arguments.substr(0, 200));
    const Outcome o = mpm(arguments);
    EXPECT_TRUE(o.code == static_cast<int>(ExitCode::usage) || o.code == static_cast<int>(ExitCode::io)) << o.code << '\n'
                                                                                                         << o.err.substr(0, 1000);
    EXPECT_TRUE(o.out.empty()) << o.out.substr(0, 1000);
    EXPECT_FALSE(o.err.empty());
    constexpr std::size_t longest = 100'000;  // characters: 200 errors are shown at most
    EXPECT_LT(o.err.size(), longest);
    for (const char* crash : {"terminate", "what()", "egmentation", "core dumped", "internal error", "Sanitizer", "bad_alloc"})
      EXPECT_EQ(o.err.find(crash), std::string::npos) << o.err.substr(0, 1000);
    for (const std::string& word : words) EXPECT_NE(o.err.find(word), std::string::npos) << word << "\nin\n" << o.err.substr(0, 1000);
    EXPECT_TRUE(fs::is_empty(here_)) << "something was written";
  }

  testing::TemporaryDirectory directory_;
  fs::path here_ = directory_ / "here";
};

TEST_F(HostileInput, FilesThatAreNoCasesAreRefusedByEveryCommandThatReadsOne) {
  std::mt19937_64 random(1);
  std::string noise(1 << 20, '\0');
  for (char& c : noise) c = static_cast<char>(random());
  struct File {
    std::string name, content, words;
  };
  const File files[] = {
      {"empty", "", ":1:1: "},
      {"blank", "\n\n \t\n", ":1:1: "},
      {"noise", noise, "not valid TOML"},
      {"zeros", std::string(1000, '\0'), "not valid TOML"},
      {"elf",
       "\x7f"
       "ELF\x02\x01\x01" +
           std::string(100, '\0'),
       "not valid TOML"},
      {"wrong_utf8", "title = \"\xff\xfe\"\n", "not valid TOML"},
      {"nested_lists", "title = " + repeated("[", 1'000'000), "nested"},
      {"nested_tables", "title = " + repeated("{a = ", 100'000), "nested"},
      {"long_dotted_key", repeated("a.", 100'000) + "a = 1\n", "parts"},
      {"long_dotted_table", "[" + repeated("a . ", 100'000) + "a]\n", "parts"},
      {"long_quoted_key", repeated("\"=\".'#'.", 100'000) + "a = 1\n", "parts"},
      {"nested_dotted_tables", "title = " + repeated("{a.b.c.d.e.f.g.h.i.j.k.l = ", 200) + "1" + repeated("}", 200), ""},
      {"long_word", repeated("a", 1'000'000), "not valid TOML"},
      {"long_number", "x = " + repeated("1", 1'000'000), "not valid TOML"},
      {"long_title", "title = \"" + repeated("x", 1'000'000) + "\"\n", "missing"},
      {"unknown_keys",
       [] {
         std::string text;
         for (int i = 0; i < 100'000; ++i) text += "k" + std::to_string(i) + " = 1\n";
         return text;
       }(),
       "at least 800 more errors"},
      {"empty_bodies", repeated("[[body]]\n", 100'000), "at least 800 more errors"},
      {"segments", "[path]\nsegments = [" + repeated("{ }, ", 100'000) + "]\n", ""},
  };
  for (const File& file : files) {
    const std::string path = "'" + write(file.name, file.content).string() + "'";
    for (const std::string verb : {"check ", "run ", "point "})
      expect_refused(verb + path, verb == "point " ? std::vector<std::string>{} : std::vector{file.words});
  }
}

TEST_F(HostileInput, WhatIsNoFileOrTooLargeIsRefused) {
  const fs::path large = write("large", "");
  fs::resize_file(large, 100'000'000);  // sparse: of zeros
  const fs::path folder = directory_ / "folder";
  fs::create_directory(folder);
  for (const std::string verb : {"check ", "run ", "point ", "converge --cell-size 0.5,0.25,0.125 --metric x "}) {
    expect_refused(verb + "'" + large.string() + "'", {"larger than"});
    expect_refused(verb + "'" + folder.string() + "'", {"cannot be read"});
    expect_refused(verb + "absent.toml", {"absent.toml"});
    expect_refused(verb + "''", {"cannot be read"});
    expect_refused(verb + "'" + std::string(5000, 'x') + "'", {"cannot be read"});
    if (fs::exists("/dev/zero")) expect_refused(verb + "/dev/zero", {"larger than"});
    if (fs::exists("/dev/null")) expect_refused(verb + "/dev/null");
  }
  for (const std::string arguments : {"post absent", "post /dev/null", "compare absent absent", "compare /dev/null /dev/null"})
    expect_refused(arguments);
  expect_refused("post '" + folder.string() + "'", {"case.toml"});
}

TEST_F(HostileInput, PlansWithoutEndAreRefused) {
  const std::string base =
      "[base.material]\nmodel = \"hencky_elastic\"\n[[base.body]]\nmin_m = [0, 0, 0]\nmax_m = [1, 1, 1]\n"
      "[base.domain]\nmin_m = [-5, -5, -5]\nmax_m = [5, 5, 5]\n[base.output]\nduration_s = 0.01\n";
  const auto refuse = [&](const std::string& text, const std::string& word) {
    const std::string plan = "'" + write("plan.toml", text + base).string() + "'";
    for (const char* const verb : {"campaign status ", "campaign run "}) expect_refused(verb + plan, {word});
  };
  const fs::path large = write("large.csv", "");
  fs::resize_file(large, std::uintmax_t{50} << 30);  // sparse
  for (const std::string& table : {std::string("/dev/zero"), large.string()}) {
    if (fs::exists(table)) refuse("table = \"" + table + "\"\n", "bytes");
  }
  std::string rows = "name\n";
  for (int i = 0; i < 100'001; ++i) rows += "r" + std::to_string(i) + "\n";
  refuse("table = \"" + write("rows.csv", rows).string() + "\"\n", "at most 100000");
  std::string values = "0.1", keys;
  for (int i = 1; i < 999; ++i) values += ", " + std::to_string(0.1 + 1e-6 * i);
  refuse("[parameters]\n\"numerics.cfl\" = [" + values + "]\n\"material.poisson_ratio\" = [" + values + "]\n", "100000 runs");
  for (int i = 0; i < 200'000; ++i) keys += "k" + std::to_string(i) + " = 1\n";
  refuse("[set]\n" + keys, "at least 800 more errors");
  refuse(keys, "at least 800 more errors");
}

TEST_F(HostileInput, CommandLinesOutOfTheirMindAreRefused) {
  const std::string file = " '" + (directory_ / "valid.toml").string() + "' ";
  for (const std::string& arguments :
       std::vector<std::string>{"''",
                                "--nonsense",
                                "check --",
                                "check -1",
                                "chek" + file,
                                "check" + file + "extra",
                                "check" + file + "--resume",
                                "run" + file + "--threads 0",
                                "run" + file + "--threads -3",
                                "run" + file + "--threads 99999999999999999999",
                                "run" + file + "--threads 1e3",
                                "run" + file + "--threads nan",
                                "run" + file + "--out",
                                "run" + file + "--out /dev/null/x",
                                "run" + file + "--out " + file,
                                "point" + file,
                                "schema extra",
                                "predict --froude nan",
                                "predict --froude -1",
                                "predict --froude 1e300",
                                "predict --froude x",
                                "predict --gravity 0",
                                "predict --gravity inf",
                                "predict --density nan",
                                "predict --cohesion-beta 1",
                                "predict --flow-height 0",
                                "predict --poisson-ratio 0.5",
                                "predict --froude " + repeated("1,", 999) + "1 --flow-height " + repeated("1,", 999) + "1",
                                "converge" + file + "--cell-size nan,1,2 --metric x",
                                "converge" + file + "--cell-size 1e-300,1,2 --metric x",
                                "converge" + file + "--cfl 1e-300,0.1,0.2 --metric x",
                                "converge" + file + "--particles-per-cell 8e300 --metric x",
                                "converge" + file + "--offset inf,0,1 --metric x",
                                "compare . . --tolerance nan",
                                "compare . ."}) {
    expect_refused(arguments);
  }
}

TEST_F(HostileInput, NonsenseInSetIsRefusedAndNamed) {
  const std::string file = "check '" + (directory_ / "valid.toml").string() + "' --set ";
  for (const std::string& set : std::vector<std::string>{"",
                                                         "=",
                                                         "=1",
                                                         "a",
                                                         "a=",
                                                         "a=1",
                                                         ".=1",
                                                         "..=1",
                                                         "a.b.c.d=1",
                                                         "numerics=1",
                                                         "numerics.=1",
                                                         ".cfl=1",
                                                         "numerics..cfl=1",
                                                         "numerics.cfl",
                                                         "numerics.cfl=",
                                                         "numerics.cfl==1",
                                                         "numerics.cfl=nan",
                                                         "numerics.cfl=[",
                                                         "numerics.cfl=" + repeated("[", 100'000),
                                                         "body=1",
                                                         "body.min_m=1",
                                                         "body[1].min_m=[0,0,0]",
                                                         "body[-1].min_m=[0,0,0]",
                                                         "body[999999].min_m=[0,0,0]",
                                                         "body[9999999].min_m=[0,0,0]",
                                                         "body[].min_m=[0,0,0]",
                                                         "body[0]=1",
                                                         "body[0].min_m[0]=1",
                                                         "body[0][0].min_m=1",
                                                         "output.duration_s=1e300",
                                                         "output.duration_s=-1",
                                                         "output.duration_s=1e999",
                                                         "output.series_per_second=1e12",
                                                         "a=" + repeated("x", 100'000),
                                                         repeated("x", 100'000) + "=1",
                                                         "material.model=" + repeated("{a.b.c.d = ", 5000),
                                                         "numerics.cfl=0.5 numerics.cfl=0.4",
                                                         "\xff=\xff"}) {
    expect_refused(file + "'" + set + "'", {"--set "});
  }
}

TEST_F(HostileInput, AbsurdSizesAreRefusedBeforeAnythingIsAllocated) {
  struct Absurdity {
    std::string sets;
    std::vector<std::string> words;  ///< what, the value, the remedy
  };
  const Absurdity absurdities[] = {
      {"numerics.cell_size_m=1e-4", {"GB of memory", "8e+12 particles", "cell_size_m"}},
      {"'body[0].max_m=[1e5,1e5,1e5]' --set numerics.cell_size_m=1e2", {"GB of memory", "particles", "less snow"}},
      {"output.duration_s=1e6 --set output.series_per_second=1e6", {"1e+12 samples", "at most 1e+08", "series_per_second"}},
      {"output.duration_s=1e6 --set output.series_per_second=1e4 --set output.frames_per_second=1e4",
       {"1e+10 samples", "1e+10 frames", "at most 1e+05"}},
      {"numerics.cfl=1e-9 --set output.duration_s=1e6", {"steps", "at most 1e+12", "numerics.cfl"}},
      {"output.duration_s=1e6 --set numerics.cell_size_m=0.001", {"years of computing", "at most 10"}},
      {"output.duration_s=1e300", {"duration_s = 1e+300 is out of range", "1e+06"}},
      {"output.series_per_second=1e12", {"series_per_second = 1000000000000.0", "out of range"}},
      {"output.frames_per_second=1e10", {"frames_per_second = 10000000000.0", "out of range"}},
      {"'body[0].min_m=[-1e5,0,0]' --set 'body[0].max_m=[-99999.99,0.01,0.01]' --set numerics.cell_size_m=1e-3",
       {"body[0]", "origin", "cells"}},
  };
  for (const Absurdity& absurdity : absurdities) {
    for (const std::string verb : {"check", "run", "run --any-size"}) {
      if (verb == "run --any-size" && absurdity.words.front() == "GB of memory") continue;  // that is what it allows
      expect_refused(verb + " '" + (directory_ / "valid.toml").string() + "' --set " + absurdity.sets, absurdity.words);
    }
  }
}

TEST_F(HostileInput, PointPathOfAbsurdLengthIsRefused) {
  const std::string head = "[material]\nmodel = \"hencky_elastic\"\n[path]\nsteps_per_segment = 100000000\nsegments = [";
  const fs::path file = write("path.toml", head + repeated("{ d_eps_v = 0.1 }, ", 40) + "]\n");
  expect_refused("point '" + file.string() + "'", {"4e+09 steps", "GB of rows", "fewer"});
}

TEST_F(HostileInput, ResultsThatAreNoJsonOrNestedAreRefused) {
  for (const std::string& json :
       {std::string(), std::string("[]"), std::string("{"), "{\"a\":" + repeated("[", 1'000'000),
        "{\"a\":" + repeated("[", 100'000) + repeated("]", 100'000) + "}", "{\"a\":" + repeated("{\"a\":", 100'000)}) {
    for (const std::string name : {"A", "B"}) {
      fs::create_directories(directory_ / name);
      write(name + "/results.json", json);
    }
    expect_refused("compare ../A ../B", {"results.json"});
  }
}

TEST(RequireFeasible, CanBeToldToForgetTheMemoryAndNothingElse) {
  const auto need = [](const std::vector<std::string>& sets) { return estimate(parse_case(valid_case, "case.toml", sets)); };
  const double any = std::numeric_limits<double>::infinity(), laptop = 16e9;
  const Estimate large = need({"numerics.cell_size_m=0.002"});
  EXPECT_THROW(require_feasible(large, laptop), ConfigError);
  EXPECT_NO_THROW(require_feasible(large, any));
  EXPECT_THROW(require_feasible(need({"output.duration_s=1e6", "output.series_per_second=1e6"}), any), ConfigError);
  EXPECT_NO_THROW(require_feasible(need({}), laptop));
}

}  // namespace
}  // namespace mpm
