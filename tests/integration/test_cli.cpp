/// The `mpm` command as a user meets it: exit codes, which stream says what, and that a bad case leaves no trace.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <tuple>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/threads.hpp"
#include "support/command.hpp"
#include "support/temporary_directory.hpp"
#include "support/text.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;

using testing::content;
using testing::Outcome;

const fs::path examples = fs::path(MPM_SOURCE_DIR) / "examples";

class Command : public ::testing::Test {
 protected:
  /// Runs `mpm` in an empty directory of its own.
  Outcome mpm(const std::string& arguments) const {
    return testing::run_command("'" MPM_APP "' " + arguments, directory_.path() / "here", directory_.path());
  }

  fs::path write(const std::string& text) const {
    fs::path file = directory_.path() / "case.toml";
    std::ofstream(file) << text;
    return file;
  }

  [[nodiscard]] bool nothing_written() const { return fs::is_empty(directory_.path() / "here"); }

  void SetUp() override { fs::create_directory(directory_.path() / "here"); }

  testing::TemporaryDirectory directory_;
};

constexpr int code_of(ExitCode code) { return static_cast<int>(code); }

/// A block that falls for a moment: the smallest run that goes through every part.
const std::string small_case = R"(title = "a falling block"
[material]
model = "hencky_elastic"
[[body]]
min_m = [0.0, 0.0, 1.0]
max_m = [0.5, 0.5, 1.5]
[domain]
min_m = [-1.0, -1.0, -1.0]
max_m = [2.0, 2.0, 2.0]
[output]
duration_s = 0.1
)";

TEST_F(Command, TellsItsVersion) {
  const Outcome o = mpm("--version");
  EXPECT_EQ(o.code, 0);
  for (const char* word : {"mpm ", "commit", "compiler", "SIMD", "threads"}) EXPECT_NE(o.out.find(word), std::string::npos) << word;
}

TEST_F(Command, HelpListsTheSubcommands) {
  const Outcome o = mpm("--help");
  EXPECT_EQ(o.code, 0);
  for (const char* word : {"check", "run", "post", "point", "compare", "converge", "predict", "schema"})
    EXPECT_NE(o.out.find(word), std::string::npos) << word;
}

TEST_F(Command, WrongUsageIsExitCode2OnStderr) {
  for (const char* arguments :
       {"", "fly", "check", "check a.toml b.toml", "run", "run --threads 0 a.toml", "run --threads x a.toml", "check --nonsense"}) {
    SCOPED_TRACE(arguments);
    const Outcome o = mpm(arguments);
    EXPECT_EQ(o.code, code_of(ExitCode::usage));
    EXPECT_TRUE(o.out.empty()) << o.out;
    EXPECT_FALSE(o.err.empty());
  }
}

TEST_F(Command, MisspeltCommandsAndMissingFilesAreNamed) {
  for (const auto& [arguments, code, words] : std::initializer_list<std::tuple<std::string, ExitCode, std::string>>{
           {"rnu case.toml", ExitCode::usage, "mpm has no command 'rnu'; did you mean run?"},
           {"campaign stauts plan.toml", ExitCode::usage, "campaign has no command 'stauts'; did you mean status?"},
           {"xyzzyx", ExitCode::usage, "there are check, run"},
           {"check nowhere.toml", ExitCode::io, "'nowhere.toml' does not exist"},
           {"check ../case.toml --set numerics.cfl", ExitCode::usage, "--set"}}) {
    SCOPED_TRACE(arguments);
    (void)write("");
    const Outcome o = mpm(arguments);
    EXPECT_EQ(o.code, code_of(code));
    EXPECT_NE(o.err.find(words), std::string::npos) << o.err;
  }
}

TEST_F(Command, MoreThreadsThanAMachineCanUseAreRefused) {
  (void)write("");
  const Outcome o = mpm("run ../case.toml --threads 100000");
  EXPECT_EQ(o.code, code_of(ExitCode::usage));
  EXPECT_NE(o.err.find(fmt::format("--threads: 100000 is not in [1, {}]", most_threads())), std::string::npos) << o.err;
}

