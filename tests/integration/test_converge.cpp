/// `mpm converge` as a user runs it.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "libmpm/base/error.hpp"
#include "libmpm/io/csv.hpp"
#include "support/command_test.hpp"
#include "support/text.hpp"

namespace mpm {
namespace {

namespace fs = std::filesystem;

using testing::contains;
using testing::content;
using testing::Outcome;

/// An avalanche that has only just met the mast: no steady interval, no means.
constexpr const char* first_instant = R"([material]
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 5.0
[conveyor]
velocity_m_s = 4.0
flow_height_m = 1.0
width_m = 3.0
upstream_length_m = 2.0
downstream_length_m = 1.5
[obstacle]
width_m = 0.5
depth_m = 0.5
[output]
duration_s = 0.02
)";

class Converge : public testing::CommandTest {
 protected:
  Outcome mpm(const std::string& case_text, const std::string& arguments) const {
    std::ofstream(directory_ / "block.toml") << case_text;
    return CommandTest::mpm("converge block.toml " + arguments);
  }
};

TEST_F(Converge, StudiesSeveralMetricsAndWritesItsFiles) {
  const Outcome o = mpm(testing::falling_block_case,
                        "--cell-size 0.25,0.5,0.125 --metric steps,particles_final --exact 20,0 --threads 1 --out study "
                        "--details");
  ASSERT_EQ(o.code, 0) << o.err;
  for (const char* word : {"cell_size_m", "0.125", "steps", "order, three finest", "GCI", "Richardson limit", "verdict",
                           "errors against 20", "particles_final = 4096 +- "})
    EXPECT_TRUE(contains(o.out, word)) << word << "\n" << o.out;
  for (const char* name : {"dx0.5", "dx0.25", "dx0.125"})
    EXPECT_TRUE(fs::exists(directory_ / "study/runs" / name / "results.json")) << name;
  const auto json = nlohmann::json::parse(content(directory_ / "study/converge.json"));
  EXPECT_EQ(json["points"].size(), 3u);
  EXPECT_EQ(json["points"][1]["directory"], "runs/dx0.25");
  EXPECT_EQ(json["metrics"][1]["value"], (std::vector{64.0, 512.0, 4096.0}));
  const Table table = Table::read(directory_ / "study/converge.csv");
  EXPECT_EQ(table.numbers("cell_size_m"), (std::vector{0.5, 0.25, 0.125}));
  EXPECT_EQ(table.numbers("particles_final"), (std::vector{64.0, 512.0, 4096.0}));

  const Outcome again = mpm(testing::falling_block_case, "--cell-size 0.5,0.25,0.125 --metric steps --threads 1 --out study");
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_FALSE(contains(again.err, "started")) << again.err;
  EXPECT_TRUE(contains(again.out, "steps = ")) << again.out;
  EXPECT_FALSE(contains(again.out, "Richardson limit")) << again.out;

  const std::string before = content(directory_ / "study/runs/dx0.5/results.json");
  const Outcome other =
      mpm(testing::falling_block_case, "--cell-size 0.5,0.25 --metric steps --threads 1 --out study --set output.duration_s=0.03");
  EXPECT_EQ(other.code, 0) << other.err;
  EXPECT_EQ(content(directory_ / "study/runs/dx0.5.1/results.json"), before) << "results of another duration are kept";
  EXPECT_TRUE(fs::exists(directory_ / "study/runs/dx0.5/final.h5"));
  EXPECT_EQ(Table::read(directory_ / "study/converge.csv").numbers("cell_size_m"), (std::vector{0.5, 0.25}));
}

TEST_F(Converge, OfAFailedRunNamesItAndItsCause) {
  const Outcome o =
      mpm(testing::falling_block_case,
          "--cell-size 0.5,0.25 --metric steps --threads 1 --set body[0].velocity_m_s=[900,0,0] --set material.young_modulus_pa=1 "
          "--set material.density_kg_m3=1e5");
  EXPECT_EQ(o.code, static_cast<int>(ExitCode::failed)) << o.err;
  EXPECT_TRUE(contains(o.err, "dx0.5: failed: exit code 3: ")) << o.err;
  EXPECT_FALSE(fs::exists(directory_ / "out/block_cell_size_m/converge.csv"));
}

TEST_F(Converge, SweepsTheOtherParametersByTheirScatter) {
  EXPECT_EQ(mpm(testing::falling_block_case, "--particles-per-cell 8,1 --metric particles_final --threads 1").code, 0);
  EXPECT_TRUE(fs::exists(directory_ / "out/block_particles_per_cell/runs/ppc8/results.json"));
  EXPECT_EQ(mpm(testing::falling_block_case, "--cfl 0.8,0.4,0.2 --metric steps --threads 1").code, 0);
  EXPECT_TRUE(fs::exists(directory_ / "out/block_cfl/runs/cfl0.2/results.json"));
  const Outcome o =
      mpm(testing::falling_block_case, "--offset 0,0.25,0.5 --offset-axes xz --metric steps --threads 1 --set numerics.cell_size_m=0.5");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_TRUE(contains(o.out, "scatter over 3 values")) << o.out;
  EXPECT_TRUE(
      contains(content(directory_ / "out/block_grid_offset_cells/runs/offset0.25/case.toml"), "grid_offset_cells = [0.25, 0.0, 0.25]"));
}

TEST_F(Converge, TellsWhatHasNoSteadySpanAndWhatIsTooFew) {
  const Outcome o = mpm(first_instant, "--cell-size 0.25,0.125 --metric 'runup_mean_m, steps' --threads 1");
  EXPECT_EQ(o.code, static_cast<int>(ExitCode::failed)) << o.err;  // no value of one metric
  EXPECT_TRUE(contains(o.err, "cell_size_m = 0.25: no runup_mean_m: the run has no steady interval")) << o.err;
  EXPECT_TRUE(contains(o.err, "the windows of the pressure profile follow the cell size")) << o.err;
  EXPECT_TRUE(contains(o.out, "note: fewer than three cells across the obstacle at 0.25 (2 cells)")) << o.out;
  EXPECT_TRUE(contains(o.out, "values only: 0 sizes with a value")) << o.out;
  EXPECT_TRUE(contains(o.out, "values only: 2 sizes with a value, an order needs three")) << o.out;
}

TEST_F(Converge, RefusesWhatItCannotDoWithExitCode2) {
  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"--metric steps", "Exactly 1 option"},
           {"--cell-size 0.5,0.25 --cfl 0.4 --metric steps", "Exactly 1 option"},
           {"--cell-size 0.5,0.25", "--metric"},
           {"--cell-size 0.5,-0.25 --metric steps", "--cell-size"},
           {"--cell-size 0.5,0.5 --metric steps", "0.5 is given twice"},
           {"--cell-size 50 --metric steps", "thinnest"},
           {"--particles-per-cell 9 --metric steps", "particles_per_cell = 9"},
           {"--offset 2 --metric steps", "grid_offset_cells"},
           {"--offset 0.5 --offset-axes w --metric steps", "axes 'w'"},
           {"--cell-size 0.5,0.25 --metric steps --exact 1,2", "2 values for 1 metric;"},
           {"--cell-size 0.5,0.25 --metric steps --set numerics.cell_size_m=1", "numerics.cell_size_m is what the study varies"},
           {"--cell-size 0.5 --metric stepps --threads 1", "did you mean steps?"},
           {"--cell-size 0.5 --metric runup_mean_m --threads 1", "runup_mean_m"}}) {
    SCOPED_TRACE(arguments);
    const Outcome o = mpm(testing::falling_block_case, arguments);
    EXPECT_EQ(o.code, static_cast<int>(ExitCode::usage)) << o.err;
    EXPECT_TRUE(contains(o.err, words)) << o.err;
    EXPECT_TRUE(o.out.empty()) << o.out;
  }
  EXPECT_FALSE(fs::exists(directory_ / "out"));  // nothing was computed
}

}  // namespace
}  // namespace mpm
