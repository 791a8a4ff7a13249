/// The files of a run in the hands of other programs: ParaView (skipped where it is missing) and h5py.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/xdmf.hpp"
#include "support/sample_particles.hpp"
#include "support/temporary_directory.hpp"

namespace mpm {
namespace {

using testing::TemporaryDirectory;

constexpr double times[] = {0.0, 0.2, 1.0 / 3.0};

/// A run directory with three frames of different numbers of particles.
void write_sample_run(const std::filesystem::path& directory) {
  FrameSeries series = FrameSeries::create(directory);
  unsigned n = 100;
  for (const double t : times) {
    testing::append_frame(series, testing::random_particles(n, n), {t, 1, "0123456789abcdef", "0.1.0", 300.0, false, true});
    n += 50;
  }
}

bool command_works(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

/// Runs `command script input output` and reads the JSON that it leaves.
nlohmann::json run_script(const std::string& command, const std::string& script, const std::filesystem::path& input,
                          const std::filesystem::path& output) {
  const std::string line =
      fmt::format("{} '{}/tests/support/{}' '{}' '{}'", command, MPM_SOURCE_DIR, script, input.string(), output.string());
  const int status = std::system(line.c_str());
  if (status != 0) throw std::runtime_error(fmt::format("status {} of: {}", status, line));
  return nlohmann::json::parse(read_file(output));
}

TEST(ParaView, OpensTheFramesWithTheirTimesAndFields) {
  if (!command_works("pvpython --version")) GTEST_SKIP() << "ParaView's pvpython is not installed (Debian: paraview, python3-paraview)";
  const TemporaryDirectory dir;
  write_sample_run(dir / "run");
  std::filesystem::rename(dir / "run", dir / "moved");  // the paths inside are relative
  const nlohmann::json steps = run_script("pvpython", "check_paraview.py", dir / "moved/frames.xdmf", dir / "found.json");
  ASSERT_EQ(steps.size(), std::size(times));
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const unsigned n = 100 + 50 * static_cast<unsigned>(i);
    const ParticleTable p = testing::random_particles(n, n);
    const auto& step = steps[i];
    EXPECT_EQ(step["time"].get<double>(), times[i]);
    EXPECT_EQ(step["points"].get<unsigned>(), n);
    EXPECT_EQ(step["cells"].get<unsigned>(), n);  // one vertex a particle: without cells nothing is drawn
    const std::vector<double> position(p.position.end() - 3, p.position.end());
    const double* tau = &p.stress[6 * (n - 1)];
    const double j = p.volume_ratio.back();
    EXPECT_EQ(step["last_point"].get<std::vector<double>>(), position);
    const auto& values = step["last_values"];
    EXPECT_EQ(values["position"].get<std::vector<double>>(), position);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(values["velocity"][k].get<double>(), double{static_cast<float>(p.velocity[3 * (n - 1) + k])});
    EXPECT_EQ(values["pressure"][0].get<double>(), double{static_cast<float>(-(tau[0] + tau[1] + tau[2]) / (3.0 * j))});
    EXPECT_EQ(values["stress_xx"][0].get<double>(), double{static_cast<float>(tau[0] / j)});
    EXPECT_EQ(values["id"][0].get<std::uint64_t>(), p.id.back());
    for (const char* name : {"density", "volume_ratio", "internal"}) EXPECT_TRUE(values.contains(name)) << name;
  }
}

TEST(H5py, ReadsAFrameWithItsAttributes) {
  if (!command_works("/usr/bin/python3 -c 'import h5py'")) GTEST_SKIP() << "h5py is not installed (Debian: python3-h5py)";
  const TemporaryDirectory dir;
  write_sample_run(dir / "run");
  const nlohmann::json found = run_script("/usr/bin/python3", "check_h5py.py", frame_path(dir / "run", 2), dir / "found.json");
  EXPECT_EQ(found["attributes"]["time_s"].get<double>(), times[2]);
  EXPECT_EQ(found["attributes"]["case_hash"].get<std::string>(), "0123456789abcdef");
  EXPECT_EQ(found["attributes"]["mirror_y"].get<int>(), 1);
  EXPECT_EQ(found["shapes"]["kirchhoff_stress_pa"].get<std::vector<int>>(), (std::vector<int>{200, 6}));
  EXPECT_EQ(found["types"]["velocity_m_s"].get<std::string>(), "float32");
  const ParticleTable p = testing::random_particles(200, 200);
  EXPECT_EQ(found["last_position"].get<std::vector<double>>(), std::vector<double>(p.position.end() - 3, p.position.end()));
}

}  // namespace
}  // namespace mpm