TEST_F(Command, MoreThreadsThanAMachineCanUseAreNotTakenFromTheEnvironment) {
  (void)write(small_case);
  const Outcome o = testing::run_command("OMP_NUM_THREADS=5000 '" MPM_APP "' run ../case.toml --out result", directory_.path() / "here",
                                         directory_.path());
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("OMP_NUM_THREADS asks for 5000 threads"), std::string::npos) << o.err;
  EXPECT_EQ(nlohmann::json::parse(o.out).at("threads"), most_threads());
}

TEST_F(Command, WithClosedStreamsNoResultsFileGetsTheMessages) {
  (void)write(small_case);
  ASSERT_EQ(mpm("run ../case.toml --threads 1 --out open").code, 0);
  for (const std::string closed : {"<&-", "2>&-", "<&- >&- 2>&-"}) {
    SCOPED_TRACE(closed);
    const bool no_output = closed.find(" >&-") != std::string::npos;
    EXPECT_EQ(mpm("run ../case.toml --threads 1 --force --out closed " + closed).code, no_output ? code_of(ExitCode::io) : 0);
    for (const char* file : {"series.csv", "case.toml", "final.h5"})
      EXPECT_EQ(content(directory_.path() / "here/closed" / file), content(directory_.path() / "here/open" / file)) << file;
  }
}

TEST_F(Command, FilesOfAGroupFolderAreAsTheUmaskSays) {
  (void)write(small_case);
  ASSERT_EQ(testing::run_command("umask 0002 && '" MPM_APP "' run ../case.toml --threads 1 --out result", directory_.path() / "here",
                                 directory_.path())
                .code,
            0);
  for (const auto& entry : fs::recursive_directory_iterator(directory_.path() / "here/result"))
    EXPECT_NE(entry.status().permissions() & fs::perms::group_write, fs::perms::none) << entry.path();
}

TEST_F(Command, LinksInTheFolderOfARunAreNotFollowed) {
  (void)write(small_case);
  const fs::path result = directory_.path() / "here/result", victim = directory_.path() / "victim";
  for (const char* name : {"run.log", ".lock"}) {
    SCOPED_TRACE(name);
    std::ofstream(victim) << "precious";
    fs::create_directories(result);
    fs::create_symlink(victim, result / name);
    const Outcome o = mpm("run ../case.toml --threads 1 --out result");
    EXPECT_EQ(o.code, code_of(ExitCode::io));
    EXPECT_NE(o.err.find("symbolic link"), std::string::npos) << o.err;
    EXPECT_EQ(content(victim), "precious");
    fs::remove_all(result);
  }
}

TEST_F(Command, FilesOfTheUserAreNotOverwritten) {
  const fs::path here = directory_.path() / "here";
  const std::string plan = testing::falling_block_plan + std::string("[[run]]\nname = \"a\"\nset = { \"numerics.cell_size_m\" = 0.5 }\n");
  const std::string site = "[flow]\ndepth_m = 1.0\nvelocity_m_s = 3.0\nsnow_class = \"loose\"\n[mast]\nwidth_m = 1.0\n";
  struct File {
    std::string name, text, command;
  };
  for (const File& file : std::vector<File>{{"case.toml", small_case, "run case.toml --out ."},
                                            {"case.toml", small_case, "run case.toml --out . --resume"},
                                            {"series.csv", "time_s\n", "run ../case.toml --out ."},
                                            {"plan.toml", plan, "campaign run plan.toml --out ."},
                                            {"results.csv", "my results\n", "campaign run ../plan.toml --out ."},
                                            {"site.toml", site, "design site.toml --quick --out ."}}) {
    SCOPED_TRACE(file.command);
    (void)write(small_case);
    std::ofstream(directory_.path() / "plan.toml") << plan;
    std::ofstream(here / file.name) << file.text;
    const Outcome o = mpm(file.command);
    EXPECT_EQ(o.code, code_of(ExitCode::usage));
    EXPECT_NE(o.err.find("'./" + file.name + "' is not of this program"), std::string::npos) << o.err;
    EXPECT_EQ(content(here / file.name), file.text);
    fs::remove(here / file.name);
    EXPECT_TRUE(nothing_written());
  }
  (void)write(small_case);
  std::ofstream(here / "case.toml") << small_case;
  EXPECT_EQ(mpm("run case.toml --out . --threads 1 --force").code, 0);                               // as asked
  EXPECT_EQ(mpm("run case.toml --out . --threads 1 --resume --set output.duration_s=0.2").code, 0);  // its own folder now
}

TEST_F(Command, RangesAreReadable) {
  (void)write("");
  for (const char* arguments : {"--cell-size 0.5,-0.25", "--cfl nan", "--cfl 1e999"}) {
    const Outcome o = mpm(std::string("converge ../case.toml --metric steps ") + arguments);
    EXPECT_EQ(o.code, code_of(ExitCode::usage));
    EXPECT_NE(o.err.find("is not a number above 0"), std::string::npos) << o.err;
    EXPECT_LT(o.err.size(), 200u) << o.err;  // no bound of 300 digits
  }
}

TEST_F(Command, CheckPrintsACaseThatReadsBack) {
  for (const auto& entry : fs::directory_iterator(examples)) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path());
    const Outcome o = mpm("check '" + entry.path().string() + "'");
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_EQ(parse_case(o.out, "printed"), read_case(entry.path()));
    for (const char* word : {"particles", "cells", "time step", "steps", "memory", "time "})
      EXPECT_NE(o.out.find(word), std::string::npos) << word;
  }
  EXPECT_TRUE(nothing_written());
}

TEST_F(Command, CheckWarnsOfWhatMaySpoilTheResultAndIsNoError) {
  const Outcome o =
      mpm("check '" + (examples / "avalanche_fr3.toml").string() + "' --set numerics.cell_size_m=0.6 --set output.duration_s=1");
  EXPECT_EQ(o.code, 0);
  EXPECT_NE(o.err.find("warning: 2.92 cells across the obstacle"), std::string::npos) << o.err;
  EXPECT_NE(o.err.find("2 v/g = 2.53 s"), std::string::npos) << o.err;
}

TEST_F(Command, SetReplacesKeysInOrder) {
  const Outcome o =
      mpm("check --set numerics.cfl=0.3 --set 'title=a b' '" + (examples / "avalanche_fr3.toml").string() + "' --set numerics.cfl=0.2");
  ASSERT_EQ(o.code, 0) << o.err;
  const Case c = parse_case(o.out, "printed");
  EXPECT_EQ(c.numerics.cfl, 0.2);
  EXPECT_EQ(c.title, "a b");
}

TEST_F(Command, BadCaseIsExitCode2WithAllFaultsAndLeavesNoTrace) {
  const fs::path file = write("[material]\npoisson_ratio = 0.9\n[conveyer]\nfroude_number = 3\n[obstacle]\n[output]\nduration_s = 1\n");
  for (const std::string verb : {"check", "run"}) {
    SCOPED_TRACE(verb);
    const Outcome o = mpm(verb + " ../case.toml --set numerics.cfl=7");
    EXPECT_EQ(o.code, code_of(ExitCode::usage));
    EXPECT_TRUE(o.out.empty()) << o.out;
    for (const char* fault :
         {"../case.toml:2:17: [material] poisson_ratio = 0.9", "../case.toml:3:2: unknown table [conveyer]; did you mean [conveyor]?",
          "../case.toml:1:1: [material] cohesion_beta is missing", "--set numerics.cfl=7: [numerics] cfl = 7 is out of range"}) {
      EXPECT_NE(o.err.find(fault), std::string::npos) << fault << "\nin\n" << o.err;
    }
    EXPECT_TRUE(nothing_written());
  }
}

TEST_F(Command, CaseBeyondTheMachinesMemoryIsRefusedBeforeItStarts) {
  for (const std::string verb : {"check", "run"}) {
    const Outcome o = mpm(verb + " '" + (examples / "avalanche_fr3.toml").string() + "' --set numerics.cell_size_m=0.0005");
    EXPECT_EQ(o.code, code_of(ExitCode::usage)) << verb;
    EXPECT_NE(o.err.find("GB"), std::string::npos) << o.err;
    EXPECT_TRUE(nothing_written());
  }
}

TEST_F(Command, MissingFileIsExitCode4) {
  for (const std::string verb : {"check", "run", "point"}) {
    const Outcome o = mpm(verb + " absent.toml");
    EXPECT_EQ(o.code, code_of(ExitCode::io)) << verb;
    EXPECT_NE(o.err.find("absent.toml"), std::string::npos) << o.err;
    EXPECT_TRUE(nothing_written());
  }
}

TEST_F(Command, FullDiskIsExitCode4) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  const int status = std::system("'" MPM_APP "' schema >/dev/full 2>/dev/null");
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), code_of(ExitCode::io));
}

TEST_F(Command, SchemaPrintsTextAndJson) {
  EXPECT_NE(mpm("schema").out.find("critical_state_slope"), std::string::npos);
  const Outcome o = mpm("schema --json");
  EXPECT_EQ(o.code, 0);
  EXPECT_TRUE(nlohmann::json::accept(o.out));
}

TEST_F(Command, RunPrintsResultsToStdoutAndProgressToStderr) {
  (void)write(small_case);
  const Outcome o = mpm("run ../case.toml --threads 1 --out result");
  ASSERT_EQ(o.code, 0) << o.err;
  const auto results = nlohmann::json::parse(o.out);
  EXPECT_EQ(results.at("title"), "a falling block");
  EXPECT_EQ(results, nlohmann::json::parse(content(directory_.path() / "here/result/results.json")));
  EXPECT_NE(o.err.find("100.0 %"), std::string::npos) << o.err;
  EXPECT_EQ(o.err.find('\r'), std::string::npos) << "no terminal, no rewritten line";
  EXPECT_EQ(read_case(directory_.path() / "here/result/case.toml"), parse_case(small_case, "case"));
}

TEST_F(Command, RunWritesToOutByDefault) {
  (void)write(small_case);
  ASSERT_EQ(mpm("run ../case.toml").code, 0);
  EXPECT_TRUE(fs::exists(directory_.path() / "here/out/case/results.json"));
}

TEST_F(Command, RunDoesNotOverwriteResultsUnasked) {
  (void)write(small_case);
  const fs::path result = directory_.path() / "here/result";
  ASSERT_EQ(mpm("run ../case.toml --threads 1 --out result").code, 0);
  const std::string before = content(result / "results.json");
  const Outcome refused = mpm("run ../case.toml --threads 1 --out result");
  EXPECT_EQ(refused.code, code_of(ExitCode::usage));
  for (const char* word : {"holds the results of a run", "--resume", "--out", "--force"})
    EXPECT_NE(refused.err.find(word), std::string::npos) << refused.err;
  EXPECT_EQ(content(result / "results.json"), before);
  EXPECT_TRUE(fs::exists(result / "final.h5"));

  EXPECT_EQ(mpm("run ../case.toml --threads 1 --out result --force --resume").code, code_of(ExitCode::usage));
  EXPECT_EQ(mpm("run ../case.toml --threads 1 --out result --force").code, 0);
  EXPECT_NE(content(result / "results.json"), before);  // other times

  for (const char* name : {"results.json", "final.h5"}) fs::remove(result / name);  // as an interrupted run leaves it
  const Outcome interrupted = mpm("run ../case.toml --threads 1 --out result");
  EXPECT_EQ(interrupted.code, code_of(ExitCode::usage));
  EXPECT_NE(interrupted.err.find("holds the checkpoint of an interrupted run"), std::string::npos) << interrupted.err;
  EXPECT_TRUE(fs::exists(result / "checkpoint.h5"));
  EXPECT_EQ(mpm("run ../case.toml --threads 1 --out result --resume").code, 0);
}

TEST_F(Command, ResumeOfAFolderThatIsNotThereStartsNothing) {
  (void)write(small_case);
  const Outcome o = mpm("run ../case.toml --threads 1 --out rseult --resume");
  EXPECT_EQ(o.code, code_of(ExitCode::io));
  EXPECT_NE(o.err.find("rseult: there is no such folder to go on in"), std::string::npos) << o.err;
  EXPECT_FALSE(fs::exists(directory_.path() / "here/rseult"));
}

TEST_F(Command, ARunThatLosesAllParticlesSaysSo) {
  (void)write(small_case);
  const Outcome o = mpm("run ../case.toml --threads 1 --out result --set body[0].velocity_m_s=[40,0,0]");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("no particle is left at the end"), std::string::npos) << o.err;
}

TEST_F(Command, PointPrintsOneRowAStep) {
  const Outcome o = mpm("point '" + (examples / "paths/compression_then_shear.toml").string() + "' --set path.steps_per_segment=10");
  ASSERT_EQ(o.code, 0) << o.err;
  std::istringstream rows(o.out);
  std::string row;
  ASSERT_TRUE(std::getline(rows, row));
  EXPECT_EQ(row, "step,eps_v,eps_q,p_pa,q_pa,eps_v_plastic,preconsolidation_pressure_pa,yield_pa2");
  int count = 0;
  while (std::getline(rows, row)) EXPECT_EQ(std::stoi(row), count++);
  EXPECT_EQ(count, 21);
}

TEST_F(Command, InterruptedRunCanBeResumed) {
  (void)write(small_case);
  const fs::path here = directory_.path() / "here";
  const std::string line = "cd '" + here.string() +
                           "' && (timeout -s INT 2 '" MPM_APP
                           "' run ../case.toml --out result --set output.duration_s=1e5 "
                           "--set output.series_per_second=10 --set output.frames_per_second=0.001 --set 'domain.max_m=[1000,1000,1000]' "
                           "--set 'domain.min_m=[-1000,-1000,-1000]' --set numerics.gravity_m_s2=0 2>../err.txt; true)";
  ASSERT_EQ(std::system(line.c_str()), 0);
  const std::string messages = content(directory_.path() / "err.txt");
  EXPECT_NE(messages.find("--resume"), std::string::npos) << messages;
  EXPECT_EQ(messages.find("stopped at t"), messages.rfind("stopped at t")) << "reported once: " << messages;
  EXPECT_TRUE(fs::exists(here / "result/checkpoint.h5"));
}

TEST_F(Command, UnwritableDirectoryIsExitCode4) {
  (void)write(small_case);
  std::ofstream(directory_.path() / "here/occupied") << "a file, not a directory";
  EXPECT_EQ(mpm("run ../case.toml --out occupied/below").code, code_of(ExitCode::io));
}

TEST_F(Command, UnstableRunIsExitCode3AndKeepsWhatItHasWritten) {
  // Sound travels at millimetres a second and the block at 900 m/s: the stable step is a millionth of the step at rest.
  (void)write(small_case);
  const Outcome o =
      mpm("run ../case.toml --out result --set material.young_modulus_pa=1 --set material.density_kg_m3=1e5 "
          "--set 'body[0].velocity_m_s=[900,0,0]'");
  EXPECT_EQ(o.code, code_of(ExitCode::unstable)) << o.err;
  EXPECT_NE(o.err.find("time step collapsed"), std::string::npos) << o.err;
  EXPECT_TRUE(fs::exists(directory_.path() / "here/result/case.toml"));
}

}  // namespace
}  // namespace mpm
